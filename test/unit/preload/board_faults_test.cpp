#include "raven2_trainer/preload/board_faults.h"

#include <gtest/gtest.h>

#include <string>
#include <thread>

#include "raven2_trainer/core/fault_variables.h"
#include "raven2_trainer/preload/network_faults.h"
#include "raven2_trainer/raven/board_channels.h"

namespace raven2_trainer::preload {
namespace {

using raven::UsbIn;
using raven::UsbInBytes;
using raven::UsbOut;
using raven::UsbOutBytes;
using raven::UsbRead;

Fault fault(FaultVariable variable, FaultKind kind, double value) {
  Fault f;
  f.id = 1;
  f.site = infoOf(variable).site;
  f.variable = variable;
  f.kind = kind;
  f.trigger = FaultTrigger::kPowerOn;
  f.arm = infoOf(variable).per_arm ? 0 : -1;
  f.value = value;
  return f;
}

FaultPlan planOf(const Fault& only) {
  FaultPlan plan;
  plan.generation = 1;
  plan.session = 1;
  plan.count = 1;
  plan.faults[0] = only;
  return plan;
}

const UsbInBytes kGoldIn = raven::encodeIn({0xC0, {1, 2, 3, 4, 5, 6, 7, 8}});
const UsbInBytes kGreenIn = raven::encodeIn({0xC0, {11, 12, 13, 14, 15, 16, 17, 18}});

/** Both boards, stepped by hand. */
struct Boards {
  explicit Boards(const Fault& only) : faults(planOf(only), &history) {}

  std::int32_t read(Arm arm, std::int32_t result = UsbRead::kComplete) {
    got = arm == Arm::kGold ? kGoldIn : kGreenIn;
    return faults.read(arm, result, &got, 5);
  }
  BoardFaults::Order write(Arm arm, std::uint8_t level = 0) {
    return faults.write(arm, raven::encodeOut({{100, 200, 300, 400, 500, 600, 700, 800}, level}), &out);
  }
  void cycle(std::uint8_t level = 0) {
    read(Arm::kGold);
    read(Arm::kGreen);
    write(Arm::kGold, level);
    write(Arm::kGreen, level);
  }

