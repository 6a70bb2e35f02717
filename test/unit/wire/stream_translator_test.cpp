#include "raven2_trainer/wire/stream_translator.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "raven2_trainer/wire/itp_gate.h"

namespace raven2_trainer::wire {
namespace {

constexpr std::array<Vec3, 3> kAsTheyAre{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};

ItpPacket still(std::uint32_t sequence = 1, std::int32_t pedal = 0) {
  ItpPacket packet{};
  packet.sequence = sequence;
  packet.Qw = {1.0, 1.0};
  packet.surgeon_mode = pedal;
  return packet;
}

StreamProfile profile() {
  StreamProfile p;
  p.is_on = true;
  return p;
}

/** Translated, and used. */
ItpPacket used(StreamTranslator* stream, ItpPacket packet) {
  stream->translate(&packet);
  stream->keep();
  return packet;
}

TEST(StreamTranslator, WithoutAProfileNothingIsTouched) {
  StreamTranslator stream{StreamProfile{}};
  ItpPacket packet = still(7, 5);
  packet.delx_um = {3, -4};
  packet.Qx = {12.0, 0.0};
  packet.grasp_mrad = {500, 2};
  const ItpBytes before = encodeItp(packet);
  EXPECT_EQ(encodeItp(used(&stream, packet)), before);
}

TEST(StreamTranslator, CountsBecomeAUnitQuaternionOfEitherArmAndSign) {
  StreamProfile p = profile();
  p.turns_in_counts = true;
  p.turn_per_count = 1e-4;
  StreamTranslator stream(p);
  for (std::size_t arm = 0; arm < kArmCount; ++arm) {
    for (const double sign : {1.0, -1.0}) {
      ItpPacket packet = still();
      packet.Qx[arm] = sign * 30;
      packet.Qy[arm] = sign * -40;
      packet.Qz[arm] = 120;
      const ItpPacket out = used(&stream, packet);
      EXPECT_NEAR(out.Qx[arm], sign * 0.003, 1e-12);
      EXPECT_NEAR(out.Qy[arm], sign * -0.004, 1e-12);
      EXPECT_NEAR(out.Qz[arm], 0.012, 1e-12);
      const double norm = std::hypot(std::hypot(out.Qx[arm], out.Qy[arm]), std::hypot(out.Qz[arm], out.Qw[arm]));
      EXPECT_NEAR(norm, 1.0, 1e-12);
      EXPECT_EQ(out.Qw[1 - arm], 1.0) << "the other arm does not turn";
      EXPECT_EQ(checkItp(out, {2000, 0.1}), Reject::kNone);
    }
  }
  ItpPacket wild = still();
  wild.Qx[1] = 2e4;  // too large for any rotation
  EXPECT_EQ(checkItp(used(&stream, wild), {2000, 0.1}), Reject::kBadQuaternion);
  wild.Qx[1] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(checkItp(used(&stream, wild), {2000, 0.1}), Reject::kNotFinite);
}

TEST(StreamTranslator, AnAbsoluteGraspBecomesHowFarItWent) {
  for (const double scale : {1.0, -2.0}) {
    StreamProfile p = profile();
    p.has_absolute_grasp = true;
    p.mrad_per_count = scale;
    StreamTranslator stream(p);
    for (std::size_t arm = 0; arm < kArmCount; ++arm) {
      stream.forget();
      ItpPacket packet = still();
      packet.grasp_mrad[arm] = 700;
      EXPECT_EQ(used(&stream, packet).grasp_mrad[arm], 0) << "the first position moves nothing";
      packet.grasp_mrad[arm] = 690;
      EXPECT_EQ(used(&stream, packet).grasp_mrad[arm], std::lround(-10 * scale));
      ItpPacket lost = packet;
      lost.grasp_mrad[arm] = 0;
      stream.translate(&lost);  // and not used: rejected for another reason
      packet.grasp_mrad[arm] = 695;
      EXPECT_EQ(used(&stream, packet).grasp_mrad[arm], std::lround(5 * scale));
      EXPECT_EQ(used(&stream, packet).grasp_mrad[1 - arm], 0);
    }
  }
}

TEST(StreamTranslator, NothingOfAGraspIsLostInRoundingNorGoesToTheOtherArm) {
  StreamProfile p = profile();
  p.mrad_per_count = 0.3;
  StreamTranslator stream(p);
  PerArm<std::int64_t> sum{};
  for (int i = 0; i < 1000; ++i) {
    ItpPacket packet = still();
    packet.grasp_mrad = {1, -3};
    const ItpPacket out = used(&stream, packet);
    EXPECT_LE(std::abs(out.grasp_mrad[0]), 1) << i;
    EXPECT_NEAR(out.grasp_mrad[1], -0.9, 1.0) << i;
    for (std::size_t arm = 0; arm < kArmCount; ++arm)
      sum[arm] += out.grasp_mrad[arm];
    EXPECT_NEAR(static_cast<double>(sum[0]), 0.3 * (i + 1), 0.51) << i;
    EXPECT_NEAR(static_cast<double>(sum[1]), -0.9 * (i + 1), 0.51) << i;
  }
}

TEST(StreamTranslator, AxesAndScaleTurnAndStretchAndNothingIsLostInRounding) {
  StreamProfile p = profile();
  p.axes = {{{0, 0, -1}, {1, 0, 0}, {0, -1, 0}}};  // right-handed: determinant 1
  p.um_per_count = 0.3;
  StreamTranslator stream(p);
  std::array<std::int64_t, 3> sum{};
  for (int i = 0; i < 1000; ++i) {
    ItpPacket packet = still();
    packet.delx_um = {1, 0};
    packet.dely_um = {2, 0};
    packet.delz_um = {3, 0};
    packet.Qx = {0.01, 0.0};
    packet.Qw = {std::sqrt(1 - 1e-4), 1.0};
    const ItpPacket out = used(&stream, packet);
    sum[0] += out.delx_um[0];
    sum[1] += out.dely_um[0];
    sum[2] += out.delz_um[0];
    EXPECT_EQ(out.delx_um[1], 0);
    EXPECT_NEAR(out.Qy[0], 0.01, 1e-12) << "the console's x is ITP's y";
  }
  EXPECT_NEAR(static_cast<double>(sum[0]), -900.0, 0.51);
  EXPECT_NEAR(static_cast<double>(sum[1]), 300.0, 0.51);
  EXPECT_NEAR(static_cast<double>(sum[2]), -600.0, 0.51);
}

/** A left-handed console: motion along x stays along x, and a right rotation becomes a left one. */
TEST(StreamTranslator, MirroredAxesTurnTheOtherWay) {
  StreamProfile p = profile();
  p.axes = kAsTheyAre;
  p.axes[1][1] = -1;
  StreamTranslator stream(p);
  ItpPacket packet = still();
  packet.dely_um = {10, 0};
  packet.Qx = {0.01, 0.0};
  packet.Qy = {0.0, 0.02};
  const ItpPacket out = used(&stream, packet);
  EXPECT_EQ(out.dely_um[0], -10);
  EXPECT_NEAR(out.Qx[0], -0.01, 1e-12);
  EXPECT_NEAR(out.Qy[1], 0.02, 1e-12) << "about the axis that is mirrored nothing changes";
}

TEST(StreamTranslator, APedalThatIsDownFromTheStartWaitsForAPress) {
  StreamProfile p = profile();
  p.waits_for_press = true;
  StreamTranslator stream(p);
  EXPECT_EQ(used(&stream, still(1, 1)).surgeon_mode, 0);
  EXPECT_EQ(used(&stream, still(2, 1)).surgeon_mode, 0);
  ItpPacket up = still(3, 0);
  stream.translate(&up);  // not used
  EXPECT_EQ(used(&stream, still(4, 1)).surgeon_mode, 0);
  EXPECT_EQ(used(&stream, still(5, 0)).surgeon_mode, 0);
  EXPECT_EQ(used(&stream, still(6, 3)).surgeon_mode, 1) << "anything but 0 is down, as to a Raven";
  stream.forget();
  EXPECT_EQ(used(&stream, still(7, 1)).surgeon_mode, 0) << "after a silence, too";
  StreamTranslator as_sent(profile());
  EXPECT_EQ(used(&as_sent, still(1, 1)).surgeon_mode, 1);
}

/** A gate with a console of absolute grasp and without clutch. The test is the console. */
struct LooseConsole {
  static ItpRules rules(double max_rate, bool is_hardened) {
    ItpRules rules;
    rules.hardened = is_hardened;
    rules.compat_timeout = 5.0;
    rules.max_increment_um = 2000;
    rules.max_rotation = 0.1;
    rules.max_rate = max_rate;
    rules.max_burst = 1;
    rules.master_timeout = 0.2;
    rules.stream.is_on = rules.stream.has_absolute_grasp = rules.stream.waits_for_press = true;
    return rules;
  }
  explicit LooseConsole(double max_rate, bool is_hardened = true)
      : gate(rules(max_rate, is_hardened), Audience::kDaemon, nullptr) {}

