#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <memory>

#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/control/axis_map.h"
#include "raven2_trainer/loop/haptic_loop.h"

// Tests how the haptic loop combines its parts: which force each part wants, which path and which centre of the
// workspace it uses, and when the part acts.

namespace raven2_trainer::loop {
namespace {

constexpr double kRounding = 1e-12;

class HapticParts : public ::testing::Test {
 protected:
  HapticParts() {
    config = config::loadTrainerConfig(RAVEN2_TRAINER_SOURCE_DIR "/config/trainer.yaml");
    config.haptics.guidance.enabled = config.haptics.edge.enabled = true;
    robot.frame = robot.connected = 1;
    model.linked = model.pedal = 1;
    path.plan = 4;
    path.arm = Arm::kGold;
    path.count = 2;
    path.points_B[1] = {0.1, 0.0, 0.0};
  }

  /** Runs one tick with fresh states. */
  HapticState tick() {
    if (!loop) loop = std::make_unique<HapticLoop>(config, &shared);
    now_ns += kTickNanoseconds;
    ++model.tick;
    model.time_ns = robot.received_ns = now_ns;
    shared.model.store(model);
    shared.robot.store(robot);
    loop->tick(now_ns);
    HapticRecord record;
    while (shared.haptic_records.tryPop(&record)) {
    }
    while (shared.force_packets.tryPop(&packet)) {
    }
    return record.haptic;
  }

  HapticState ticks(int n) {
    HapticState last;
    for (int i = 0; i < n; ++i)
      last = tick();
    return last;
  }

  /** Puts the tips of model and robot at one place: no deviation, so no cue. */
  void putTips(Arm arm, const Vec3& p_B) { at(model.arms, arm).p_BT = at(robot.arms, arm).p_BT = p_B; }

