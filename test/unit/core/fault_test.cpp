#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "raven2_trainer/core/fault_variables.h"

namespace raven2_trainer {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

/** A fault with every number that its kind uses in the middle of its range. */
Fault faultOf(FaultVariable variable, FaultKind kind) {
  Fault fault;
  fault.id = 1;
  fault.variable = variable;
  fault.site = infoOf(variable).site;
  fault.kind = kind;
  for (const FaultHost host : {FaultHost::kRobot, FaultHost::kRelay, FaultHost::kConsole}) {
    if (serves(host, fault.site)) fault.host = host;
  }
  fault.channel = 0;
  fault.probability = 0.5;
  return fault;
}

/** A number of a fault, with its lowest and highest valid value (doc/hazards.md, core/fault_variables.h). */
struct Range {
  const char* what;
  Fault fault;
  double Fault::*number;
  double low, high;
};

Range rangeOfValue(const char* what, FaultVariable variable, FaultKind kind, double low, double high) {
  return {what, faultOf(variable, kind), &Fault::value, low, high};
}

std::vector<Range> ranges() {
  using V = FaultVariable;
  using K = FaultKind;
  Fault random = faultOf(V::kForceOffset, K::kRandom), delay = faultOf(V::kPacket, K::kDelay);
  random.low = -1.0, random.high = 2.0;
  delay.low = 10.0, delay.high = 20.0;
  return {
      {"threshold", faultOf(V::kDac, K::kSignFlip), &Fault::threshold, 0.0, 1e6},
      {"probability", faultOf(V::kDac, K::kSignFlip), &Fault::probability, 0.0, 1.0},
      rangeOfValue("stuck_at", V::kForceOffset, K::kStuckAt, -3.3, 3.3),
      rangeOfValue("add", V::kDac, K::kAdd, -1e6, 1e6),
      rangeOfValue("ramp", V::kEncoder, K::kRamp, -8388608.0, 8388607.0),
      rangeOfValue("scale", V::kDac, K::kScale, -1e6, 1e6),
      {"random, low", random, &Fault::low, -3.3, 2.0},
      {"random, high", random, &Fault::high, -1.0, 3.3},
      rangeOfValue("drop", V::kPacket, K::kDrop, 0.0, 1.0),
      {"delay, low", delay, &Fault::low, 0.0, 20.0},
      {"delay, high", delay, &Fault::high, 10.0, 500.0},
      rangeOfValue("duplicate", V::kFrame, K::kDuplicate, 1.0, 8.0),
      rangeOfValue("reorder", V::kPacket, K::kReorder, 2.0, 64.0),
      rangeOfValue("replay", V::kPacket, K::kReplay, 1.0, 500.0),
      {"forge, ahead", faultOf(V::kPacket, K::kForge), &Fault::low, -1e6, 1e6},
      rangeOfValue("forge, um", V::kPacket, K::kForge, -2147483648.0, 2147483647.0),
      rangeOfValue("impair", V::kPacket, K::kImpair, 0.0, 1000.0),
  };
}

bool isSoundWith(Range range, double number) {
  range.fault.*range.number = number;
  return isSound(range.fault);
}

TEST(Fault, IsSoundFromTheLowestToTheHighestOfEachNumberAndNotBeyond) {
  for (const Range& range : ranges()) {
    const double beyond = 1e-6 * (range.high - range.low);
    EXPECT_TRUE(isSoundWith(range, range.low)) << range.what;
    EXPECT_TRUE(isSoundWith(range, range.high)) << range.what;
    EXPECT_FALSE(isSoundWith(range, range.low - beyond)) << range.what;
    EXPECT_FALSE(isSoundWith(range, range.high + beyond)) << range.what;
    for (const double bad : {kNan, kInf, -kInf})
      EXPECT_FALSE(isSoundWith(range, bad)) << range.what;
  }
}

TEST(Fault, IsSoundUpToAMillionHoursOfEachTimeAndNeverWithANegativeOne) {
  constexpr std::int64_t kLongest = std::int64_t{1} << 42U;  // [ms] 1.2 million hours
  for (const auto time :
       {&Fault::duration_ticks, &Fault::period_ticks, &Fault::half_period_ticks, &Fault::ramp_ticks}) {
    Fault fault = faultOf(FaultVariable::kDac, FaultKind::kRamp);
    for (const std::int64_t ticks : {std::int64_t{-1}, std::int64_t{0}, kLongest, kLongest + 1}) {
      fault.*time = ticks;
      EXPECT_EQ(isSound(fault), ticks >= 0 && ticks <= kLongest) << ticks;
    }
  }
  Fault fault = faultOf(FaultVariable::kDac, FaultKind::kRamp);
  for (const std::int64_t sign : {-1, 1}) {  // a fault that was due long ago is valid
    fault.first_tick = sign * kLongest;
    EXPECT_TRUE(isSound(fault));
    fault.first_tick = sign * (kLongest + 1);
    EXPECT_FALSE(isSound(fault));
  }
}

TEST(Fault, IsSoundOnlyWhereItsHostCanApplyIt) {
  Fault forge = faultOf(FaultVariable::kPacket, FaultKind::kForge);
  EXPECT_TRUE(isSound(forge));
  forge.channel = -1;
  EXPECT_FALSE(isSound(forge)) << "a forged packet moves one axis";
  for (std::size_t host = 0; host < kFaultHostCount; ++host) {
    Fault impair = faultOf(FaultVariable::kPacket, FaultKind::kImpair);
    impair.host = static_cast<FaultHost>(host);
    EXPECT_EQ(isSound(impair), impair.host == FaultHost::kRelay) << kFaultHostNames[host];
  }
  Fault last = faultOf(FaultVariable::kDac, FaultKind::kSignFlip);
  last.row = kMaxFaults - 1;
  EXPECT_TRUE(isSound(last));
  last.row = kMaxFaults;
  EXPECT_FALSE(isSound(last)) << "a mask has eight bits";
}

TEST(Fault, HasAsManyChannelsAsItsVariable) {
  for (std::size_t i = 1; i < kFaultVariableCount; ++i) {
    const auto variable = static_cast<FaultVariable>(i);
    for (std::size_t k = 1; k < kFaultKindCount; ++k) {
      Fault fault = faultOf(variable, static_cast<FaultKind>(k));
      fault.value = fault.low = fault.high = 2.0;
      if (!isSound(fault)) continue;
      fault.channel = static_cast<std::int8_t>(channelsOf(variable).count - 1);
      EXPECT_TRUE(isSound(fault)) << infoOf(variable).name;
      ++fault.channel;
      EXPECT_FALSE(isSound(fault)) << infoOf(variable).name;
    }
  }
}

}  // namespace
}  // namespace raven2_trainer
