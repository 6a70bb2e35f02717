#include "raven2_trainer/wire/robot_frame.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "hex.h"
#include "raven2_trainer/core/random.h"
#include "support/effort.h"

namespace raven2_trainer::wire {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

FrameBytes hello(std::uint32_t sequence, bool is_virtual = true) {
  FrameBytes bytes(kMaxFrame);
  bytes.resize(encodeHello(sequence, is_virtual, bytes.data()));
  return bytes;
}

FrameBytes state(std::uint32_t sequence, const RobotState& value) {
  FrameBytes bytes(kMaxFrame);
  bytes.resize(encodeState(sequence, value, bytes.data()));
  return bytes;
}

FrameBytes plan(std::uint32_t sequence, const FaultPlan& value) {
  FrameBytes bytes(kMaxFrame);
  bytes.resize(encodeFaultPlan(sequence, value, bytes.data()));
  return bytes;
}

/** The same pattern as the Python lines in the test StateHasTheSizeAndCrcThatPythonComputes. */
RobotState patternState() {
  RobotState value;
  value.cycle = 1000001;
  value.time_ns = 123456789012;
  value.last_sequence = 77;
  value.active_fault = 3;
  value.fault_mask = 0x81;
  value.runlevel = RunLevel::kPedalDown;
  value.sublevel = 1;
  value.homed = 1;
  for (std::size_t a = 0; a < kArmCount; ++a) {
    for (std::size_t j = 0; j < kJointCount; ++j) {
      value.arms[a].q[j] = static_cast<double>(100 * a + j) / 8.0;
      value.arms[a].dq[j] = static_cast<double>(100 * a + 10 + j) / 8.0;
      value.arms[a].motor[j] = static_cast<double>(100 * a + 20 + j) / 8.0;
      value.arms[a].dac[j] = static_cast<std::int32_t>(1000 * a + j) * (j % 2 == 0 ? 1 : -1);
    }
  }
  value.arms[0].jstate = {0, 1, 2, 3, 4, 5, 6};
  value.itp.received = 200;
  value.itp.applied = 201;
  for (std::size_t i = 0; i < kRejectCount; ++i)
    value.itp.rejected[i] = 202 + i;
  return value;
}

FaultPlan patternPlan() {
  FaultPlan value;
  value.generation = 12;
  value.session = 34;
  value.count = 1;
  value.faults[0].id = 4;
  value.faults[0].site = FaultSite::kPutUsbPacket;
  value.faults[0].host = FaultHost::kRobot;
  value.faults[0].kind = FaultKind::kStuckAt;
  value.faults[0].variable = FaultVariable::kDac;
  value.faults[0].arm = 0;
  value.faults[0].channel = 2;
  value.faults[0].row = 5;
  value.faults[0].arming = 6;
  value.faults[0].first_tick = 2000;
  value.faults[0].duration_ticks = 300;
  value.faults[0].period_ticks = 8000;
  value.faults[0].count = 3;
  value.faults[0].trigger = FaultTrigger::kRunLevel;
  value.faults[0].half_period_ticks = 30;
  value.faults[0].ramp_ticks = 40;
  value.faults[0].threshold = 2.0;
  value.faults[0].probability = 0.25;
  value.faults[0].seed = 99;
  value.faults[0].value = -1234.5;
  value.faults[0].low = -0.5;
  value.faults[0].high = 0.75;
  return value;
}

/** The only frame in these bytes; type 0: no frame. */
Frame only(FrameParser* parser, const FrameBytes& bytes) {
  parser->feed(bytes.data(), bytes.size());
  Frame frame;
  EXPECT_EQ(parser->next(&frame), FrameParser::Result::kFrame);
  return frame;
}

FaultChange patternChange() {
  FaultChange value;
  value.number = 7;
  value.cycle = 70006;
  value.session = 34;
  value.id = 4;
  value.row = 5;
  value.acts = 1;
  return value;
}

std::uint32_t crcOf(const FrameBytes& bytes) {
  std::uint32_t crc = 0xFFFFFFFFU;
  for (const std::uint8_t byte : bytes) {
    crc ^= byte;
    for (int i = 0; i < 8; ++i)
      crc = (crc >> 1U) ^ ((crc & 1U) != 0 ? 0xEDB88320U : 0U);
  }
  return ~crc;
}

void appendWord(FrameBytes* bytes, std::uint32_t word) {
  for (unsigned shift = 0; shift < 32; shift += 8)
    bytes->push_back(static_cast<std::uint8_t>(word >> shift));
}

/** A frame around any payload: header written here by hand, CRC bit by bit, so that nothing of the module is used. */
FrameBytes rawFrame(std::uint16_t type,
                    const FrameBytes& payload,
                    std::uint8_t minor = kFrameMinor,
                    std::uint8_t major = kFrameMajor) {
  FrameBytes bytes{
      'R', 'V', '2', 'T', minor, major, static_cast<std::uint8_t>(type), static_cast<std::uint8_t>(type >> 8U)};
  appendWord(&bytes, static_cast<std::uint32_t>(payload.size()));
  appendWord(&bytes, 9);
  FrameBytes covered = bytes;
  covered.insert(covered.end(), payload.begin(), payload.end());
  appendWord(&bytes, crcOf(covered));
  bytes.insert(bytes.end(), payload.begin(), payload.end());
  return bytes;
}

FrameBytes payloadOf(const FrameBytes& frame) {
  return FrameBytes(frame.begin() + kFrameHeaderSize, frame.end());
}

// ---- bytes ----------------------------------------------------------------------------------------------------------

TEST(FrameBytesOnTheWire, HelloIsWhatPythonPacks) {
  // h = struct.pack('<4sHHII', b'RV2T', 0x400, 1, 8, 5); p = b'virtual\0'
  // h + struct.pack('<I', zlib.crc32(h + p)) + p
  EXPECT_EQ(hello(5), fromHex("52563254000401000800000005000000afd964677669727475616c00"));
}

TEST(FrameBytesOnTheWire, FaultPlanIsWhatPythonPacks) {
  // struct.pack('<III', 12, 34, 1) + struct.pack('<I5B2bBIQ6q5d', 4, 0, 13, 34, 1, 4, 0, 2, 5, 6, 99, 2000, 300, 8000,
  // 3, 30,
  //                                          40, 2.0, 0.25, -1234.5, -0.5, 0.75)
  EXPECT_EQ(payloadOf(plan(1, patternPlan())),
            fromHex("0c000000220000000100000004000000000d2201040002050600000063000000"
                    "00000000d0070000000000002c01000000000000401f00000000000003000000"
                    "000000001e000000000000002800000000000000000000000000004000000000"
                    "0000d03f00000000004a93c0000000000000e0bf000000000000e83f"));
}

TEST(FrameBytesOnTheWire, FaultChangeAndPlanAnswerAreWhatPythonPacks) {
  // struct.pack('<QQ2I3B', 7, 70006, 34, 4, 0, 5, 1)
  FrameBytes bytes(kMaxFrame);
  bytes.resize(encodeFaultChange(1, patternChange(), bytes.data()));
  EXPECT_EQ(payloadOf(bytes), fromHex("070000000000000076110100000000002200000004000000000501"));
  bytes.resize(kMaxFrame);
  bytes.resize(encodePlanAnswer(1, true, bytes.data()));
  EXPECT_EQ(payloadOf(bytes), fromHex("01"));
}

TEST(FaultChangeFrame, RoundTripsAndRefusesWhatCannotBe) {
  const FrameBytes good = fromHex("070000000000000076110100000000002200000004000000000501");
  FrameParser parser;
  FaultChange got;
  ASSERT_TRUE(decodeFaultChange(only(&parser, rawFrame(5, good)), &got));
  EXPECT_EQ(got.number, 7U);
  EXPECT_EQ(got.cycle, 70006U);
  EXPECT_EQ(got.session, 34U);
  EXPECT_EQ(got.id, 4U);
  EXPECT_EQ(got.row, 5);
  EXPECT_EQ(got.acts, 1);
  struct Wrong {
    std::size_t at;
    std::uint8_t value;
  };
  for (const Wrong wrong : {Wrong{0, 0}, Wrong{24, 1}, Wrong{24, 200}, Wrong{25, 8}, Wrong{26, 2}}) {
    FrameBytes bad = good;
    bad[wrong.at] = wrong.value;
    FaultChange untouched;
    EXPECT_FALSE(decodeFaultChange(only(&parser, rawFrame(5, bad)), &untouched)) << wrong.at;
    EXPECT_EQ(untouched.number, 0U);
  }
  EXPECT_FALSE(decodeFaultChange(only(&parser, rawFrame(5, FrameBytes(22, 0))), &got));
  EXPECT_FALSE(decodeFaultChange(only(&parser, rawFrame(6, good)), &got));
}

TEST(PlanAnswerFrame, IsYesOrNo) {
  FrameParser parser;
  bool is_armed = false;
  EXPECT_TRUE(decodePlanAnswer(only(&parser, rawFrame(6, {1})), &is_armed));
  EXPECT_TRUE(is_armed);
  EXPECT_TRUE(decodePlanAnswer(only(&parser, rawFrame(6, {0})), &is_armed));
  EXPECT_FALSE(is_armed);
  EXPECT_FALSE(decodePlanAnswer(only(&parser, rawFrame(6, {2})), &is_armed));
  EXPECT_FALSE(decodePlanAnswer(only(&parser, rawFrame(6, FrameBytes{})), &is_armed));
  EXPECT_FALSE(decodePlanAnswer(only(&parser, rawFrame(5, {1})), &is_armed));
}

TEST(FrameBytesOnTheWire, StateHasTheSizeAndCrcThatPythonComputes) {
  // s = struct.pack('<QqII5B', 1000001, 123456789012, 77, 3, 3, 1, 1, 0, 0x81)
  // for a in 0, 1: for b in 0, 10, 20: s += struct.pack('<7d', *[(100*a + b + j) / 8 for j in range(7)])
  //                s += struct.pack('<7i', *[(-1)**j * (1000*a + j) for j in range(7)])
  //                s += bytes(range(7)) if a == 0 else b'\xff' * 7
  // s += struct.pack('<23Q', *range(200, 223)); h = struct.pack('<4sHHII', b'RV2T', 0x400, 2, len(s), 6)
  // len(s), hex(zlib.crc32(h + s))
  const FrameBytes bytes = state(6, patternState());
  ASSERT_EQ(bytes.size(), kFrameHeaderSize + 619);
  std::uint32_t crc = 0;
  std::memcpy(&crc, bytes.data() + 16, sizeof(crc));
  EXPECT_EQ(crc, 0xb507bbfcU);
}

// ---- round trips ----------------------------------------------------------------------------------------------------

TEST(Hello, SaysWhatTheRobotIs) {
  for (const bool is_virtual : {false, true}) {
    FrameParser parser;
    EXPECT_EQ(saysVirtual(only(&parser, hello(1, is_virtual))), is_virtual);
  }
}

TEST(Hello, WhateverDoesNotSayVirtualIsReal) {
  const std::vector<FrameBytes> words{{'V', 'i', 'r', 't', 'u', 'a', 'l', 0},
                                      {'v', 'i', 'r', 't', 'u', 'a', 'l'},
                                      {'v', 'i', 'r', 't', 'u', 'a', 'l', 0, 0},
                                      {'d', 'a', 'V', 'i', 'n', 'c', 'i', 0},
                                      {}};
  for (const FrameBytes& word : words) {
    FrameParser parser;
    EXPECT_FALSE(saysVirtual(only(&parser, rawFrame(1, word)))) << word.size();
  }
  FrameParser parser;
  EXPECT_FALSE(saysVirtual(only(&parser, rawFrame(2, {'v', 'i', 'r', 't', 'u', 'a', 'l', 0})))) << "no hello";
}

TEST(State, CarriesWhatTravelsAndLeavesTheRest) {
  FrameParser parser;
  RobotState got;
  got.frame = 55;
  got.received_ns = 66;
  got.connected = 1;
  got.is_virtual = 1;
  got.arms[1].p_BT = {1, 2, 3};
  ASSERT_EQ(decodeState(only(&parser, state(6, patternState())), &got), Reject::kNone);
  const RobotState sent = patternState();
  EXPECT_EQ(got.cycle, sent.cycle);
  EXPECT_EQ(got.time_ns, sent.time_ns);
  EXPECT_EQ(got.last_sequence, sent.last_sequence);
  EXPECT_EQ(got.active_fault, sent.active_fault);
  EXPECT_EQ(got.runlevel, sent.runlevel);
  EXPECT_EQ(got.sublevel, sent.sublevel);
  EXPECT_EQ(got.homed, sent.homed);
  EXPECT_EQ(got.soft_estopped, sent.soft_estopped);
  EXPECT_EQ(got.fault_mask, sent.fault_mask);
  for (std::size_t a = 0; a < kArmCount; ++a) {
    EXPECT_EQ(got.arms[a].q, sent.arms[a].q);
    EXPECT_EQ(got.arms[a].dq, sent.arms[a].dq);
    EXPECT_EQ(got.arms[a].motor, sent.arms[a].motor);
    EXPECT_EQ(got.arms[a].dac, sent.arms[a].dac);
    EXPECT_EQ(got.arms[a].jstate, sent.arms[a].jstate);
  }
  EXPECT_EQ(got.itp.received, 200U);
  EXPECT_EQ(got.itp.applied, 201U);
  EXPECT_EQ(got.itp.rejected, sent.itp.rejected);
  EXPECT_EQ(got.frame, 55U);
  EXPECT_EQ(got.received_ns, 66);
  EXPECT_EQ(got.connected, 1);
  EXPECT_EQ(got.is_virtual, 1);
  EXPECT_EQ(got.arms[1].p_BT, (Vec3{1, 2, 3}));
}

TEST(State, RefusesNumbersThatAreNotFinite) {
  for (const double bad : {kNan, kInf, -kInf}) {
    for (auto field : {&RobotArmState::q, &RobotArmState::dq, &RobotArmState::motor}) {
      RobotState value = patternState();
      (value.arms[1].*field)[kGrasp2] = bad;
      FrameParser parser;
      RobotState got;
      EXPECT_EQ(decodeState(only(&parser, state(1, value)), &got), Reject::kNotFinite);
      EXPECT_EQ(got.cycle, 0U);
    }
  }
}

TEST(State, RefusesUnknownRunLevelsAndFlags) {
  const FrameBytes good = payloadOf(state(1, patternState()));
  // high byte of the time stamp, run level, homed, soft E-stop, a jstate
  for (const std::size_t offset : {15U, 24U, 26U, 27U, 28U + 196U}) {
    FrameBytes payload = good;
    payload[offset] = 0x84;
    FrameParser parser;
    RobotState got;
    EXPECT_EQ(decodeState(only(&parser, rawFrame(2, payload)), &got), Reject::kOutOfRange) << offset;
  }
}

TEST(State, TakesTheJointStatesOfTheRobotAndNoOthersOfBothArms) {
  for (std::size_t arm = 0; arm < kArmCount; ++arm) {
    for (unsigned jstate = 0; jstate <= 255; ++jstate) {
      RobotState value = patternState();
      value.arms[arm].jstate[kWrist] = static_cast<std::uint8_t>(jstate);
      FrameParser parser;
      RobotState got;
      EXPECT_EQ(decodeState(only(&parser, state(1, value)), &got),
                jstate <= 6 || jstate == 255 ? Reject::kNone : Reject::kOutOfRange)
          << jstate;
    }
  }
}

TEST(State, RefusesOtherSizesAndTypes) {
  const FrameBytes good = payloadOf(state(1, patternState()));
  RobotState got;
  for (const std::size_t size : {0U, 569U, 571U, 4096U}) {
    FrameBytes payload = good;
    payload.resize(size);
    FrameParser parser;
    EXPECT_EQ(decodeState(only(&parser, rawFrame(2, payload)), &got), Reject::kWrongSize) << size;
  }
  FrameParser parser;
  EXPECT_EQ(decodeState(only(&parser, rawFrame(3, good)), &got), Reject::kBadFrame);
}

TEST(State, RefusesWhatNoEncoderAndNoAmplifierCanSay) {
  std::vector<RobotState> bad(5, patternState());
  bad[0].arms[1].motor[kShoulder] = 26355.0;  // two times 2^23 counts at 4000 a revolution are 26353.6 rad
  bad[1].arms[0].q[kGrasp2] = -1.1e4;
  bad[2].arms[0].dq[kWrist] = 1.1e7;
  bad[3].arms[0].dac[kElbow] = 32768;
  bad[4].arms[1].dac[kElbow] = -32769;
  for (const RobotState& value : bad) {
    FrameParser parser;
    RobotState got;
    EXPECT_EQ(decodeState(only(&parser, state(1, value)), &got), Reject::kOutOfRange) << &value - bad.data();
    EXPECT_EQ(got.cycle, 0U);
  }
  RobotState edge = patternState();
  edge.arms[0].motor[kShoulder] = -26353.0;
  edge.arms[0].dac[kElbow] = -32768;
  FrameParser parser;
  RobotState got;
  EXPECT_EQ(decodeState(only(&parser, state(1, edge)), &got), Reject::kNone);
}

// ---- versions -------------------------------------------------------------------------------------------------------

TEST(Version, ANewerMinorOneMayAppendToAPayloadAndAddTypes) {
  FrameBytes longer = payloadOf(state(1, patternState()));
  longer.resize(longer.size() + 100, 7);
  FrameParser parser;
  RobotState got;
  EXPECT_EQ(decodeState(only(&parser, rawFrame(2, longer, kFrameMinor + 1)), &got), Reject::kNone);
  EXPECT_EQ(got.arms[1].dac, patternState().arms[1].dac);
  EXPECT_EQ(decodeState(only(&parser, rawFrame(77, longer, kFrameMinor + 1)), &got), Reject::kBadFrame);
  longer.resize(500);
  EXPECT_EQ(decodeState(only(&parser, rawFrame(2, longer, kFrameMinor + 1)), &got), Reject::kWrongSize)
      << "shorter is never right";
}

TEST(Version, AnotherMajorOneIsRefusedAndNamed) {
  for (const std::uint8_t major : {1, 2, 255}) {
    const FrameBytes frame = rawFrame(2, payloadOf(state(1, patternState())), 4, major);
    FrameParser parser;
    parser.feed(frame.data(), frame.size());
    Frame got;
    EXPECT_EQ(parser.next(&got), FrameParser::Result::kBroken);
    EXPECT_EQ(parser.refusedVersion(), major << 8U | 4U);
    parser.reset();
    EXPECT_EQ(parser.refusedVersion(), 0U);
  }
  EXPECT_EQ(refusalText("robot", 5 << 8 | 4), "robot refused: it speaks frame version 5.4, this program 4.0");
}

TEST(Version, AStreamBrokenOtherwiseNamesNone) {
  FrameBytes frame = hello(1);
  frame.back() ^= 1;
  FrameParser parser;
  parser.feed(frame.data(), frame.size());
  Frame got;
  EXPECT_EQ(parser.next(&got), FrameParser::Result::kBroken);
  EXPECT_EQ(parser.refusedVersion(), 0U);
}

TEST(FaultPlanFrame, RoundTripsAnyNumberOfFaults) {
  for (std::uint32_t count = 0; count <= kMaxFaults; ++count) {
    FaultPlan sent;
    sent.generation = 100 + count;
    sent.session = 0xFFFFFFF0U + count;
    sent.count = count;
    for (std::uint32_t i = 0; i < count; ++i) {
      sent.faults[i] = patternPlan().faults[0];
      sent.faults[i].id = i + 1;
      sent.faults[i].channel = static_cast<std::int8_t>(i % 8) - 1;
      sent.faults[i].first_tick = -5 - static_cast<std::int64_t>(i);
    }
    FrameParser parser;
    FaultPlan got;
    ASSERT_TRUE(decodeFaultPlan(only(&parser, plan(1, sent)), &got));
    EXPECT_EQ(got.generation, sent.generation);
    EXPECT_EQ(got.session, sent.session);
    ASSERT_EQ(got.count, count);
    for (std::uint32_t i = 0; i < count; ++i) {
      EXPECT_EQ(got.faults[i].id, i + 1);
      EXPECT_EQ(got.faults[i].site, FaultSite::kPutUsbPacket);
      EXPECT_EQ(got.faults[i].kind, FaultKind::kStuckAt);
      EXPECT_EQ(got.faults[i].variable, FaultVariable::kDac);
      EXPECT_EQ(got.faults[i].channel, sent.faults[i].channel);
      EXPECT_EQ(got.faults[i].first_tick, sent.faults[i].first_tick);
      EXPECT_EQ(got.faults[i].duration_ticks, 300);
      EXPECT_EQ(got.faults[i].period_ticks, 8000);
      EXPECT_EQ(got.faults[i].count, 3);
      EXPECT_EQ(got.faults[i].trigger, FaultTrigger::kRunLevel);
      EXPECT_EQ(got.faults[i].half_period_ticks, 30);
      EXPECT_EQ(got.faults[i].ramp_ticks, 40);
      EXPECT_EQ(got.faults[i].threshold, 2.0);
      EXPECT_EQ(got.faults[i].probability, 0.25);
      EXPECT_EQ(got.faults[i].seed, 99U);
      EXPECT_EQ(got.faults[i].value, -1234.5);
      EXPECT_EQ(got.faults[i].low, -0.5);
      EXPECT_EQ(got.faults[i].high, 0.75);
    }
  }
}

TEST(FaultPlanFrame, RefusesWhatNoFaultCanBe) {
  const FaultPlan good = patternPlan();
  std::vector<FaultPlan> bad(24, good);
  bad[0].faults[0].site = static_cast<FaultSite>(kFaultSiteCount);
  bad[1].faults[0].host = static_cast<FaultHost>(kFaultHostCount);
  bad[2].faults[0].kind = static_cast<FaultKind>(kFaultKindCount);
  bad[3].faults[0].variable = static_cast<FaultVariable>(kFaultVariableCount);
  bad[4].faults[0].arm = 2;
  bad[5].faults[0].arm = -2;
  bad[6].faults[0].channel = 7;
  bad[7].faults[0].channel = -2;
  bad[8].faults[0].value = kNan;
  bad[9].faults[0].duration_ticks = -1;
  bad[10].faults[0].period_ticks = -1;
  bad[11].faults[0].count = -1;
  bad[12].faults[0].first_tick = std::numeric_limits<std::int64_t>::min();  // sums of these would overflow
  bad[13].faults[0].first_tick = std::numeric_limits<std::int64_t>::max();
  bad[14].faults[0].duration_ticks = std::numeric_limits<std::int64_t>::max();
  bad[15].faults[0].period_ticks = std::numeric_limits<std::int64_t>::max();
  bad[16].faults[0].trigger = static_cast<FaultTrigger>(kFaultTriggerCount);
  bad[17].faults[0].probability = 1.5;
  bad[18].faults[0].site = FaultSite::kGetUsbPacket;  // of another variable
  bad[19].faults[0].host = FaultHost::kRelay;         // does not serve that site
  bad[20].faults[0].kind = FaultKind::kDrop;          // not of a number
  bad[21].faults[0].low = kInf;
  bad[22].faults[0].half_period_ticks = -1;
  Fault& endless = bad[23].faults[0];  // copies without end
  endless.variable = FaultVariable::kPacket;
  endless.site = FaultSite::kNetworkLayer;
  endless.kind = FaultKind::kDuplicate;
  endless.value = 1e18;
  for (std::size_t i = 0; i < bad.size(); ++i) {
    FrameParser parser;
    FaultPlan got;
    EXPECT_FALSE(decodeFaultPlan(only(&parser, plan(1, bad[i])), &got)) << i;
    EXPECT_EQ(got.generation, 0U);
  }
}

TEST(FaultPlanFrame, RefusesACountThatDoesNotMatchTheSize) {
  for (const std::uint8_t count : {0, 2, 9, 255}) {
    FrameBytes payload = payloadOf(plan(1, patternPlan()));
    payload[8] = count;
    FrameParser parser;
    FaultPlan got;
    EXPECT_FALSE(decodeFaultPlan(only(&parser, rawFrame(3, payload)), &got)) << int{count};
  }
  FrameParser parser;
  FaultPlan got;
  EXPECT_FALSE(decodeFaultPlan(only(&parser, rawFrame(3, FrameBytes(11, 0))), &got));
}

TEST(FaultSignalsFrame, RoundTripsAndRefusesWhatNoDistanceIs) {
  const auto encoded = [](const FaultSignals& signals) {
    FrameBytes bytes(kMaxFrame);
    bytes.resize(encodeFaultSignals(3, signals, bytes.data()));
    return bytes;
  };
  FrameParser parser;
  FaultSignals got;
  const FaultSignals sent{0.0125, kInf, 7, 2};
  ASSERT_TRUE(decodeFaultSignals(only(&parser, encoded(sent)), &got));
  EXPECT_TRUE(got == sent);
  EXPECT_FALSE(decodeFaultSignals(only(&parser, encoded({-0.1, 0.0, 1, 1})), &got));
  EXPECT_FALSE(decodeFaultSignals(only(&parser, encoded({0.1, kNan, 1, 1})), &got));
  EXPECT_FALSE(decodeFaultSignals(only(&parser, encoded({kNan, 0.1, 1, 1})), &got));
  EXPECT_FALSE(decodeFaultSignals(only(&parser, encoded({0.1, -0.1, 1, 1})), &got));
  EXPECT_FALSE(decodeFaultSignals(only(&parser, plan(1, patternPlan())), &got));
  EXPECT_TRUE(got == sent);
}

// ---- framing --------------------------------------------------------------------------------------------------------

struct Taken {
  FrameType type;
  std::uint32_t sequence;
  FrameBytes payload;
  bool operator==(const Taken& other) const {
    return type == other.type && sequence == other.sequence && payload == other.payload;
  }
};

/** Takes every frame that is complete. @return the last result. */
FrameParser::Result drain(FrameParser* parser, std::vector<Taken>* taken) {
  Frame frame;
  FrameParser::Result result = parser->next(&frame);
  for (; result == FrameParser::Result::kFrame; result = parser->next(&frame)) {
    taken->push_back({frame.type, frame.sequence, FrameBytes(frame.payload, frame.payload + frame.size)});
  }
  return result;
}

void append(FrameBytes* stream, const FrameBytes& frame) {
  stream->insert(stream->end(), frame.begin(), frame.end());
}

TEST(FrameParser, AnySplitOfTheStreamGivesTheSameFrames) {
  // GIVEN a stream of all kinds of frames, one with the largest payload and one with none
  FrameBytes stream = hello(1);
  append(&stream, state(2, patternState()));
  append(&stream, rawFrame(2, {}));
  append(&stream, plan(4, patternPlan()));
  append(&stream, rawFrame(3, FrameBytes(kMaxPayload, 0xA5)));
  append(&stream, state(6, patternState()));
  std::vector<Taken> whole;
  FrameParser reference;
  reference.feed(stream.data(), stream.size());
  ASSERT_EQ(drain(&reference, &whole), FrameParser::Result::kNeedMore);
  ASSERT_EQ(whole.size(), 6U);

  // WHEN it arrives in pieces of any length, from single bytes to all at once
  Random random(1);
  const std::int64_t rounds = raven2_trainer::testing::effort(1000, 10000);
  for (std::int64_t round = 0; round < rounds; ++round) {
    FrameParser parser;
    std::vector<Taken> taken;
    const double mean = std::exp2(random.uniform(4.0, 12.0));
    for (std::size_t begin = 0; begin < stream.size();) {
      const auto wanted = static_cast<std::size_t>(random.uniform(0.0, 2.0 * mean));
      const std::size_t size = std::min(wanted, stream.size() - begin);
      parser.feed(stream.data() + begin, size);
      begin += size;
      ASSERT_EQ(drain(&parser, &taken), FrameParser::Result::kNeedMore);
    }
    // THEN the frames are the same
    ASSERT_TRUE(taken == whole) << "round " << round;
  }
}

TEST(FrameParser, WorksByteByByte) {
  FrameParser parser;
  std::vector<Taken> taken;
  for (const std::uint8_t byte : state(7, patternState())) {
    EXPECT_TRUE(taken.empty());
    parser.feed(&byte, 1);
    drain(&parser, &taken);
  }
  ASSERT_EQ(taken.size(), 1U);
  EXPECT_EQ(taken[0].sequence, 7U);
}

TEST(FrameParser, BreaksForEverOnAnyDamagedByteOfHeaderOrPayload) {
  const FrameBytes good = hello(5);
  for (std::size_t i = 0; i < good.size(); ++i) {
    for (const std::uint8_t flip : {0x01, 0x80}) {
      FrameBytes bad = good;
      bad[i] = static_cast<std::uint8_t>(bad[i] ^ flip);
      FrameParser parser;
      parser.feed(bad.data(), bad.size());
      // a longer length waits for more bytes; then the CRC is wrong
      for (int more = 0; more < 20; ++more)
        parser.feed(good.data(), good.size());
      Frame frame;
      EXPECT_EQ(parser.next(&frame), FrameParser::Result::kBroken) << i;
      parser.feed(good.data(), good.size());
      EXPECT_EQ(parser.next(&frame), FrameParser::Result::kBroken) << i;
    }
  }
}

TEST(FrameParser, BreaksOnALengthOverTheLimitBeforeThePayloadArrives) {
  FrameBytes header = hello(5);
  header.resize(kFrameHeaderSize);
  const std::uint32_t length = kMaxPayload + 1;
  std::memcpy(header.data() + 8, &length, sizeof(length));
  FrameParser parser;
  parser.feed(header.data(), header.size());
  Frame frame;
  EXPECT_EQ(parser.next(&frame), FrameParser::Result::kBroken);
}

TEST(FrameParser, BreaksOnAnUnknownType) {
  for (const std::uint16_t type : {0, 7, 256, 65535}) {
    const FrameBytes bytes = rawFrame(type, {});
    FrameParser parser;
    parser.feed(bytes.data(), bytes.size());
    Frame frame;
    EXPECT_EQ(parser.next(&frame), FrameParser::Result::kBroken) << type;
  }
}

TEST(FrameParser, GivesTheFramesBeforeTheDamage) {
  FrameBytes stream = hello(1);
  append(&stream, hello(2));
  append(&stream, FrameBytes(kFrameHeaderSize, 0));
  FrameParser parser;
  parser.feed(stream.data(), stream.size());
  std::vector<Taken> taken;
  EXPECT_EQ(drain(&parser, &taken), FrameParser::Result::kBroken);
  EXPECT_EQ(taken.size(), 2U);
}

TEST(FrameParser, StartsAfreshAfterReset) {
  FrameParser parser;
  const FrameBytes junk(100, 0xFF);
  parser.feed(junk.data(), junk.size());
  Frame frame;
  ASSERT_EQ(parser.next(&frame), FrameParser::Result::kBroken);
  parser.reset();
  EXPECT_EQ(parser.next(&frame), FrameParser::Result::kNeedMore);
  only(&parser, hello(3));
}

TEST(FrameParser, AResetForgetsWhatWasTakenAndWhatWasBegun) {
  // GIVEN a link that breaks off in the middle of a frame, behind other frames, some of which were read
  for (int taken = 0; taken <= 2; ++taken) {
    FrameParser parser;
    FrameBytes stream = hello(1);
    append(&stream, hello(2));
    const FrameBytes half = hello(3);
    stream.insert(stream.end(), half.begin(), half.begin() + 21);
    parser.feed(stream.data(), stream.size());
    Frame frame;
    for (int i = 0; i < taken; ++i)
      ASSERT_EQ(parser.next(&frame), FrameParser::Result::kFrame);
    parser.reset();
    // THEN the next link's frames come whole, from the first on
    EXPECT_EQ(parser.next(&frame), FrameParser::Result::kNeedMore);
    for (std::uint32_t number = 10; number < 13; ++number)
      EXPECT_EQ(only(&parser, hello(number)).sequence, number);
  }
}

TEST(FrameParser, BreaksRatherThanGrowWithoutBoundWhenNothingIsTaken) {
  FrameParser parser;
  const FrameBytes bytes = rawFrame(2, FrameBytes(kMaxPayload, 1));
  for (int i = 0; i < 64; ++i)
    parser.feed(bytes.data(), bytes.size());
  Frame frame;
  ASSERT_EQ(parser.next(&frame), FrameParser::Result::kFrame);  // that much still fits
  for (int i = 0; i < 2; ++i)
    parser.feed(bytes.data(), bytes.size());
  EXPECT_EQ(parser.next(&frame), FrameParser::Result::kBroken);
}

TEST(FrameParser, RandomBytesNeverGiveAFrame) {
  Random random(99);
  for (int round = 0; round < 2000; ++round) {
    FrameBytes junk(random.next() % 200);
    for (std::uint8_t& byte : junk)
      byte = static_cast<std::uint8_t>(random.next());
    if (round % 2 == 0 && junk.size() >= 8) std::copy_n(hello(1).begin(), 8, junk.begin());  // magic and version right
    FrameParser parser;
    parser.feed(junk.data(), junk.size());
    Frame frame;
    EXPECT_NE(parser.next(&frame), FrameParser::Result::kFrame);
  }
}

}  // namespace
}  // namespace raven2_trainer::wire
