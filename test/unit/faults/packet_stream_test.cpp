#include "raven2_trainer/faults/packet_stream.h"

#include <gtest/gtest.h>

#include <algorithm>
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
  int um;  // motion of gold along x in the packet
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
  // ten packets: two blocks, and two packets that come in reverse order when the fault ends
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

FaultEngine engineOf(const Fault& fault) {
  FaultPlan plan;
  plan.generation = 1;
  plan.count = 1;
  plan.faults[0] = fault;
  FaultEngine engine(FaultHost::kRelay);
  engine.setPlan(plan);
  return engine;
}

/** Fault of a kind of stream at work from cycle 5 to 14, with figures that make it hold something back. */
Fault atWork(FaultKind kind) {
  Fault fault = onStream(kind);
  fault.channel = 0;
  fault.value = kind == FaultKind::kDrop ? 0.5 : 3.0;
  fault.low = fault.high = 8.0;
  return fault;
}

constexpr FaultKind kStreamKinds[] = {FaultKind::kDrop,   FaultKind::kDelay, FaultKind::kDuplicate, FaultKind::kReorder,
                                      FaultKind::kReplay, FaultKind::kForge, FaultKind::kHoldLast};

/** Both arms, rotation, grasp and pedal: all that a packet moves, derived from its number. */
MasterCommand moving(int number) {
  MasterCommand command;
  command.sequence = static_cast<std::uint32_t>(number);
  command.pedal = number % 2 == 0 ? kSurgeonsPedal : 0;
  for (const Arm arm : kArms) {
    const double n = (arm == Arm::kGold ? 1.0 : -1.0) * number;
    at(command.dp_I, arm) = {1e-6 * n, 2e-6 * n, 3e-6 * n};
    at(command.dq_I, arm) = {0.001 * n, 0.0, 0.0, 1.0};
    at(command.dgrasp, arm) = 0.01 * n;
  }
  return command;
}

bool isMotionOf(const MasterCommand& a, const MasterCommand& b) {
  return a.pedal == b.pedal && a.dp_I == b.dp_I && a.dq_I == b.dq_I && a.dgrasp == b.dgrasp;
}

TEST(PacketStream, EveryPacketIsAccountedForWhateverActs) {
  for (const FaultKind kind : kStreamKinds) {
    FaultEngine engine = engineOf(atWork(kind));
    CommandStream stream(FaultVariable::kPacket);
    std::uint64_t offered = 0, taken = 0;
    for (int cycle = 0; cycle < 40; ++cycle) {
      engine.beginCycle({true, 3, {}});
      MasterCommand command = moving(cycle);
      if (cycle < 30) stream.offer(command, &engine), ++offered;
      while (stream.take(&command, engine))
        ++taken;
      if (cycle == 8) stream.clear();
      const FaultedPackets counts = stream.counts();
      ASSERT_EQ(offered + counts.added, taken + counts.lost + counts.held)
          << kFaultKindNames[static_cast<std::size_t>(kind)] << ", cycle " << cycle;
    }
    EXPECT_TRUE(stream.isEmpty());
    EXPECT_EQ(stream.counts().held, 0U);
  }
}

/** The packets that come out for those from `number` on. @param[out] cycles in which each comes, if wanted. */
std::vector<MasterCommand> follow(CommandStream* stream,
                                  FaultEngine* engine,
                                  int number,
                                  int count,
                                  std::vector<int>* cycles = nullptr) {
  std::vector<MasterCommand> out;
  for (int i = 0; i < count; ++i) {
    engine->beginCycle({true, 3, {}});
    MasterCommand command = moving(number + i);
    stream->offer(command, engine);
    while (stream->take(&command, *engine)) {
      out.push_back(command);
      if (cycles != nullptr) cycles->push_back(i);
    }
  }
  return out;
}

TEST(PacketStream, ClearedItIsAsOneThroughWhichNothingWent) {
  for (const FaultKind kind : kStreamKinds) {
    for (const int until : {3, 7, 10, 13, 16}) {
      FaultEngine engine = engineOf(atWork(kind));
      CommandStream used(FaultVariable::kPacket), fresh(FaultVariable::kPacket);
      follow(&used, &engine, 0, until);
      used.clear();
      EXPECT_TRUE(used.isEmpty());
      FaultEngine same = engine;  // which draws the same numbers
      std::vector<int> cycles, expected_cycles;
      const auto after = follow(&used, &engine, 100, 30, &cycles);
      const auto expected = follow(&fresh, &same, 100, 30, &expected_cycles);
      EXPECT_EQ(cycles, expected_cycles) << kFaultKindNames[static_cast<std::size_t>(kind)] << " " << until;
      ASSERT_EQ(after.size(), expected.size()) << kFaultKindNames[static_cast<std::size_t>(kind)] << " " << until;
      for (std::size_t i = 0; i < after.size(); ++i) {
        EXPECT_EQ(after[i].sequence, expected[i].sequence) << kFaultKindNames[static_cast<std::size_t>(kind)];
        EXPECT_TRUE(isMotionOf(after[i], expected[i])) << kFaultKindNames[static_cast<std::size_t>(kind)];
      }
    }
  }
}