  Reject send(std::int64_t time_ms, std::int32_t pedal, std::int32_t grasp) {
    ItpPacket packet = still(++sequence, pedal);
    packet.grasp_mrad = {grasp, -grasp};
    const ItpBytes bytes = encodeItp(packet);
    return gate.judge({bytes.data(), bytes.size(), 1, time_ms * 1'000'000}, &got);
  }

  ItpGate gate;
  std::uint32_t sequence{0};
  ItpPacket got{};
};

TEST(StreamTranslator, AtTheGateAConsoleThatWasSilentBeginsAgain) {
  LooseConsole console(1000.0);
  ASSERT_EQ(console.send(1, 0, 100), Reject::kNone);
  ASSERT_EQ(console.send(2, 1, 110), Reject::kNone);
  EXPECT_EQ(console.got.surgeon_mode, 1);
  EXPECT_EQ(console.got.grasp_mrad, (PerArm<std::int32_t>{10, -10}));
  console.gate.idle(1'000'000'000);
  ASSERT_EQ(console.send(1001, 1, 600), Reject::kNone) << "its pedal counts as up, so it may introduce itself";
  EXPECT_EQ(console.got.surgeon_mode, 0) << "the pedal that is still down was not pressed";
  EXPECT_EQ(console.got.grasp_mrad, PerArm<std::int32_t>{}) << "where the jaws went meanwhile is no motion";
}

// The daemon lifts the pedal after pedalTimeout(): 0.2 s hardened, 5 s with a Raven's rules.
TEST(StreamTranslator, AtTheGateAPedalThatWasHeldThroughASilenceWaitsForAPress) {
  for (const bool is_hardened : {true, false}) {
    LooseConsole console(1000.0, is_hardened);
    const std::int64_t timeout_ms = is_hardened ? 200 : 5000;
    ASSERT_EQ(console.send(1, 0, 100), Reject::kNone);
    ASSERT_EQ(console.send(2, 1, 110), Reject::kNone);
    ASSERT_EQ(console.send(2 + timeout_ms, 1, 130), Reject::kNone);
    EXPECT_EQ(console.got.surgeon_mode, 1) << "a pause that is short enough";
    EXPECT_EQ(console.got.grasp_mrad, (PerArm<std::int32_t>{20, -20}));
    for (int i = 1; i <= 3; ++i) {
      ASSERT_EQ(console.send(2 * timeout_ms + 100 + i, 1, 600), Reject::kNone);
      EXPECT_EQ(console.got.surgeon_mode, 0) << is_hardened;
      EXPECT_EQ(console.got.grasp_mrad, PerArm<std::int32_t>{}) << is_hardened;
    }
    ASSERT_EQ(console.send(2 * timeout_ms + 200, 0, 600), Reject::kNone);
    ASSERT_EQ(console.send(2 * timeout_ms + 201, 1, 610), Reject::kNone);
    EXPECT_EQ(console.got.surgeon_mode, 1);
  }
}

TEST(StreamTranslator, AtTheGateAPacketAboveTheRateIsNotTheLastGrasp) {
  LooseConsole console(100.0);
  ASSERT_EQ(console.send(1000, 0, 100), Reject::kNone);
  ASSERT_EQ(console.send(1001, 0, 130), Reject::kRateLimited);
  ASSERT_EQ(console.send(1020, 0, 150), Reject::kNone);
  EXPECT_EQ(console.got.grasp_mrad, (PerArm<std::int32_t>{50, -50})) << "nothing of the motion is lost";
}

TEST(StreamTranslator, AtTheGateARefusedPacketIsNeitherTheLastGraspNorTheEndOfASilence) {
  for (const bool is_hardened : {true, false}) {
    LooseConsole console(1000.0, is_hardened);
    const std::int64_t timeout_ms = is_hardened ? 200 : 5000;
    const auto sendAgain = [&](std::int64_t time_ms, std::int32_t grasp) {
      --console.sequence;
      return console.send(time_ms, 1, grasp);
    };
    ASSERT_EQ(console.send(1, 0, 100), Reject::kNone);
    ASSERT_EQ(console.send(2, 1, 110), Reject::kNone);
    ASSERT_EQ(sendAgain(3, 400), Reject::kDuplicate);
    ASSERT_EQ(console.send(4, 1, 150), Reject::kNone);
    EXPECT_EQ(console.got.grasp_mrad, (PerArm<std::int32_t>{40, -40})) << is_hardened;
    ASSERT_EQ(sendAgain(timeout_ms - 50, 150), Reject::kDuplicate);
    ASSERT_EQ(console.send(timeout_ms + 100, 1, 150), Reject::kNone);
    EXPECT_EQ(console.got.surgeon_mode, 0) << "the daemon has lifted the pedal, it was not pressed: " << is_hardened;
  }
}

/** The packets of a dV-Trainer, through the gate that refused them. */
TEST(StreamTranslator, AtTheGateALooseConsoleIsTakenWithItsProfileAlone) {
  for (const bool has_profile : {false, true}) {
    ItpRules rules;
    rules.max_increment_um = 2000;
    rules.max_rotation = 0.1;
    rules.max_rate = 1200;
    rules.max_burst = 40;
    rules.master_timeout = 0.2;
    rules.stream.is_on = has_profile;
    rules.stream.turns_in_counts = rules.stream.has_absolute_grasp = rules.stream.waits_for_press = true;
    rules.stream.turn_per_count = 1e-4;
    ItpGate gate(rules, Audience::kDaemon, nullptr), robots(rules, Audience::kRobot, nullptr);
    int taken = 0, robots_taken = 0;
    ItpPacket packet{};
    for (int i = 0; i < 200; ++i) {
      ItpPacket sent = still(static_cast<std::uint32_t>(i + 1), i < 50 || i > 60 ? 1 : 0);
      sent.Qx = {5.0, -7.0};
      sent.Qz = {0.0, 12.0};
      sent.delx_um = {20, -20};
      sent.grasp_mrad = {1800, 1900 + i};
      const ItpBytes bytes = encodeItp(sent);
      const Arrival arrival{bytes.data(), bytes.size(), 1, (i + 1) * 1'000'000LL};
      if (gate.judge(arrival, &packet) == Reject::kNone) ++taken;
      ItpPacket other{};
      if (robots.judge(arrival, &other) == Reject::kNone) ++robots_taken;
    }
    EXPECT_EQ(taken, has_profile ? 200 : 0);
    EXPECT_EQ(robots_taken, 0) << "a robot receives only proper ITP";
    if (!has_profile) continue;
    EXPECT_EQ(packet.surgeon_mode, 1);
    EXPECT_EQ(packet.grasp_mrad, (PerArm<std::int32_t>{0, 1}));
  }
}

TEST(StreamTranslator, WhatTheBoundCutOffIsNotMadeUpForLater) {
  StreamProfile p = profile();
  p.axes = kAsTheyAre;
  p.um_per_count = 1000.0;
  StreamTranslator stream(p);
  for (const std::int32_t wild : {2147483647, -2147483647}) {
    ItpPacket packet = still();
    packet.delx_um[0] = wild;
    EXPECT_EQ(used(&stream, packet).delx_um[0], wild);
    EXPECT_EQ(used(&stream, still()).delx_um[0], 0);
  }
}

}  // namespace
}  // namespace raven2_trainer::wire
