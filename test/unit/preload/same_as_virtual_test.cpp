#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "raven2_trainer/core/fault_variables.h"
#include "raven2_trainer/preload/board_faults.h"
#include "raven2_trainer/preload/network_faults.h"
#include "unit/raven/raven_fixture.h"

// Compares two virtual Ravens. One has faults in its own hooks. The other is unchanged, with the same faults between it
// and its boards and socket. The boards of both get the same bytes in every cycle.

namespace raven2_trainer::preload {
namespace {

using raven::UsbIn;
using raven::UsbInBytes;
using raven::UsbOutBytes;
using raven::UsbRead;
using raven::test::quickHoming;
using raven::test::trainerConfig;

constexpr int kCycles = 700;
constexpr int kEngaged = 50;  // from here on the PLC says pedal down

struct Row {
  FaultVariable variable;
  FaultKind kind;
  double value;
  int channel{-1};
  FaultTrigger trigger{FaultTrigger::kPedalDown};
};

FaultPlan planOf(const std::vector<Row>& rows, Arm arm) {
  FaultPlan plan;
  plan.generation = 1;
  plan.session = 1;
  for (const Row& row : rows) {
    Fault& fault = plan.faults[plan.count];
    fault.id = 1;
    fault.row = static_cast<std::uint8_t>(plan.count++);
    fault.site = infoOf(row.variable).site;
    fault.variable = row.variable;
    fault.kind = row.kind;
    fault.trigger = row.trigger;
    fault.arm = infoOf(row.variable).per_arm ? static_cast<std::int8_t>(index(arm)) : std::int8_t{-1};
    fault.channel = static_cast<std::int8_t>(row.channel);
    fault.value = row.value;
    fault.low = -std::abs(row.value);
    fault.high = std::abs(row.value);
    fault.first_tick = 60;
    fault.duration_ticks = 40;
    fault.period_ticks = 150;
    fault.ramp_ticks = 10;
    fault.seed = 7;
    EXPECT_TRUE(isSound(fault)) << infoOf(row.variable).name;
  }
  return plan;
}

std::uint8_t pinsAt(int cycle) {
  const RunLevel level = cycle < kEngaged ? RunLevel::kPedalUp : RunLevel::kPedalDown;
  return static_cast<std::uint8_t>(static_cast<unsigned>(level) << raven::pins::kLevelShift);
}

/** Motors that swing slowly by a few counts, so that commands differ from cycle to cycle. */
PerArm<UsbInBytes> boardsAt(int cycle) {
  PerArm<UsbInBytes> boards;
  for (const Arm arm : kArms) {
    UsbIn in;
    in.pins = pinsAt(cycle);
    for (std::size_t k = 0; k < in.encoder.size(); ++k)
      in.encoder[k] = std::abs((cycle / 4 + static_cast<int>(3 * k + 5 * index(arm))) % 16 - 8);
    at(boards, arm) = raven::encodeIn(in);
  }
  return boards;
}

wire::ItpBytes packetAt(int cycle) {
  wire::ItpPacket packet;
  packet.sequence = static_cast<std::uint32_t>(cycle + 1);
  packet.surgeon_mode = cycle >= kEngaged - 20 ? 1 : 0;
  packet.delx_um = {100 * (cycle % 7 - 3), 100 * (cycle % 5 - 2)};
  packet.grasp_mrad = {cycle % 3 - 1, 0};
  packet.checksum = wire::itpChecksum(packet);
  return wire::encodeItp(packet);
}

struct Robot {
  Robot() : software(trainerConfig().arms, quickHoming()) { software.startAtHome(); }
  void receive(const wire::ItpBytes& bytes) { software.receive(bytes.data(), bytes.size()); }
  raven::ControlSoftware software;
};

/** The unchanged program, behind the faults. */
struct Surrounded {
  explicit Surrounded(const FaultPlan& plan) : boards(plan, &history), network(plan, &history) {}