TEST(PacketStream, AReplayTakesEverythingThatMovesFromTheWindowEachTimeItComes) {
  Fault fault = atWork(FaultKind::kReplay);  // windows of three packets
  fault.duration_ticks = 4;
  fault.period_ticks = 20;
  FaultEngine engine = engineOf(fault);
  CommandStream stream(FaultVariable::kPacket);
  const std::vector<MasterCommand> out = follow(&stream, &engine, 0, 60);
  ASSERT_EQ(out.size(), 60U);
  for (int n = 0; n < 60; ++n) {
    const int since = (n - 5) % 20;
    const bool acts = n >= 5 && since < 4;
    const int replayed = acts ? n - since - 3 + since % 3 : n;
    EXPECT_EQ(out[static_cast<std::size_t>(n)].sequence, static_cast<std::uint32_t>(n));
    EXPECT_TRUE(isMotionOf(out[static_cast<std::size_t>(n)], moving(replayed))) << n;
  }
}

TEST(PacketStream, AForgedPacketMovesItsArmAlongItsAxisWithThePedalDown) {
  for (const std::int8_t forged_arm : {-1, 0, 1}) {
    for (std::int8_t axis = 0; axis < 3; ++axis) {
      Fault fault = atWork(FaultKind::kForge);
      fault.arm = forged_arm;
      fault.channel = axis;
      fault.value = -400.0;
      FaultEngine engine = engineOf(fault);
      CommandStream stream(FaultVariable::kPacket);
      const std::vector<MasterCommand> out = follow(&stream, &engine, 0, 7);
      ASSERT_EQ(out.size(), 9U);
      for (const std::size_t i : {6U, 8U}) {  // behind the true packets 5 and 6: one with the pedal up, one down
        MasterCommand expected = out[i - 1];
        for (const Arm arm : kArms) {
          if (forged_arm < 0 || static_cast<std::size_t>(forged_arm) == index(arm))
            at(expected.dp_I, arm)[static_cast<std::size_t>(axis)] = -400.0 * 1e-6;
        }
        expected.pedal = kSurgeonsPedal;
        EXPECT_EQ(out[i].sequence, out[i - 1].sequence + 8);
        EXPECT_TRUE(isMotionOf(out[i], expected)) << int{forged_arm} << " " << int{axis};
      }
    }
  }
}

TEST(PacketStream, AnIntermittentFaultRestsInItsHalfPeriods) {
  Fault fault = atWork(FaultKind::kDrop);
  fault.value = 1.0;
  fault.half_period_ticks = 2;
  std::vector<int> lost;
  const std::vector<Out> all = through(fault, 20);
  for (int n = 0; n < 20; ++n) {
    if (std::none_of(all.begin(), all.end(), [n](const Out& o) { return o.sequence == n; })) lost.push_back(n);
  }
  EXPECT_EQ(lost, (std::vector<int>{5, 6, 9, 10, 13, 14}));
}

TEST(PacketStream, AReplayArmedAgainBeginsWithTheFirstPacketOfItsWindow) {
  FaultEngine engine(FaultHost::kRelay);
  CommandStream stream(FaultVariable::kPacket);
  const auto next = [&](int number) {  // as the loops do it: with nothing armed a packet passes by
    engine.beginCycle({true, 3, {}});
    MasterCommand command = moving(number);
    if (!engine.isArmed() && stream.isEmpty()) {
      stream.pass(command);
      return command;
    }
    stream.offer(command, &engine);
    EXPECT_TRUE(stream.take(&command, engine));
    return command;
  };
  FaultPlan plan;
  int number = 0;
  for (std::uint32_t time = 0; time < 3; ++time) {
    for (int k = 0; k < 10; ++k, ++number)
      EXPECT_TRUE(isMotionOf(next(number), moving(number)));
    ++plan.generation;
    plan.count = 1;
    plan.faults[0] = atWork(FaultKind::kReplay);  // windows of three packets
    plan.faults[0].trigger = FaultTrigger::kHand;
    plan.faults[0].first_tick = plan.faults[0].duration_ticks = 0;
    plan.faults[0].arming = time;
    engine.setPlan(plan);
    const int onset = number;
    for (int k = 0; k < 4; ++k, ++number)
      EXPECT_TRUE(isMotionOf(next(number), moving(onset - 3 + k % 3))) << time << " " << k;
    ++plan.generation;
    plan.count = 0;
    engine.setPlan(plan);
  }
}

TEST(PacketStream, AReplayLongerThanWhatWasSentRepeatsAllThatWas) {
  Fault fault = onStream(FaultKind::kReplay);
  fault.value = 100;
  EXPECT_EQ(part(through(fault, 40), 5, 12),
            (std::vector<Out>{
                {5, 5, 100}, {6, 6, 101}, {7, 7, 102}, {8, 8, 103}, {9, 9, 104}, {10, 10, 100}, {11, 11, 101}}));
}

}  // namespace
}  // namespace raven2_trainer::faults