  TrainerConfig config;
  SharedState shared;
  std::unique_ptr<HapticLoop> loop;
  ModelState model;
  RobotState robot;
  GuidePath path;
  ForcePacket packet;  ///< the newest
  std::int64_t now_ns{1'000'000'000};
};

TEST_F(HapticParts, TheForceGoesThroughTheAxesOfEachArm) {
  // raven2.md 1.4: gold x = -itp z, y = -itp x, z = +itp y; green x = -itp z, y = +itp x, z = -itp y
  at(robot.arms, Arm::kGold).p_BT = {-0.010, 0.0, 0.0};
  at(robot.arms, Arm::kGreen).p_BT = {0.0, -0.006, -0.008};
  const HapticState state = ticks(100);
  // from the robot to the model, 150 N/m times 10 mm
  EXPECT_NEAR((toEigen(state.force_B[0]) - Vector3(1.5, 0.0, 0.0)).norm(), 0.0, kRounding);
  EXPECT_NEAR((toEigen(state.force_I[0]) - Vector3(0.0, 0.0, -1.5)).norm(), 0.0, kRounding);
  EXPECT_NEAR((toEigen(state.force_B[1]) - Vector3(0.0, 0.9, 1.2)).norm(), 0.0, kRounding);
  EXPECT_NEAR((toEigen(state.force_I[1]) - Vector3(0.9, -1.2, 0.0)).norm(), 0.0, kRounding);
}

/** A console that starts now takes PEDAL_UP for a robot that is ready. */
TEST_F(HapticParts, TheConsoleIsNotToldTheLastRunLevelOfARobotThatIsGone) {
  robot.runlevel = RunLevel::kPedalUp;
  tick();
  EXPECT_EQ(packet.runlevel, static_cast<std::uint8_t>(RunLevel::kPedalUp));
  robot.connected = 0;
  tick();
  EXPECT_EQ(packet.runlevel, static_cast<std::uint8_t>(RunLevel::kEStop));
}

TEST_F(HapticParts, AFaultOfTheConsoleScalesAndShiftsTheForceOfItsArm) {
  at(robot.arms, Arm::kGold).p_BT = {-0.010, 0.0, 0.0};      // 1.5 N along x, as above
  at(robot.arms, Arm::kGreen).p_BT = {0.0, -0.006, -0.008};  // 0.9 N along y and 1.2 N along z
  model.faults.console = 1;
  model.faults.force_gain = {0.5, -1.0};
  model.faults.force_offset_B = {Vec3{0.0, 0.2, 0.0}, Vec3{0.3, 0.0, 0.0}};
  const HapticState state = ticks(200);
  EXPECT_NEAR((toEigen(state.force_B[0]) - Vector3(0.75, 0.2, 0.0)).norm(), 0.0, kRounding);
  EXPECT_NEAR((toEigen(state.force_B[1]) - Vector3(0.3, -0.9, -1.2)).norm(), 0.0, kRounding);
}

TEST_F(HapticParts, AfterItForgotItKnowsItselfOnceBothArmsHadTheirRest) {
  for (const Arm felt : kArms) {
    loop.reset();
    tick();
    loop->forget();
    at(robot.arms, felt).p_BT = {-0.010, 0.0, 0.0};
    ticks(1000);
    EXPECT_FALSE(loop->knowsItself()) << name(felt) << " still feels a force";
    at(robot.arms, felt).p_BT = at(model.arms, felt).p_BT;
    ticks(1000);
    EXPECT_TRUE(loop->knowsItself()) << name(felt);
  }
}

TEST_F(HapticParts, APathGuidesItsOwnArmWithThePedalDownAndFadesIn) {
  putTips(Arm::kGold, {0.05, 0.004, 0.0});
  putTips(Arm::kGreen, {0.05, 0.004, 0.0});
  shared.guide_path.store(path);
  EXPECT_EQ(ticks(50).guidance_B[0], Vec3{}) << "no plan guides yet";
  model.guide_plan = 4;
  HapticState state = tick();
  EXPECT_EQ(state.guide_plan, 4U);
  EXPECT_NEAR(state.guidance_B[0][1], -0.4 / 500, kRounding);
  state = ticks(249);
  EXPECT_NEAR(state.guidance_B[0][1], -0.2, 1e-9) << "half of 100 N/m times 4 mm after half of 0.5 s";
  state = ticks(600);
  EXPECT_NEAR(state.guidance_B[0][1], -0.4, kRounding);
  EXPECT_NEAR(state.force_B[0][1], -0.4, 1e-9);
  EXPECT_EQ(state.guidance_B[1], Vec3{}) << "the green arm has no path";
  // THEN with the pedal up, another plan, or a lost link the guidance ends at once and begins again from zero
  model.pedal = 0;
  EXPECT_EQ(tick().guidance_B[0], Vec3{});
  model.pedal = 1;
  EXPECT_NEAR(tick().guidance_fade[0], 0.002, kRounding);
  model.guide_plan = 5;
  state = tick();
  EXPECT_EQ(state.guidance_B[0], Vec3{});
  EXPECT_EQ(state.guide_plan, 0U) << "the path of plan 5 has not arrived yet";
  path.plan = 5;
  shared.guide_path.store(path);
  EXPECT_EQ(tick().guide_plan, 5U);
  ticks(500);
  model.linked = 0;
  EXPECT_EQ(tick().guidance_B[0], Vec3{});
  EXPECT_EQ(ticks(50).force_B[0], Vec3{});
}

TEST_F(HapticParts, OpposedOnesLeaveNoForceWhenTheyEndTogether) {
  putTips(Arm::kGold, {0.05, 0.008, 0.0});
  at(robot.arms, Arm::kGold).p_BT[1] -= 0.8 / 150.0;
  shared.guide_path.store(path);
  model.guide_plan = 4;
  const HapticState both = ticks(800);
  ASSERT_NEAR(both.cue_B[0][1], 0.8, 1e-9);
  ASSERT_NEAR(both.guidance_B[0][1], -0.8, 1e-9);
  double before = toEigen(both.force_B[0]).norm();
  ASSERT_LT(before, 0.01);
  model.linked = 0;
  for (int i = 0; i < 50; ++i) {
    const double force = toEigen(tick().force_B[0]).norm();
    EXPECT_LE(force, before + kRounding) << i;
    before = force;
  }
}

TEST_F(HapticParts, OpposedOnesLeaveNothingBehindInARestHoweverShort) {
  config.haptics.passivity.rest = config.haptics.passivity.max_delay = 0.0;
  putTips(Arm::kGold, {0.05, 0.008, 0.0});
  at(robot.arms, Arm::kGold).p_BT[1] -= 0.8 / 150.0;
  shared.guide_path.store(path);
  model.guide_plan = 4;
  ASSERT_NEAR(ticks(800).guidance_B[0][1], -0.8, 1e-9);
  model.linked = 0;
  ASSERT_EQ(ticks(3).force_B[0], Vec3{});
  // WHEN the link comes back, model and robot together, THEN the guidance begins from zero
  putTips(Arm::kGold, {0.05, 0.008, 0.0});
  model.linked = 1;
  for (int k = 0; k < 50; ++k) {
    const HapticState state = tick();
    ASSERT_NEAR(state.force_B[0][1], state.guidance_B[0][1], kRounding) << k;
  }
}

TEST_F(HapticParts, PedalDownIsTheMiddleOfTheWorkspace) {
  const Matrix3 toBase = control::itpToBase(Arm::kGold);
  tick();
  // 80 mm of the hand to the right are 8 mm of the tip at scale 0.1
  model.master_I[0] = {0.0, 0.0079, 0.0};
  HapticState state = tick();
  EXPECT_NEAR(state.hand_I[0][1], 0.079, kRounding);
  const Vector3 force_I = toBase.transpose() * toEigen(state.edge_B[0]);
  EXPECT_NEAR(force_I.y(), -1.5 * (3 * 0.81 - 2 * 0.729), 1e-9) << "9 of the 10 mm before the edge";
  EXPECT_NEAR(force_I.x(), 0.0, kRounding);
  EXPECT_EQ(state.edge_B[1], Vec3{});
  // WHEN the pedal goes up and the hand comes back untracked
  model.pedal = 0;
  tick();
  model.pedal = 1;
  state = tick();
  EXPECT_EQ(state.hand_I[0], Vec3{});
  EXPECT_EQ(state.edge_B[0], Vec3{});
}

TEST_F(HapticParts, TheEdgePushesEitherHandBackFromEachFaceAndNotTheOtherHand) {
  for (const Arm arm : kArms) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (const double sign : {-1.0, 1.0}) {
        loop.reset();
        model.master_I = {};
        tick();
        at(model.master_I, arm)[axis] = sign * 0.1 * 0.5 * config.haptics.edge.size_I[axis];  // at scale 0.1
        const HapticState state = ticks(200);
        Vec3 expected{};
        expected[axis] = -1.5 * sign;
        EXPECT_NEAR((toEigen(at(state.force_I, arm)) - toEigen(expected)).norm(), 0.0, 1e-9)
            << name(arm) << ", axis " << axis << ", " << sign;
        EXPECT_EQ(at(state.force_I, otherArm(arm)), Vec3{}) << name(arm);
      }
    }
  }
}

TEST_F(HapticParts, AHandThatTakesThePedalFromAClientIsInTheMiddle) {
  tick();
  model.master_I[0] = {0.0, 0.0079, 0.0};
  tick();
  model.pedal = 0;
  tick();
  model.pedal = kClientsPedal;
  HapticState state = ticks(50);
  EXPECT_NEAR(state.hand_I[0][1], 0.079, kRounding) << "the position at which the surgeon's pedal went up";
  model.pedal = kSurgeonsPedal;  // no tick with the pedal up in between
  state = tick();
  EXPECT_EQ(state.hand_I[0], Vec3{});
  EXPECT_EQ(state.edge_B[0], Vec3{});
}

TEST_F(HapticParts, OrTheStartIsForAMasterThatSendsItsMotionAllTheTime) {
  config.haptics.edge.origin = WorkspaceOrigin::kStart;
  tick();
  model.master_I[0] = {0.0, 0.0079, 0.0};
  EXPECT_NEAR(tick().hand_I[0][1], 0.079, kRounding);
  model.pedal = 0;
  model.master_I[0] = {0.0, 0.0029, 0.0};
  tick();
  model.pedal = 1;
  EXPECT_NEAR(tick().hand_I[0][1], 0.029, kRounding);
}

TEST_F(HapticParts, TheWholeIsCappedAndThePartsAreOnRecord) {
  putTips(Arm::kGold, {0.05, 0.015, 0.0});
  at(robot.arms, Arm::kGold).p_BT[0] -= 0.05;  // 50 mm: 7.5 N of the spring, saturated
  model.guide_plan = 4;
  shared.guide_path.store(path);
  tick();
  model.master_I[0] = {-0.009, 0.0, 0.0};
  const HapticState state = ticks(800);
  EXPECT_NEAR(toEigen(state.cue_B[0]).norm(), 3.3, kRounding);
  EXPECT_NEAR(toEigen(state.guidance_B[0]).norm(), 1.0, kRounding);
  EXPECT_NEAR(toEigen(state.edge_B[0]).norm(), 1.5, kRounding);
  EXPECT_LE(toEigen(state.force_B[0]).norm(), 3.3 + kRounding);
  EXPECT_GT(toEigen(state.force_B[0]).norm(), 3.2);
  const Vector3 sum = toEigen(state.cue_B[0]) + toEigen(state.guidance_B[0]) + toEigen(state.edge_B[0]);
  EXPECT_NEAR(toEigen(state.force_B[0]).cross(sum).norm(), 0.0, 1e-6) << "in the direction of their sum";
}

/** Guidance in phase with the hand's motion: the tip is at (0.05, y) of the path, and the hand moves with the force. */
class Priority : public HapticParts {
 protected:
  Priority() {
    config.haptics.passivity.hand_damping = 0.0;  // the ports' accounts alone decide
    model.guide_plan = 4;
    shared.guide_path.store(path);
  }