  void receive(const wire::ItpBytes& bytes) {
    network.offer(bytes, 0);
    wire::ItpBytes next;
    while (network.take(&next, 0))
      robot.receive(next);
  }

  void cycle(const PerArm<UsbInBytes>& in) {
    PerArm<UsbRead> reads;
    for (const Arm arm : kArms) {
      UsbRead& read = at(reads, arm);
      read.bytes = at(in, arm);
      read.result = boards.read(arm, read.result, &read.bytes, 0);
    }
    const PerArm<UsbOutBytes> out = robot.software.cycle(reads);
    for (const Arm arm : kArms) {
      UsbOutBytes bytes;
      const BoardFaults::Order order = boards.write(arm, at(out, arm), &bytes);
      if (order.is_written) at(sent, order.board) = bytes;
    }
  }

  CycleHistory history;
  BoardFaults boards;
  NetworkFaults network;
  Robot robot;
  PerArm<UsbOutBytes> sent{};
};

/** Cycles in which the boards got something else than without any fault. */
int compare(const std::vector<Row>& rows, Arm arm = Arm::kGold) {
  const FaultPlan plan = planOf(rows, arm);
  Robot inside, clean;
  inside.software.setFaults(plan);
  Surrounded outside(plan);
  int corrupted = 0;
  for (int cycle = 0; cycle < kCycles; ++cycle) {
    for (Robot* robot : {&inside, &clean})
      robot->receive(packetAt(cycle));
    outside.receive(packetAt(cycle));
    const PerArm<UsbInBytes> in = boardsAt(cycle);
    const PerArm<UsbOutBytes> expected = inside.software.cycle(in);
    const PerArm<UsbOutBytes> untouched = clean.software.cycle(in);
    outside.cycle(in);
    EXPECT_EQ(outside.sent, expected) << infoOf(rows[0].variable).name << " in cycle " << cycle;
    if (outside.sent != expected) return -1;
    corrupted += expected != untouched ? 1 : 0;
  }
  return corrupted;
}

TEST(SameAsVirtual, TheCleanRobotTeleoperates) {
  Robot robot;
  for (int cycle = 0; cycle < kCycles; ++cycle) {
    robot.receive(packetAt(cycle));
    robot.software.cycle(boardsAt(cycle));
  }
  EXPECT_EQ(robot.software.state().runlevel, RunLevel::kPedalDown);
  EXPECT_EQ(robot.software.state().homed, 1);
  EXPECT_EQ(robot.software.state().soft_estopped, 0);
  EXPECT_NE(robot.software.state().arms[0].dac[0], 0);
}

TEST(SameAsVirtual, WithNothingToDoAllIsAsItWas) {
  EXPECT_EQ(compare({{FaultVariable::kDac, FaultKind::kAdd, 0.0}}), 0);
}

TEST(SameAsVirtual, WhatIsWritten) {
  for (const Row& row :
       {Row{FaultVariable::kDac, FaultKind::kStuckAt, 800, 0}, Row{FaultVariable::kDac, FaultKind::kRandom, 2000},
        Row{FaultVariable::kDac, FaultKind::kRandomOnce, 20000},
        Row{FaultVariable::kDac, FaultKind::kAddAndHold, 100000, 1},
        Row{FaultVariable::kOutputs, FaultKind::kStuckAt, 0}, Row{FaultVariable::kOutputs, FaultKind::kHoldLast, 0},
        Row{FaultVariable::kPutBoardCount, FaultKind::kStuckAt, 1},
        Row{FaultVariable::kPutBoardCount, FaultKind::kStuckAt, 0},
        Row{FaultVariable::kPutBoardIndex, FaultKind::kStuckAt, 2}})
    EXPECT_GT(compare({row}), 30);
}

TEST(SameAsVirtual, WhatIsRead) {
  for (const Row& row :
       {Row{FaultVariable::kEncoder, FaultKind::kStuckAt, 0}, Row{FaultVariable::kEncoder, FaultKind::kAdd, 40, 0},
        Row{FaultVariable::kEncoder, FaultKind::kRandom, 30}, Row{FaultVariable::kBuffer, FaultKind::kScale, 0, 0},
        Row{FaultVariable::kInputs, FaultKind::kStuckAt, 0},
        Row{FaultVariable::kReadResult, FaultKind::kStuckAt, UsbRead::kBusy},
        Row{FaultVariable::kReadResult, FaultKind::kStuckAt, 12},
        Row{FaultVariable::kGetBoardCount, FaultKind::kStuckAt, 1},
        Row{FaultVariable::kGetBoardIndex, FaultKind::kStuckAt, 2}})
    EXPECT_GT(compare({row}), 20) << infoOf(row.variable).name;
}

TEST(SameAsVirtual, WhatIsReceived) {
  for (const Row& row :
       {Row{FaultVariable::kPacket, FaultKind::kDrop, 1.0}, Row{FaultVariable::kPacket, FaultKind::kDrop, 0.3},
        Row{FaultVariable::kIncrement, FaultKind::kAdd, 20, 1},
        Row{FaultVariable::kIncrement, FaultKind::kAdd, 20, 1, FaultTrigger::kPacket},
        Row{FaultVariable::kSequence, FaultKind::kStuckAt, 0}, Row{FaultVariable::kPedal, FaultKind::kStuckAt, 0}})
    EXPECT_GT(compare({row}), 20) << infoOf(row.variable).name;
}

TEST(SameAsVirtual, TriggersOfBothThreads) {
  for (const FaultTrigger trigger : {FaultTrigger::kPowerOn, FaultTrigger::kHand, FaultTrigger::kPacket})
    EXPECT_GT(compare({{FaultVariable::kDac, FaultKind::kStuckAt, 800, 0, trigger}}), 30);
}

TEST(SameAsVirtual, RowsOfBothThreadsAtOnce) {
  EXPECT_GT(compare({{FaultVariable::kDac, FaultKind::kRandom, 2000},
                     {FaultVariable::kEncoder, FaultKind::kAdd, 40, 0},
                     {FaultVariable::kPacket, FaultKind::kDrop, 0.5},
                     {FaultVariable::kOutputs, FaultKind::kStuckAt, 0, -1, FaultTrigger::kPacket}}),
            30);
}

TEST(SameAsVirtual, FaultsOnGreen) {
  for (const Row& row :
       {Row{FaultVariable::kDac, FaultKind::kRandom, 2000}, Row{FaultVariable::kOutputs, FaultKind::kStuckAt, 0},
        Row{FaultVariable::kPutBoardIndex, FaultKind::kStuckAt, 2},
        Row{FaultVariable::kPutBoardIndex, FaultKind::kStuckAt, 0},
        Row{FaultVariable::kEncoder, FaultKind::kAdd, 40, 0}, Row{FaultVariable::kBuffer, FaultKind::kScale, 0, 0},
        Row{FaultVariable::kInputs, FaultKind::kStuckAt, 0},
        Row{FaultVariable::kReadResult, FaultKind::kStuckAt, UsbRead::kBusy},
        Row{FaultVariable::kGetBoardIndex, FaultKind::kStuckAt, 2},
        Row{FaultVariable::kGrasp, FaultKind::kAdd, 20}})
    EXPECT_GT(compare({row}, Arm::kGreen), 20) << infoOf(row.variable).name;
}

TEST(SameAsVirtual, ReplayedPackets) {
  EXPECT_GT(compare({{FaultVariable::kPacket, FaultKind::kHoldLast, 0}}), 20);
  EXPECT_GT(compare({{FaultVariable::kPacket, FaultKind::kReplay, 5}}), 20);
}

}  // namespace
}  // namespace raven2_trainer::preload
