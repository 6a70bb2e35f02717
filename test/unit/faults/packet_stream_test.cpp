#include "raven2_trainer/faults/packet_stream.h"

#include <gtest/gtest.h>

#include <vector>

namespace raven2_trainer::faults {
namespace {

/** On the relayed stream, in cycles 5 to 14. */
Fault onStream(FaultKind kind) {
  Fault fault;
  fault.id = 1;
  fault.host = FaultHost::kRelay;
  fault.site = FaultSite::kNetworkLayer;
  fault.variable = FaultVariable::kPacket;
  fault.kind = kind;
  fault.trigger = FaultTrigger::kPowerOn;
  fault.arm = 0;
  fault.first_tick = 5;
  fault.duration_ticks = 10;
  return fault;
}

struct Out {
  int cycle;
  int sequence;
  int um;  // of gold's x: what the packet moves
  bool operator==(const Out& other) const {
    return cycle == other.cycle && sequence == other.sequence && um == other.um;
  }
};

std::ostream& operator<<(std::ostream& out, const Out& o) {
  return out << "{" << o.cycle << "," << o.sequence << "," << o.um << "}";
}

/** One packet a cycle, numbered as the cycles, moving 100 + its number. */
std::vector<Out> through(const Fault& fault, int cycles) {
  FaultPlan plan;
  plan.generation = 1;
  plan.count = 1;
  plan.faults[0] = fault;
  FaultEngine engine(FaultHost::kRelay);
  engine.setPlan(plan);
  CommandStream stream(FaultVariable::kPacket);
  std::vector<Out> out;
  for (int cycle = 0; cycle < cycles; ++cycle) {
    engine.beginCycle({true, 3, {}});
    MasterCommand command;
    command.sequence = static_cast<std::uint32_t>(cycle);
    command.dp_I[0][0] = (100 + cycle) * 1e-6;
    stream.offer(command, &engine);
    while (stream.take(&command, engine))
      out.push_back({cycle, static_cast<int>(command.sequence), static_cast<int>(command.dp_I[0][0] * 1e6 + 0.5)});
  }
  return out;
}

std::vector<Out> clean(int from, int to) {
  std::vector<Out> out;
  for (int i = from; i < to; ++i)
    out.push_back({i, i, 100 + i});
  return out;
}

std::vector<Out> part(const std::vector<Out>& all, int from, int to) {
  std::vector<Out> out;
  for (const Out& o : all) {
    if (o.cycle >= from && o.cycle < to) out.push_back(o);
  }
  return out;
}

TEST(PacketStream, IsCleanBeforeAndBehindEveryFault) {
  for (const FaultKind kind : {FaultKind::kDrop, FaultKind::kDuplicate, FaultKind::kReorder, FaultKind::kReplay,
                               FaultKind::kHoldLast, FaultKind::kForge}) {
    Fault fault = onStream(kind);
    fault.value = kind == FaultKind::kDrop ? 1.0 : 2.0;
    fault.channel = 0;
    const std::vector<Out> all = through(fault, 40);
    EXPECT_EQ(part(all, 0, 5), clean(0, 5)) << kFaultKindNames[static_cast<std::size_t>(kind)];
    EXPECT_EQ(part(all, 16, 40), clean(16, 40)) << kFaultKindNames[static_cast<std::size_t>(kind)];
  }
}

TEST(PacketStream, DropsTheShareItIsTold) {
  Fault fault = onStream(FaultKind::kDrop);
  fault.value = 1.0;
  EXPECT_TRUE(part(through(fault, 40), 5, 15).empty());
  fault.value = 0.25;
  fault.duration_ticks = 10000;
  const auto left = part(through(fault, 10005), 5, 10005).size();
  EXPECT_NEAR(static_cast<double>(left), 7500.0, 4 * 43.3);  // deviation sqrt(10,000 0.25 0.75)
}

TEST(PacketStream, DelaysInOrderAndLetsTheRestComeWhenItIsDue) {
  Fault fault = onStream(FaultKind::kDelay);
  fault.low = fault.high = 3;
  const std::vector<Out> all = through(fault, 40);
  EXPECT_TRUE(part(all, 5, 8).empty());
  EXPECT_EQ(part(all, 8, 9), (std::vector<Out>{{8, 5, 105}}));
  // The last delayed one, 14, is due in cycle 17; those behind it, though not delayed, do not overtake it.
  EXPECT_EQ(part(all, 17, 19),
            (std::vector<Out>{{17, 14, 114}, {17, 15, 115}, {17, 16, 116}, {17, 17, 117}, {18, 18, 118}}));
  ASSERT_EQ(all.size(), 40U);
  for (std::size_t i = 0; i < all.size(); ++i)
    EXPECT_EQ(all[i].sequence, static_cast<int>(i));
}

TEST(PacketStream, RandomDelaysStayInTheirRange) {
  Fault fault = onStream(FaultKind::kDelay);
  fault.low = 0;
  fault.high = 20;
  fault.duration_ticks = 0;
  int largest = 0;
  for (const Out& o : through(fault, 3000)) {
    EXPECT_GE(o.cycle, o.sequence);
    largest = std::max(largest, o.cycle - o.sequence);
  }
  EXPECT_GT(largest, 15);
  EXPECT_LE(largest, 20);
}

TEST(PacketStream, DuplicatesKeepTheirNumber) {
  Fault fault = onStream(FaultKind::kDuplicate);
  fault.value = 2;
  EXPECT_EQ(part(through(fault, 40), 5, 6), (std::vector<Out>{{5, 5, 105}, {5, 5, 105}, {5, 5, 105}}));
}

TEST(PacketStream, ReordersWholeBlocksAndWhatIsLeftOfOne) {
  Fault fault = onStream(FaultKind::kReorder);
  fault.value = 4;
  const std::vector<Out> all = through(fault, 40);
  EXPECT_TRUE(part(all, 5, 8).empty());
  EXPECT_EQ(part(all, 8, 9), (std::vector<Out>{{8, 8, 108}, {8, 7, 107}, {8, 6, 106}, {8, 5, 105}}));
  // ten packets: two blocks, and two packets that come turned round when the fault ends
  EXPECT_EQ(part(all, 12, 15).size(), 4U);
  EXPECT_EQ(part(all, 15, 16), (std::vector<Out>{{15, 15, 115}, {15, 14, 114}, {15, 13, 113}}));
  EXPECT_EQ(all.size(), 40U);
}

TEST(PacketStream, ReplaysTheWindowBeforeOnsetUnderTheTrueNumbers) {
  Fault fault = onStream(FaultKind::kReplay);
  fault.value = 3;
  const std::vector<Out> all = part(through(fault, 40), 5, 12);
  EXPECT_EQ(all, (std::vector<Out>{
                     {5, 5, 102}, {6, 6, 103}, {7, 7, 104}, {8, 8, 102}, {9, 9, 103}, {10, 10, 104}, {11, 11, 102}}));
}

TEST(PacketStream, HoldLastFreezesTheMotion) {
  const std::vector<Out> all = part(through(onStream(FaultKind::kHoldLast), 40), 5, 15);
  for (const Out& o : all)
    EXPECT_EQ(o.um, 104);
  EXPECT_EQ(all.size(), 10U);
}

TEST(PacketStream, ForgedPacketsComeBehindTheTrueOnes) {
  Fault fault = onStream(FaultKind::kForge);
  fault.value = 4000;
  fault.low = 10;
  fault.channel = 0;
  EXPECT_EQ(part(through(fault, 40), 5, 6), (std::vector<Out>{{5, 5, 105}, {5, 15, 4000}}));
}

TEST(PacketStream, HoldsNoMoreThanItHasRoomFor) {
  Fault fault = onStream(FaultKind::kDelay);
  fault.low = fault.high = 500;
  fault.duration_ticks = 0;
  FaultPlan plan;
  plan.generation = 1;
  plan.count = 1;
  plan.faults[0] = fault;
  FaultEngine engine(FaultHost::kRelay);
  engine.setPlan(plan);
  CommandStream stream(FaultVariable::kPacket);
  std::uint64_t came = 0;
  for (int cycle = 0; cycle < 2000; ++cycle) {
    engine.beginCycle({true, 3, {}});
    MasterCommand command;
    for (int i = 0; i < 3; ++i)
      stream.offer(command, &engine);
    while (stream.take(&command, engine))
      ++came;
  }
  EXPECT_GT(stream.counts().lost, 0U);
  EXPECT_LE(6000U - came - stream.counts().lost, 512U);
}

}  // namespace
}  // namespace raven2_trainer::faults