  /** 0.5 N of guidance to and fro in 0.2 s, the hand 5 mm to either side in phase with the force: 8 mJ a period. */
  HapticState swingInGuidance(int k, double deviation = 0.0) {
    const double phase = 2.0 * kPi * k / 200.0;
    putTips(Arm::kGold, {0.05, -0.005 * std::cos(phase), 0.0});
    at(robot.arms, Arm::kGold).p_BT[0] -= deviation;
    // B's y is I's -x; the force on the hand is +y where cos > 0
    model.master_I[0] = {-0.0005 * std::sin(phase), 0.0, 0.0};
    return tick();
  }
};

TEST_F(Priority, TheCueNeverPaysForWhatGuidanceGave) {
  // GIVEN guidance that swings the hand until its account is used up
  config.haptics.edge.enabled = false;
  HapticState state;
  for (int k = 0; k < 6000; ++k) {
    state = swingInGuidance(k);
    ASSERT_EQ(state.gain[0], 1.0) << k;
  }
  // guidance yields: at half of the budget nothing of it is left, and the energy stops growing
  ASSERT_GT(state.energy[0], state.allowance[0] - 0.501 * config.haptics.passivity.budget);
  ASSERT_GT(toEigen(state.guidance_B[0]).norm(), 0.1);
  EXPECT_LT(toEigen(state.force_B[0]).norm(), 1e-3) << "the guidance gives no force";
  // WHEN the robot jumps 10 mm
  for (int k = 6000; k < 6050; ++k)
    state = swingInGuidance(k, 0.010);
  // THEN the whole cue is felt
  EXPECT_EQ(state.gain[0], 1.0);
  EXPECT_NEAR(state.cue_B[0][0], 1.5, 1e-9);
  EXPECT_NEAR((toEigen(state.force_B[0]) - toEigen(state.cue_B[0])).norm(), 0.0, 1e-3);
}

TEST_F(Priority, GuidanceYieldsToTheEdgeAndBothToTheCue) {
  // GIVEN the gains that a port's account gives as it is used up: by guidance along the edge's own direction
  config.haptics.edge.origin = WorkspaceOrigin::kStart;
  double guidance_gone_at = 0.0;  // [J] left
  for (int k = 0; k < 12000; ++k) {
    const double phase = 2.0 * kPi * k / 200.0;
    const double sign = std::cos(phase) > 0.0 ? 1.0 : -1.0;
    putTips(Arm::kGold, {0.05, -0.005 * std::cos(phase), 0.0});
    // 79 mm to the right: 1.458 N of the edge, across the motion
    model.master_I[0] = {-0.0005 * std::sin(phase), k == 0 ? 0.0 : 0.0079, 0.0};
    const double left = k == 0 ? 1.0 : shared.haptic.load().allowance[0] - shared.haptic.load().energy[0];
    const HapticState state = tick();
    if (k < 600 || sign * std::cos(phase) < 0.9) continue;  // after the fade, near the largest guidance
    const double guided = std::abs(state.force_B[0][1]) / std::abs(state.guidance_B[0][1]);
    const Vector3 edge_B = toEigen(state.edge_B[0]);
    const double edged = toEigen(state.force_B[0]).dot(edge_B) / edge_B.squaredNorm();
    if (guidance_gone_at == 0.0 && guided < 0.01) guidance_gone_at = left;
    ASSERT_TRUE(edged > 0.97 || guided < 0.02) << "the edge yielded before the guidance had, at " << k;
    ASSERT_EQ(state.gain[0], 1.0) << k;
  }
  EXPECT_GT(guidance_gone_at, 0.0) << "the guidance never yielded: the test checked little";
  EXPECT_LE(guidance_gone_at, 0.75 * config.haptics.passivity.budget);
}

TEST_F(Priority, GuidanceIsNotGivenWhereTheCueHasUsedUpThePort) {
  // GIVEN a cue in phase with the motion: 1.5 N to and fro, 5 mm to either side
  config.haptics.edge.enabled = false;
  HapticState state;
  for (int k = 0; k < 4000; ++k) {
    const double phase = 2.0 * kPi * k / 200.0;
    putTips(Arm::kGold, {0.05, 0.003, 0.0});
    at(robot.arms, Arm::kGold).p_BT[2] -= 0.010 * std::cos(phase);
    model.master_I[0] = {0.0, 0.0005 * std::sin(phase), 0.0};  // B's z is I's y
    state = tick();
  }
  EXPECT_EQ(state.gain[0], 0.0);
  EXPECT_NEAR(state.guidance_B[0][1], -0.3, 1e-9);
  EXPECT_NEAR(state.force_B[0][1], 0.0, 1e-9);
  EXPECT_LE(toEigen(state.force_B[0]).norm(), config.haptics.min_force + kRounding);
}

TEST_F(Priority, WhatBothAccountsHandOnIsKnownAgainAfterARest) {
  // GIVEN a loop that missed some records while guidance and cue acted, and then forgets
  HapticState recorded = tick();
  HapticLoop other(config, &shared);
  other.forget();
  int compared = 0;
  for (int k = 0; k < 6000; ++k) {
    const bool rests = k > 1000 && k < 2500;
    model.linked = model.pedal = rests ? 0 : 1;
    recorded = swingInGuidance(k, k % 500 < 200 ? 0.010 : 0.0);
    other.observe(recorded.master_I);
    const HapticState again = other.compute(model, robot, path, recorded.time_ns);
    if (other.knowsItself()) {
      ++compared;
      ASSERT_EQ(again.force_B, recorded.force_B) << k;
      ASSERT_EQ(again.energy, recorded.energy) << k;
      ASSERT_EQ(again.allowance, recorded.allowance) << k;
      ASSERT_EQ(again.gain, recorded.gain) << k;
    }
    other.account(recorded);
  }
  EXPECT_GT(compared, 3000);
}

TEST_F(HapticParts, FreeTeleoperationStaysFreeWhateverTheHandsDo) {
  // GIVEN the packaged settings, and robot and model together
  config = config::loadTrainerConfig(RAVEN2_TRAINER_SOURCE_DIR "/config/trainer.yaml");
  model.guide_plan = 4;
  shared.guide_path.store(path);
  for (int k = 0; k < 3000; ++k) {
    for (const Arm arm : kArms) {
      const Vec3 place{0.02 * std::sin(0.05 * k), 0.01 * std::cos(0.03 * k), 0.01 * std::sin(0.07 * k)};
      at(model.master_I, arm) = place;
      putTips(arm, place);
      at(robot.arms, arm).p_BT[0] += 0.0029;  // below the tolerance
    }
    const HapticState state = tick();
    ASSERT_EQ(state.force_I[0], Vec3{});
    ASSERT_EQ(state.force_I[1], Vec3{});
    ASSERT_EQ(state.energy[0], 0.0);
    ASSERT_EQ(state.gain[0], 1.0);
  }
}

TEST_F(HapticParts, WhatOneTickHandsOnStandsInItsRecord) {
  // GIVEN a loop that only receives the records of another one, as in re-simulation. The records hold a cue, guidance,
  // an edge and reduced forces.
  config.haptics.kp = 1000.0;
  HapticLoop other(config, &shared);
  model.guide_plan = 4;
  shared.guide_path.store(path);
  double least_gain = 1.0;
  for (int k = 0; k < 4000; ++k) {
    model.pedal = k % 700 < 600 ? 1 : 0;
    model.linked = model.pedal;
    const double x = 0.001 * std::sin(0.045 * k);
    model.master_I[0] = {-x, 0.008 * std::sin(0.003 * k), 0.0};  // B's y is I's -x
    putTips(Arm::kGold, {0.05, 0.003 + x, 0.0});
    const double lag = 0.004 * std::sin(0.045 * k - 4.5);  // the phase at which the force pushes the hand
    at(robot.arms, Arm::kGold).p_BT[1] -= 0.003 + lag;
    const HapticState recorded = tick();
    other.observe(recorded.master_I);
    const HapticState again = other.compute(model, robot, path, recorded.time_ns);
    ASSERT_EQ(again.force_B, recorded.force_B) << k;
    ASSERT_EQ(again.energy, recorded.energy) << k;
    ASSERT_EQ(again.gain, recorded.gain) << k;
    ASSERT_EQ(again.allowance, recorded.allowance) << k;
    ASSERT_EQ(again.guidance_fade, recorded.guidance_fade) << k;
    ASSERT_EQ(again.hand_I, recorded.hand_I) << k;
    other.account(recorded);
    least_gain = std::min(least_gain, recorded.gain[0]);
  }
  EXPECT_LT(least_gain, 0.5) << "no force was reduced: the test checked little";
}

/** By these numbers a console finds how long its packets are under way (doc/wire.md). */
TEST_F(HapticParts, AForcePacketHasItsOwnNumberAndTheNewestThatTheRobotTook) {
  for (const std::uint32_t taken : {4711U, 4712U, 4712U, 3U}) {
    robot.last_sequence = taken;
    const HapticState state = tick();
    EXPECT_EQ(packet.last_sequence, taken);
    EXPECT_EQ(packet.sequence, state.count);
  }
}

TEST_F(Priority, TheGreenPortsAccountIsItsOwn) {
  config.haptics.edge.enabled = false;
  HapticState state;
  for (int k = 0; k < 4000; ++k) {
    const double phase = 2.0 * kPi * k / 200.0;
    putTips(Arm::kGreen, {0.05, 0.003, 0.0});
    at(robot.arms, Arm::kGreen).p_BT[2] -= 0.010 * std::cos(phase);
    const Vector3 moved_B(0.0, 0.0, 0.0005 * std::sin(phase));
    model.master_I[1] = toArray(control::itpToBase(Arm::kGreen).transpose() * moved_B);
    state = tick();
  }
  EXPECT_EQ(state.gain[1], 0.0);
  EXPECT_EQ(state.gain[0], 1.0);
}

TEST_F(HapticParts, APathOfTheGreenArmGuidesItByItsOwnTip) {
  path.arm = Arm::kGreen;
  putTips(Arm::kGold, {0.05, 0.0, 0.0});
  putTips(Arm::kGreen, {0.05, 0.004, 0.0});
  shared.guide_path.store(path);
  model.guide_plan = 4;
  const HapticState state = ticks(850);
  EXPECT_NEAR(state.guidance_B[1][1], -0.4, kRounding);
  EXPECT_EQ(state.guidance_B[0], Vec3{});
}

TEST_F(HapticParts, AFaultOfTheConsoleGivesNoForceWithoutALink) {
  model.faults.console = 1;
  model.faults.force_gain = {1.0, 1.0};
  model.faults.force_offset_B = {Vec3{0.0, 0.5, 0.0}, Vec3{0.5, 0.0, 0.0}};
  ASSERT_GT(toEigen(ticks(200).force_B[0]).norm(), 0.4);
  for (const bool is_gone : {true, false}) {
    robot.connected = is_gone ? 0 : 1;
    model.linked = is_gone ? 1 : 0;
    const HapticState state = ticks(200);
    for (const Arm arm : kArms)
      EXPECT_EQ(at(state.force_B, arm), Vec3{}) << name(arm) << " " << is_gone;
  }
}

}  // namespace
}  // namespace raven2_trainer::loop
