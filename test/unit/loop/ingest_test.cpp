#include "raven2_trainer/loop/master_ingest.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "raven2_trainer/core/random.h"
#include "raven2_trainer/wire/itp.h"

namespace raven2_trainer::loop {
namespace {

constexpr std::int32_t kMaxIncrement = 5000;
constexpr std::uint64_t kMaster = 7, kStranger = 8;

ItpRules rules() {
  ItpRules r;
  r.max_increment_um = kMaxIncrement;
  r.max_rotation = 0.1;
  r.max_rate = 1200;
  r.max_burst = 40;
  r.master_timeout = 0.2;
  r.compat_timeout = 5.0;
  return r;
}

wire::ItpBytes packet(std::uint32_t sequence, std::int32_t delx = 0) {
  wire::ItpPacket p;
  p.sequence = sequence;
  p.delx_um[0] = delx;
  return wire::encodeItp(p);
}

TEST(MasterIngest, CountsEveryDatagramByItsReason) {
  auto shared = std::make_unique<SharedState>();
  MasterIngest ingest(rules(), nullptr, shared.get());
  const auto give = [&](const wire::ItpBytes& bytes, std::size_t size, bool foreign = false) {
    return ingest.receive({bytes.data(), size, foreign ? kStranger : kMaster, 0});
  };
  EXPECT_EQ(give(packet(1), wire::kItpSize), Reject::kNone);
  EXPECT_EQ(give(packet(2), wire::kItpSize - 1), Reject::kWrongSize);
  EXPECT_EQ(give(packet(2), wire::kItpSize + 10), Reject::kWrongSize);
  EXPECT_EQ(give(packet(2, kMaxIncrement + 1), wire::kItpSize), Reject::kOutOfRange);
  EXPECT_EQ(give(packet(1), wire::kItpSize), Reject::kDuplicate);
  EXPECT_EQ(give(packet(2), wire::kItpSize, /*foreign=*/true), Reject::kForeignSource);
  wire::ItpPacket nan;
  nan.sequence = 2;
  nan.Qx[1] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(give(wire::encodeItp(nan), wire::kItpSize), Reject::kNotFinite);
  EXPECT_EQ(give(packet(2), wire::kItpSize), Reject::kNone) << "the rejected packets did not move the window";
  EXPECT_EQ(ingest.counts().received, 8U);
  EXPECT_EQ(ingest.counts().applied, 2U);
  EXPECT_TRUE(ingest.counts().addsUp());
}

TEST(MasterIngest, AFullQueueIsCountedNotForgotten) {
  auto shared = std::make_unique<SharedState>();
  MasterIngest ingest(rules(), nullptr, shared.get());
  for (std::uint32_t n = 1; n <= 300; ++n)
    ingest.receive({packet(n).data(), wire::kItpSize, kMaster, n * kTickNanoseconds});
  EXPECT_EQ(ingest.counts().applied, 256U);
  EXPECT_EQ(ingest.counts().rejected[static_cast<std::size_t>(Reject::kQueueFull)], 44U);
}

TEST(MasterIngest, RandomBytesNeverBreakTheSums) {
  auto shared = std::make_unique<SharedState>();
  MasterIngest ingest(rules(), nullptr, shared.get());
  Random random(9);
  std::array<std::uint8_t, 200> bytes;
  MasterCommand command;
  for (int i = 0; i < 200000; ++i) {
    for (std::uint8_t& byte : bytes)
      byte = static_cast<std::uint8_t>(random.next());
    const std::size_t size = i % 3 == 0 ? random.next() % bytes.size() : wire::kItpSize;
    ingest.receive({bytes.data(), size, i % 7 == 0 ? kStranger : kMaster, i * kTickNanoseconds});
    while (shared->master_commands.tryPop(&command)) {
      for (const Arm arm : kArms) {
        for (const double x : at(command.dp_I, arm))
          ASSERT_TRUE(std::isfinite(x));
        for (const double x : at(command.dq_I, arm))
          ASSERT_TRUE(std::isfinite(x));
      }
    }
  }
  EXPECT_TRUE(ingest.counts().addsUp());
  EXPECT_EQ(ingest.counts().received, 200000U);
}

}  // namespace
}  // namespace raven2_trainer::loop