  CycleHistory history;
  BoardFaults faults;
  UsbInBytes got{};
  UsbOutBytes out{};
};

TEST(BoardFaults, ACycleBeginsWithTheFirstReadBehindAWrite) {
  Boards boards(fault(FaultVariable::kDac, FaultKind::kStuckAt, 1));
  boards.write(Arm::kGold);  // start-up
  EXPECT_EQ(boards.history.begun(), 0U);
  for (int retry = 0; retry < 10; ++retry)
    boards.read(Arm::kGold, UsbRead::kBusy);
  boards.read(Arm::kGreen);
  EXPECT_EQ(boards.history.begun(), 1U);
  boards.write(Arm::kGold);
  boards.write(Arm::kGreen);
  EXPECT_EQ(boards.history.begun(), 1U);
  boards.read(Arm::kGreen);
  boards.read(Arm::kGold);
  EXPECT_EQ(boards.history.begun(), 2U);
}

TEST(BoardFaults, StartUpWritesAndOtherPacketsPass) {
  Boards boards(fault(FaultVariable::kDac, FaultKind::kStuckAt, 1));
  boards.faults.write(Arm::kGold, raven::startUpWrite(), &boards.out);
  EXPECT_EQ(boards.out, raven::startUpWrite());
  boards.cycle();
  UsbOutBytes reset;
  reset.fill(0x07);  // raven2 USB_init.cpp: usb_reset_encoders
  boards.faults.write(Arm::kGold, reset, &boards.out);
  EXPECT_EQ(boards.out, reset);
}

TEST(BoardFaults, ThePedalIsTheRunLevelThatTheProgramWroteLast) {
  Fault dac = fault(FaultVariable::kDac, FaultKind::kStuckAt, 1);
  dac.trigger = FaultTrigger::kPedalDown;
  dac.first_tick = 2;
  dac.duration_ticks = 3;
  Boards boards(dac);
  boards.cycle(2);
  for (int cycle = 1; cycle < 12; ++cycle) {
    boards.read(Arm::kGold);
    boards.read(Arm::kGreen);
    boards.write(Arm::kGold, 3);
    UsbOut out;
    ASSERT_TRUE(raven::decodeOut(boards.out, &out));
    const bool acts = cycle >= 2 + 2 && cycle < 2 + 2 + 3;  // the first cycle that saw level 3 is the second
    EXPECT_EQ(out.dac[0], acts ? 1 : 100) << cycle;
    EXPECT_EQ(out.dac[3], 400) << "no fault reaches the unconnected channel";
    boards.write(Arm::kGreen, 3);
    EXPECT_EQ(boards.out, raven::encodeOut({{100, 200, 300, 400, 500, 600, 700, 800}, 3}));
  }
  ASSERT_EQ(boards.faults.log().size(), 2U);
  EXPECT_EQ(boards.faults.log()[0].change.cycle, 5U);  // counted from 1
  EXPECT_EQ(boards.faults.log()[1].change.cycle, 8U);
  EXPECT_EQ(boards.faults.log()[0].time_ns, 5);
}

TEST(BoardFaults, AReadThatFailsKeepsItsErrorWhateverAFaultSays) {
  Boards boards(fault(FaultVariable::kReadResult, FaultKind::kStuckAt, UsbRead::kComplete));
  EXPECT_EQ(boards.read(Arm::kGold, UsbRead::kBusy), UsbRead::kBusy);
  EXPECT_EQ(boards.read(Arm::kGold, 5), 5);
  EXPECT_EQ(boards.read(Arm::kGold), UsbRead::kComplete);
  EXPECT_EQ(boards.got, kGoldIn);
}

TEST(BoardFaults, TheOtherBoardsNewestPacketIsTakenForGolds) {
  Boards boards(fault(FaultVariable::kGetBoardIndex, FaultKind::kStuckAt, 1));
  boards.cycle();
  EXPECT_EQ(boards.read(Arm::kGold), UsbRead::kComplete);
  EXPECT_EQ(boards.got, kGreenIn);
  EXPECT_EQ(boards.read(Arm::kGreen), UsbRead::kComplete);
  EXPECT_EQ(boards.got, kGreenIn);
}

TEST(BoardFaults, GoldsCommandGoesToTheOtherBoard) {
  Boards boards(fault(FaultVariable::kPutBoardIndex, FaultKind::kStuckAt, 1));
  boards.cycle();
  boards.read(Arm::kGold);
  EXPECT_EQ(boards.write(Arm::kGold).board, Arm::kGreen);
  EXPECT_EQ(boards.write(Arm::kGreen).board, Arm::kGreen);
}

TEST(BoardFaults, WhereGreensBoardIsTheFirstOneBoardIsGreens) {
  Boards read(fault(FaultVariable::kGetBoardCount, FaultKind::kStuckAt, 1));
  read.faults.numberFrom(Arm::kGreen);
  EXPECT_EQ(read.read(Arm::kGreen), UsbRead::kComplete);
  EXPECT_EQ(read.read(Arm::kGold), UsbRead::kNoDevice);
  Boards written(fault(FaultVariable::kPutBoardCount, FaultKind::kStuckAt, 1));
  written.faults.numberFrom(Arm::kGreen);
  written.read(Arm::kGreen);
  EXPECT_TRUE(written.write(Arm::kGreen).is_written);
  EXPECT_FALSE(written.write(Arm::kGold).is_written);
}

TEST(BoardFaults, WhereGreensBoardIsTheFirstIndex0IsGreens) {
  Boards read(fault(FaultVariable::kGetBoardIndex, FaultKind::kStuckAt, 0));  // of gold
  read.faults.numberFrom(Arm::kGreen);
  read.read(Arm::kGreen);
  EXPECT_EQ(read.read(Arm::kGold), UsbRead::kComplete);
  EXPECT_EQ(read.got, kGreenIn);
  Boards written(fault(FaultVariable::kPutBoardIndex, FaultKind::kStuckAt, 0));
  written.faults.numberFrom(Arm::kGreen);
  written.read(Arm::kGreen);
  EXPECT_EQ(written.write(Arm::kGreen).board, Arm::kGreen);
  EXPECT_EQ(written.write(Arm::kGold).board, Arm::kGreen);
}

wire::ItpBytes packet(std::uint32_t sequence) {
  wire::ItpPacket itp;
  itp.sequence = sequence;
  itp.surgeon_mode = 1;
  return wire::encodeItp(itp);
}

class EachBoard : public ::testing::TestWithParam<Arm> {
 protected:
  static Fault own(FaultVariable variable, FaultKind kind, double value) {
    Fault made = fault(variable, kind, value);
    made.arm = static_cast<std::int8_t>(index(GetParam()));
    return made;
  }
  static const UsbInBytes& bytesOf(Arm arm) { return arm == Arm::kGold ? kGoldIn : kGreenIn; }
};

TEST_P(EachBoard, IsReadWithItsOwnFaultsAlone) {
  Boards boards(own(FaultVariable::kEncoder, FaultKind::kAdd, 100));
  for (const Arm arm : kArms) {
    EXPECT_EQ(boards.read(arm), UsbRead::kComplete);
    UsbIn in, sent;
    ASSERT_TRUE(raven::decodeIn(boards.got, &in) && raven::decodeIn(bytesOf(arm), &sent));
    for (std::size_t j = 0; j < kJointCount; ++j) {
      const std::size_t k = raven::channelOf(j);
      EXPECT_EQ(in.encoder[k] - sent.encoder[k], arm == GetParam() ? 100 : 0) << name(arm);
    }
    EXPECT_EQ(in.encoder[3], sent.encoder[3]) << "no fault reaches the unconnected channel";
  }
}

TEST_P(EachBoard, IsWrittenWithItsOwnFaultsAlone) {
  Boards boards(own(FaultVariable::kDac, FaultKind::kAdd, 7));
  boards.read(Arm::kGold);
  for (const Arm arm : kArms) {
    const BoardFaults::Order order = boards.write(arm);
    EXPECT_TRUE(order.is_written);
    EXPECT_EQ(order.board, arm);
    UsbOut out;
    ASSERT_TRUE(raven::decodeOut(boards.out, &out));
    EXPECT_EQ(out.dac[7], arm == GetParam() ? 807 : 800) << name(arm);
  }
}

TEST_P(EachBoard, KeepsItsCountsWithin24Bits) {
  for (const double end : {-8388608.0, 8388607.0}) {
    Boards boards(own(FaultVariable::kEncoder, FaultKind::kAdd, end));
    UsbIn far;
    far.encoder.fill(end > 0 ? 5 : -5);
    UsbInBytes bytes = raven::encodeIn(far);
    ASSERT_EQ(boards.faults.read(GetParam(), UsbRead::kComplete, &bytes, 0), UsbRead::kComplete);
    UsbIn in;
    ASSERT_TRUE(raven::decodeIn(bytes, &in));
    EXPECT_EQ(in.encoder[0], static_cast<std::int32_t>(end)) << "no wrap-around";
  }
}

TEST_P(EachBoard, GetsTheLastGoodPacketOfTheOtherBoardInPlaceOfItsOwn) {
  const double other = GetParam() == Arm::kGold ? 1.0 : 0.0;
  Boards boards(own(FaultVariable::kGetBoardIndex, FaultKind::kStuckAt, other));
  boards.cycle();
  boards.got.fill(0xEE);  // a failed read leaves no packet
  EXPECT_EQ(boards.faults.read(otherArm(GetParam()), UsbRead::kBusy, &boards.got, 5), UsbRead::kBusy);
  EXPECT_EQ(boards.read(GetParam()), UsbRead::kComplete);
  EXPECT_EQ(boards.got, bytesOf(otherArm(GetParam())));
}

INSTANTIATE_TEST_SUITE_P(Arms, EachBoard, ::testing::ValuesIn(kArms), [](const auto& tested) {
  return std::string(name(tested.param));
});

TEST(NetworkFaults, NothingActsOnPacketsBeforeTheFirstCycle) {
  Fault drop = fault(FaultVariable::kPacket, FaultKind::kDrop, 1.0);
  CycleHistory history;
  BoardFaults boards(planOf(drop), &history);
  NetworkFaults network(planOf(drop), &history);
  wire::ItpPacket itp;
  itp.sequence = 5;
  itp.surgeon_mode = 1;
  const wire::ItpBytes sent = wire::encodeItp(itp);
  wire::ItpBytes got{};
  network.offer(sent, 0);
  ASSERT_TRUE(network.take(&got, 0));
  EXPECT_EQ(got, sent);
  EXPECT_FALSE(network.take(&got, 0)) << "once";
  UsbInBytes in = kGoldIn;
  boards.read(Arm::kGold, UsbRead::kComplete, &in, 0);
  network.offer(sent, 0);
  EXPECT_FALSE(network.take(&got, 0));
}

TEST(NetworkFaults, ARunLevelThatTheControlThreadReachesTriggersThem) {
  for (const std::uint8_t level : {0, 1, 2, 3}) {
    Fault drop = fault(FaultVariable::kPacket, FaultKind::kDrop, 1.0);
    drop.trigger = FaultTrigger::kRunLevel;
    drop.threshold = 2.0;
    CycleHistory history;
    NetworkFaults network(planOf(drop), &history);
    history.append(level);
    network.offer(wire::encodeItp(wire::ItpPacket{}), 0);
    wire::ItpBytes bytes;
    EXPECT_EQ(network.take(&bytes, 0), level != 2) << int{level};
  }
}

TEST(NetworkFaults, APacketBeforeTheFirstCycleCanBeRepeated) {
  Fault frozen = fault(FaultVariable::kPacket, FaultKind::kHoldLast, 0);
  CycleHistory history;
  NetworkFaults network(planOf(frozen), &history);
  const auto sendMoving = [&](std::uint32_t sequence, std::int32_t um) {
    wire::ItpPacket itp;
    itp.sequence = sequence;
    itp.delx_um[0] = um;
    network.offer(wire::encodeItp(itp), 0);
    wire::ItpBytes bytes{};
    EXPECT_TRUE(network.take(&bytes, 0));
    EXPECT_EQ(wire::decodeItp(bytes.data(), bytes.size(), &itp), Reject::kNone);
    EXPECT_EQ(itp.sequence, sequence);
    return itp.delx_um[0];
  };
  EXPECT_EQ(sendMoving(1, 30), 30);
  history.append(0);
  EXPECT_EQ(sendMoving(2, 7), 30);
}

/** By these numbers, merge_truth finds the ticks of a session without a common clock. */
TEST(NetworkFaults, ChangesOfEitherThreadHaveTheNumberOfTheNewestPacket) {
  FaultPlan plan = planOf(fault(FaultVariable::kPacket, FaultKind::kDrop, 1.0));
  plan.faults[0].trigger = FaultTrigger::kPacket;
  plan.faults[0].first_tick = 2;
  plan.faults[0].duration_ticks = 1;
  plan.faults[plan.count] = fault(FaultVariable::kDac, FaultKind::kStuckAt, 1);
  plan.faults[plan.count].first_tick = 3;
  plan.faults[plan.count].row = 1;
  ++plan.count;
  CycleHistory history;
  BoardFaults boards(plan, &history);
  NetworkFaults network(plan, &history);
  const auto cycle = [&] {
    UsbInBytes in = kGoldIn;
    UsbOutBytes out;
    boards.read(Arm::kGold, UsbRead::kComplete, &in, 0);
    boards.write(Arm::kGold, raven::encodeOut({}), &out);
  };
  cycle();
  for (std::uint32_t sequence = 41; sequence <= 45; ++sequence) {
    network.offer(packet(sequence), 0);
    wire::ItpBytes bytes;
    while (network.take(&bytes, 0)) {
    }
    cycle();
  }
  ASSERT_EQ(network.log().size(), 2U);
  EXPECT_EQ(network.log()[0].command, 43U) << "the third with the pedal down";
  EXPECT_EQ(network.log()[1].command, 44U);
  ASSERT_EQ(boards.log().size(), 1U);
  EXPECT_EQ(boards.log()[0].command, 43U) << "the fourth cycle";
}

TEST(NetworkFaults, TheTruthHasTheCycleOfAFaultThoughNoPacketCameInIt) {
  FaultPlan plan = planOf(fault(FaultVariable::kPacket, FaultKind::kDrop, 1.0));
  plan.faults[0].first_tick = 2;
  plan.faults[0].duration_ticks = 1;
  CycleHistory history;
  BoardFaults boards(plan, &history);
  NetworkFaults network(plan, &history);
  for (int k = 0; k < 6; ++k) {
    UsbInBytes in = kGoldIn;
    UsbOutBytes out;
    boards.read(Arm::kGold, UsbRead::kComplete, &in, 0);
    boards.write(Arm::kGold, raven::encodeOut({}), &out);
  }
  network.offer(packet(1), 0);
  ASSERT_EQ(network.log().size(), 2U);
  EXPECT_EQ(network.log()[0].change.cycle, 3U);
  EXPECT_EQ(network.log()[1].change.cycle, 4U);
}

TEST(CycleHistory, CountsPacketsFromTheFirstPedalDownOn) {
  CycleHistory history;
  for (int k = 0; k < 3; ++k)
    history.countPacket(false, 1);
  EXPECT_EQ(history.packets(), 0U);
  history.countPacket(true, 2);
  history.countPacket(false, 3);
  EXPECT_EQ(history.packets(), 2U);
}

/** As they run in a control program: neither waits for the other. Under ThreadSanitizer this is the test. */
TEST(BoardFaults, TwoThreadsCountTheSameCyclesAndPackets) {
  constexpr std::uint32_t kPackets = 20000;
  FaultPlan plan = planOf(fault(FaultVariable::kPacket, FaultKind::kDrop, 1.0));
  plan.faults[0].trigger = FaultTrigger::kPacket;
  plan.faults[0].first_tick = 100;
  plan.faults[0].duration_ticks = 50;
  plan.faults[plan.count] = fault(FaultVariable::kDac, FaultKind::kStuckAt, 1);
  plan.faults[plan.count].trigger = FaultTrigger::kPacket;
  plan.faults[plan.count].first_tick = 1000;
  plan.faults[plan.count].row = 1;
  ++plan.count;
  CycleHistory history;
  BoardFaults boards(plan, &history);
  NetworkFaults network(plan, &history);
  UsbOutBytes out;
  UsbInBytes in = kGoldIn;
  const auto cycle = [&] {
    boards.read(Arm::kGold, UsbRead::kComplete, &in, 0);
    boards.write(Arm::kGold, raven::encodeOut({}), &out);
  };
  cycle();  // nothing acts on packets before the first cycle, and either thread may be the first
  std::uint32_t taken = 0;
  std::thread receiver([&] {
    wire::ItpBytes bytes;
    for (std::uint32_t i = 1; i <= kPackets; ++i) {
      network.offer(packet(i), 0);
      while (network.take(&bytes, 0))
        ++taken;
    }
  });
  for (int i = 0; i < 20000; ++i)
    cycle();
  receiver.join();
  for (int i = 0; i < 100; ++i)  // 256 packets a cycle are counted
    cycle();
  EXPECT_EQ(taken, kPackets - 50U);
  EXPECT_EQ(history.begun(), 20101U);
  EXPECT_EQ(history.packets(), kPackets);
  ASSERT_EQ(boards.log().size(), 1U) << "a thousand packets have come";
}

}  // namespace
}  // namespace raven2_trainer::preload
