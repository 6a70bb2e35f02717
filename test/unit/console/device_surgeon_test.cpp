#include "raven2_trainer/console/device_surgeon.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "console_support.h"
#include "device_bench.h"
#include "raven2_trainer/config/load_master.h"
#include "raven2_trainer/core/random.h"

namespace raven2_trainer::console {
namespace {

// ITP: x forward, y right, z down (core/frames.h)
const Vec3 kForward{1, 0, 0}, kBack{-1, 0, 0}, kRight{0, 1, 0}, kLeft{0, -1, 0}, kUp{0, 0, -1};

/** Where a family's x, y and z point, as its documentation says, and how many of its units are a metre. */
struct Published {
  const char* file;
  std::array<Vec3, 3> axes;
  double units_per_metre;
};

/** OpenHaptics: x right, y up, z to the user. phantom_omni turns that to (x, -z, y). dVRK: x left, y up, z away. */
const std::array<Published, 5> kPublished{{{"omni", {kRight, kForward, kUp}, 1000.0},
                                           {"omni_pair", {kRight, kForward, kUp}, 1000.0},
                                           {"touch_geomagic", {kRight, kUp, kBack}, 1000.0},
                                           {"crtk_pair", {kRight, kUp, kBack}, 1.0},
                                           {"mtm", {kLeft, kUp, kForward}, 1.0}}};

MasterConfig shipped(const char* name) {
  return config::findMaster(RAVEN2_TRAINER_SOURCE_DIR "/config/masters", name);
}

void expectNear(const Vec3& value, const Vec3& expected, double tolerance, const std::string& what) {
  for (std::size_t k = 0; k < 3; ++k)
    EXPECT_NEAR(value[k], expected[k], tolerance) << what << ", axis " << k;
}

Vec3 times(double factor, const Vec3& v) {
  return {factor * v[0], factor * v[1], factor * v[2]};
}

TEST(ShippedMasters, EachAxisOfTheDeviceMovesTheHandWhereItsDocumentationSaysItPoints) {
  for (const Published& family : kPublished) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      DeviceBench bench(shipped(family.file));
      bench.warmUp(1e-3 * family.units_per_metre);
      Vec3 p{};
      p[axis] = 0.012 * family.units_per_metre;
      expectNear(bench.moveTo(p).hand_I[0], times(0.012, family.axes[axis]), 1e-12,
                 std::string(family.file) + " along " + std::to_string(axis));
    }
  }
}

TEST(ShippedMasters, ForcesComeBackAlongTheSameAxes) {
  for (const Published& family : kPublished) {
    const MasterConfig master = shipped(family.file);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      Vec3 expected{};
      expected[axis] = 1.5;
      expectNear(toDevice(master, times(1.5, family.axes[axis])), expected, 1e-12, family.file);
    }
  }
}

TEST(ShippedMasters, TurnsOfTheDeviceTurnTheHandAboutTheSameAxes) {
  for (const char* file : {"touch_geomagic", "crtk_pair", "mtm"}) {
    const Published& family = *std::find_if(kPublished.begin(), kPublished.end(),
                                            [&](const Published& p) { return std::string(p.file) == file; });
    for (std::size_t axis = 0; axis < 3; ++axis) {
      DeviceBench bench(shipped(file));
      // GIVEN a device that is already rotated
      const Eigen::Quaterniond before(Eigen::AngleAxisd(0.8, Eigen::Vector3d(1, 2, 3).normalized()));
      bench.samples[0].orientation = toArray(before);
      bench.warmUp(1e-3 * family.units_per_metre);
      // WHEN it rotates by 0.3 rad about one of its base's axes
      Eigen::Vector3d about(0, 0, 0);
      about[static_cast<Eigen::Index>(axis)] = 1.0;
      Quat turn = kIdentityQuat;
      for (const double angle : {0.15, 0.3}) {
        bench.samples[0].orientation = toArray(Eigen::Quaterniond(Eigen::AngleAxisd(angle, about)) * before);
        turn = bench.tick().turn_I[0];
      }
      expectNear({turn[0], turn[1], turn[2]}, times(std::sin(0.15), family.axes[axis]), 1e-12, file);
      EXPECT_NEAR(turn[3], std::cos(0.15), 1e-12);
    }
  }
}

TEST(DeviceSurgeon, WithoutOrientationTurnsDoNotCount) {
  DeviceBench bench(testMaster());
  bench.warmUp();
  bench.samples[0].orientation = {1.0, 0.0, 0.0, 0.0};
  EXPECT_EQ(bench.tick().turn_I[0], kIdentityQuat);
}

TEST(DeviceSurgeon, ThePedalEngagesOnlyWhatWasWatchedAndMoved) {
  DeviceBench bench(testMaster());
  bench.samples[0].position = {0.05, 0.0, 0.0};
  bench.tick(300);
  bench.press();
  EXPECT_FALSE(bench.tick().pedal);
  EXPECT_EQ(bench.newest(), DeviceTrouble::kTooSoon);
  // a pedal that stays down does not engage later
  EXPECT_FALSE(bench.tick(600).pedal);
  bench.press(0);
  bench.tick();
  bench.press();
  EXPECT_FALSE(bench.tick().pedal);
  EXPECT_EQ(bench.newest(), DeviceTrouble::kNeverMoved);
  EXPECT_NE(bench.said().find("calibrate"), std::string::npos);
  bench.press(0);
  bench.warmUp();
  bench.press();
  EXPECT_TRUE(bench.tick().pedal);
  EXPECT_EQ(bench.report().engaged, 1);
}

TEST(DeviceSurgeon, ADriverThatStartsLateIsWatchedFromItsFirstPoseOn) {
  DeviceBench bench(testMaster());
  bench.publishes = false;
  bench.tick(3000);
  bench.publishes = true;
  for (int i = 0; i < 300; ++i) {
    for (const Arm arm : kArms)
      at(bench.samples, arm).position[0] = 1e-3 * std::sin(0.05 * i);
    bench.tick();
  }
  bench.press();
  EXPECT_FALSE(bench.tick().pedal);
  EXPECT_EQ(bench.newest(), DeviceTrouble::kTooSoon);
}

TEST(DeviceSurgeon, ARobotThatIsNotReadyIsNotMovedByAPedalThatWasDownBefore) {
  DeviceBench bench(testMaster());
  bench.senses.may_move = false;
  bench.warmUp();
  bench.press();
  EXPECT_FALSE(bench.tick().pedal);
  EXPECT_EQ(bench.newest(), DeviceTrouble::kRobotNotReady);
  bench.senses.may_move = true;
  EXPECT_FALSE(bench.tick(100).pedal);
  bench.press(0);
  bench.tick();
  bench.press();
  EXPECT_TRUE(bench.tick().pedal);
}

TEST(DeviceSurgeon, MillimetresTakenForMetresAreRefusedByName) {
  DeviceBench bench(testMaster());
  bench.samples[0].position = {0.0, -65.5, 51.0};
  bench.warmUp(1.0);
  bench.press();
  EXPECT_FALSE(bench.tick().pedal);
  EXPECT_EQ(bench.newest(), DeviceTrouble::kMillimetres);
  EXPECT_EQ(bench.said(), "left: positions of 83 m: the driver publishes millimetres; units: mm");
}

TEST(DeviceSurgeon, MetresTakenForMillimetresAreRefusedByName) {
  MasterConfig config = testMaster();
  config.metres_per_unit = 1e-3;
  DeviceBench bench(config);
  bench.samples[0].position = {0.0, -0.0655, 0.051};
  bench.warmUp(0.001);
  bench.press();
  EXPECT_FALSE(bench.tick().pedal);
  EXPECT_EQ(bench.newest(), DeviceTrouble::kMetres);
  EXPECT_EQ(bench.said().find("left: positions of 0.083 mm: the driver publishes metres; units: m"), 0U)
      << bench.said();
}

TEST(DeviceSurgeon, WhatIsNoPoseLiftsThePedal) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  struct Case {
    Vec3 position;
    Quat orientation;
    DeviceTrouble trouble;
  };
  const std::array<Case, 6> cases{{{{nan, 0, 0}, kIdentityQuat, DeviceTrouble::kNotFinite},
                                   {{0, 0, 0}, {0, 0, nan, 1}, DeviceTrouble::kNotFinite},
                                   {{0, 0, 0}, {0, 0, 0, 0}, DeviceTrouble::kNotUnit},
                                   {{0, 0, 0.7}, kIdentityQuat, DeviceTrouble::kOutOfReach},
                                   {{0, 0.02, 0}, kIdentityQuat, DeviceTrouble::kJump},
                                   {{0, 0, 0}, {0, 0, std::sin(0.15), std::cos(0.15)}, DeviceTrouble::kTurnJump}}};
  for (const Case& c : cases) {
    MasterConfig config = testMaster();
    config.orientation = true;
    DeviceBench bench(config);
    bench.warmUp();
    bench.press();
    ASSERT_TRUE(bench.tick().pedal);
    bench.samples[0].position = c.position;
    bench.samples[0].orientation = c.orientation;
    EXPECT_FALSE(bench.tick().pedal);
    EXPECT_EQ(bench.newest(), c.trouble);
    EXPECT_FALSE(bench.said().empty());
    // the poses are valid again, but the pedal must go up first
    bench.samples[0].position = {0, 0, 0};
    bench.samples[0].orientation = kIdentityQuat;
    bench.tick();
    EXPECT_FALSE(bench.tick(50).pedal);
    bench.press(0);
    bench.tick();
    bench.press();
    EXPECT_TRUE(bench.tick().pedal);
  }
}

TEST(DeviceSurgeon, AFastHandIsNoJump) {
  DeviceBench bench(testMaster());
  bench.warmUp();
  bench.press();
  ASSERT_TRUE(bench.tick().pedal);
  // 2 m/s, a pose every 10 ms
  for (int i = 0; i < 100; ++i) {
    bench.publishes = i % 10 == 9;
    if (bench.publishes) bench.samples[0].position[0] += 0.02;
    ASSERT_TRUE(bench.tick().pedal) << i;
  }
}

TEST(DeviceSurgeon, AFastWristIsNoJumpAndAQuaternionOfTheOtherSignIsNone) {
  MasterConfig config = testMaster();
  config.orientation = true;
  DeviceBench bench(config);
  bench.warmUp();
  bench.press();
  ASSERT_TRUE(bench.tick().pedal);
  // 20 rad/s, a pose every 10 ms, each other one as the negative quaternion
  for (int i = 0; i < 300; ++i) {
    bench.publishes = i % 10 == 9;
    const double half = 0.1 * (i / 10 + 1), sign = i / 10 % 2 == 0 ? -1.0 : 1.0;
    if (bench.publishes) bench.samples[0].orientation = {sign * std::sin(half), 0.0, 0.0, sign * std::cos(half)};
    ASSERT_TRUE(bench.tick().pedal) << i;
  }
  // 0.52 rad within 9 ms are a jump
  bench.publishes = false;
  bench.tick(8);
  bench.publishes = true;
  const double half = 0.1 * 30 + 0.26;
  bench.samples[0].orientation = {std::sin(half), 0.0, 0.0, std::cos(half)};
  EXPECT_FALSE(bench.tick().pedal);
  EXPECT_EQ(bench.newest(), DeviceTrouble::kTurnJump);
  EXPECT_EQ(bench.said().find("left: it turned by 0.52 rad"), 0U) << bench.said();
}

TEST(DeviceSurgeon, WithoutOrientationATurnIsNoJump) {
  DeviceBench bench(testMaster());
  bench.warmUp();
  bench.press();
  ASSERT_TRUE(bench.tick().pedal);
  bench.samples[0].orientation = {1.0, 0.0, 0.0, 0.0};
  EXPECT_TRUE(bench.tick().pedal);
}

TEST(DeviceSurgeon, PosesAtAHundredHertzAreSpreadOverTheTimeBetweenThem) {
  MasterConfig config = testMaster();
  config.orientation = true;
  DeviceBench bench(config);
  bench.warmUp();
  double before = 0.0;
  Quat turned = kIdentityQuat;
  for (int i = 0; i < 200; ++i) {
    bench.publishes = i % 10 == 9;
    if (bench.publishes) {
      bench.samples[0].position[1] += 0.002;
      const double angle = 0.01 * (i / 10 + 1);
      bench.samples[0].orientation = {std::sin(angle / 2), 0.0, 0.0, std::cos(angle / 2)};
    }
    const Intent intent = bench.tick();
    if (i >= 20) {
      EXPECT_NEAR(intent.hand_I[0][1] - before, 0.0002, 1e-12) << i;
      EXPECT_NEAR(2.0 * (std::asin(intent.turn_I[0][0]) - std::asin(turned[0])), 0.001, 1e-9) << i;
    }
    before = intent.hand_I[0][1];
    turned = intent.turn_I[0];
  }
  bench.publishes = false;
  EXPECT_NEAR(bench.tick(10).hand_I[0][1], 0.04, 1e-12) << "all of it, 10 ms late";
}

/** A busy computer delivers two poses of a 60 Hz driver within 1 ms. The hand keeps its speed and arrives. */
TEST(DeviceSurgeon, PosesThatComeTogetherMakeNoStep) {
  for (const int late : {14, 15, 16}) {
    MasterConfig config = testMaster();
    config.max_jump = 0.05;
    DeviceBench bench(config);
    bench.warmUp();
    bench.press();
    bench.tick();
    double before = 0.0, largest = 0.0;
    for (int i = 0; i < 800; ++i) {
      const int cycle = i % 48;  // poses are due at 0, 16 and 32; the second comes late
      bench.publishes = cycle == 0 || cycle == 16 + late || cycle == 32;
      if (bench.publishes) bench.samples[0].position[1] += 0.004;
      const double hand = bench.tick().hand_I[0][1];
      if (i > 200) largest = std::max(largest, hand - before);
      before = hand;
    }
    EXPECT_LT(largest, 3.5 * 0.004 / 16) << late << ": a whole pose in one tick would be 0.004";
    bench.publishes = false;
    EXPECT_NEAR(bench.tick(20).hand_I[0][1], bench.samples[0].position[1], 1e-12);
  }
}

TEST(DeviceSurgeon, ADeviceThatFallsSilentLiftsThePedalAndIsNamed) {
  DeviceBench bench(testMaster());
  bench.warmUp();
  bench.press();
  ASSERT_TRUE(bench.tick().pedal);
  bench.publishes = false;
  EXPECT_TRUE(bench.tick(99).pedal);
  EXPECT_FALSE(bench.tick(3).pedal);
  EXPECT_EQ(bench.newest(Arm::kGreen), DeviceTrouble::kSilent);
  EXPECT_NE(bench.said().find("/pose"), std::string::npos);
  const std::uint32_t told = bench.report().found[0];
  bench.tick(1000);
  EXPECT_EQ(bench.report().found[0], told) << "once";
}

TEST(DeviceSurgeon, AButtonThatWasHeldThroughASilenceIsNoPedalBeforeItWasUp) {
  for (const Arm arm : kArms) {
    MasterConfig config = testMaster();
    config.pedal_from = PedalFrom::kAll;
    DeviceBench bench(config);
    bench.warmUp();
    bench.samples[0].buttons = bench.samples[1].buttons = 1;
    ASSERT_TRUE(bench.tick().pedal);
    // GIVEN a driver that dies with its button down and is restarted, so that nobody published the release
    bench.publishes = false;
    ASSERT_FALSE(bench.tick(200).pedal);
    EXPECT_EQ(bench.report().pedal, 0);
    bench.publishes = true;
    // WHEN the other device's button alone is pressed, THEN the pedal stays up
    for (const std::uint32_t other : {1U, 0U, 1U}) {
      at(bench.samples, otherArm(arm)).buttons = other;
      EXPECT_FALSE(bench.tick(20).pedal) << name(arm);
    }
    at(bench.samples, arm).buttons = 0;
    bench.tick();
    at(bench.samples, arm).buttons = 1;
    EXPECT_TRUE(bench.tick().pedal) << name(arm);
  }
}

TEST(DeviceSurgeon, ADeviceThatNeverSpeaksIsNamedAfterAMoment) {
  DeviceBench bench(testMaster());
  bench.publishes = false;
  bench.tick(1900);
  EXPECT_EQ(bench.report().found[0], 0U);
  bench.tick(200);
  EXPECT_EQ(bench.newest(), DeviceTrouble::kNeverHeard);
  EXPECT_EQ(bench.report().found[0], 1U);
}

TEST(DeviceSurgeon, APoseThatDoesNotChangeWhileEngagedIsToldAndLetBe) {
  DeviceBench bench(testMaster());
  bench.warmUp();
  bench.tick(5000);  // may rest with the pedal up
  bench.press();
  ASSERT_TRUE(bench.tick().pedal);
  bench.tick(1990);
  EXPECT_EQ(bench.newest(), DeviceTrouble::kNone);
  EXPECT_TRUE(bench.tick(20).pedal) << "one of two devices may rest";
  EXPECT_EQ(bench.newest(), DeviceTrouble::kFrozen);
  EXPECT_EQ(bench.report().found[0], 1U) << "once";
  // the driver had hung: the motion that it missed arrives at once
  bench.samples[0].position[0] += 0.05;
  EXPECT_FALSE(bench.tick().pedal);
  EXPECT_EQ(bench.newest(), DeviceTrouble::kJump);
}

TEST(DeviceSurgeon, AnOperatingStateThatIsNotEnabledForbidsAndALockIsToldAlone) {
  DeviceBench bench(testMaster());
  bench.warmUp();
  bench.samples[0].is_locked = 1;
  bench.press();
  EXPECT_TRUE(bench.tick().pedal);
  EXPECT_EQ(bench.newest(), DeviceTrouble::kLocked);
  bench.samples[1].is_ready = 0;
  EXPECT_FALSE(bench.tick().pedal);
  EXPECT_EQ(bench.newest(Arm::kGreen), DeviceTrouble::kNotReady);
}

TEST(DeviceSurgeon, AnOperatingStateThatHasNotComeForbidsAndIsToldAfterAMoment) {
  DeviceBench bench(testMaster());
  bench.samples[0].is_ready = 0;
  bench.samples[0].is_stateless = 1;
  bench.warmUp();
  EXPECT_EQ(bench.report().found[0], 0U) << "ROS needs a moment";
  bench.tick(1500);
  EXPECT_EQ(bench.newest(), DeviceTrouble::kNoState);
  EXPECT_EQ(bench.said(),
            "left: nothing has come on /operating_state (does its driver publish it, and under this name?)");
  EXPECT_EQ(bench.report().found[0], 1U);
  bench.press();
  EXPECT_FALSE(bench.tick().pedal);
  bench.samples[0].is_stateless = 0;
  bench.tick();
  EXPECT_EQ(bench.newest(), DeviceTrouble::kNotReady) << "for example DISABLED";
  bench.press(0);
  bench.samples[0].is_ready = 1;
  bench.tick();
  bench.press();
  EXPECT_TRUE(bench.tick().pedal);
}

TEST(DeviceSurgeon, ThePedalIsWhereTheFileSays) {
  struct Case {
    PedalFrom from;
    std::uint32_t left, right;
    std::uint8_t foot;
    bool held;
  };
  const std::array<Case, 10> cases{{{PedalFrom::kLeft, 1, 0, 0, true},
                                    {PedalFrom::kLeft, 0, 1, 1, false},
                                    {PedalFrom::kRight, 0, 1, 0, true},
                                    {PedalFrom::kRight, 1, 0, 1, false},
                                    {PedalFrom::kAny, 0, 1, 0, true},
                                    {PedalFrom::kAny, 2, 2, 1, false},
                                    {PedalFrom::kAll, 1, 0, 1, false},
                                    {PedalFrom::kAll, 1, 1, 0, true},
                                    {PedalFrom::kTopic, 1, 1, 0, false},
                                    {PedalFrom::kTopic, 0, 0, 1, true}}};
  for (const Case& c : cases) {
    MasterConfig config = testMaster();
    config.pedal_from = c.from;
    DeviceBench bench(config);
    bench.warmUp();
    bench.samples[0].buttons = c.left;
    bench.samples[1].buttons = c.right;
    bench.foot.is_held = c.foot;
    EXPECT_EQ(bench.tick().pedal, c.held) << static_cast<int>(c.from);
  }
}

TEST(DeviceSurgeon, AllMeansAllThatAreThere) {
  MasterConfig config = testMaster();
  config.pedal_from = PedalFrom::kAll;
  config.devices[1].is_used = false;
  DeviceBench bench(config);
  bench.warmUp();
  EXPECT_FALSE(bench.tick().pedal);
  bench.press();
  EXPECT_TRUE(bench.tick().pedal);
}

TEST(DeviceSurgeon, AButtonTogglesTheJawsAtTheirSpeedWhileEngaged) {
  MasterConfig config = testMaster();
  config.gripper_from = GripperFrom::kToggles;
  DeviceBench bench(config, 0.5);
  bench.warmUp();
  bench.press(2);  // without the pedal, the button has no effect
  EXPECT_EQ(bench.tick(300).grasp[0], 0.5);
  bench.press(1);
  EXPECT_EQ(bench.tick(300).grasp[0], 0.5);
  bench.press(3);
  EXPECT_NEAR(bench.tick(100).grasp[0], 0.5 - 0.1 * 3.0, 1e-9);
  bench.press(1);
  EXPECT_NEAR(bench.tick(200).grasp[0], 0.0, 1e-12);
  bench.press(3);
  EXPECT_NEAR(bench.tick(300).grasp[0], 0.6, 1e-12);
}

TEST(DeviceSurgeon, AButtonThatIsHeldAsThePedalGoesDownTogglesNothing) {
  MasterConfig config = testMaster();
  config.gripper_from = GripperFrom::kToggles;
  DeviceBench bench(config, 0.5);
  bench.warmUp();
  bench.press(2);
  bench.tick(300);
  bench.press(3);
  EXPECT_EQ(bench.tick(300).grasp[0], 0.5);
  bench.press(1);
  bench.tick();
  bench.press(3);
  EXPECT_NEAR(bench.tick(300).grasp[0], 0.0, 1e-12);
}

TEST(DeviceSurgeon, AHeldButtonClosesAndAJointLeadsTheJaws) {
  MasterConfig config = testMaster();
  config.gripper_from = GripperFrom::kHolds;
  DeviceBench holding(config);
  holding.warmUp();
  holding.press(1);
  EXPECT_NEAR(holding.tick(300).grasp[0], 0.6, 1e-12);
  holding.press(3);
  EXPECT_NEAR(holding.tick(300).grasp[0], 0.0, 1e-12);

  config.gripper_from = GripperFrom::kJoint;
  config.reading_closed = -0.1;
  config.reading_open = 0.9;
  DeviceBench jointed(config);
  jointed.warmUp();
  jointed.press(1);
  EXPECT_EQ(jointed.tick(300).grasp[0], 0.3) << "no reading yet";
  jointed.samples[0].has_gripper = 1;
  jointed.samples[0].gripper = 0.4;
  EXPECT_NEAR(jointed.tick(300).grasp[0], 0.3, 1e-12);
  jointed.samples[0].gripper = 5.0;
  EXPECT_NEAR(jointed.tick(300).grasp[0], 0.6, 1e-12);
  jointed.samples[0].gripper = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NEAR(jointed.tick(300).grasp[0], 0.6, 1e-12);
}

TEST(DeviceSurgeon, AGamepadsSticksAreVelocitiesBeyondTheirDeadBand) {
  const MasterConfig config = shipped("gamepad");
  DeviceBench bench(config);
  bench.tick(600);
  bench.samples[0].axis_count = bench.samples[1].axis_count = 8;
  bench.press(1U << 5U);
  ASSERT_TRUE(bench.tick().pedal);
  bench.samples[0].axes[0] = 0.09;  // within the dead band
  expectNear(bench.tick(1000).hand_I[0], {0, 0, 0}, 1e-12, "dead band");
  bench.samples[0].axes = {0.0, 1.0};  // forward, at its end
  expectNear(bench.tick(1000).hand_I[0], {0.08, 0, 0}, 1e-9, "forward");
  bench.samples[0].axes = {-0.55};  // right, half of the range beyond the dead band
  expectNear(bench.tick(1000).hand_I[0], {0.08, 0.04, 0}, 1e-9, "right");
  bench.samples[0].axes = {};
  bench.samples[1].axes = {0, 0, 0, 0, 0, 0, 1.0};  // the right hand moves up
  const Intent intent = bench.tick(500);
  expectNear(intent.hand_I[0], {0.08, 0.04, 0}, 1e-9, "rests");
  expectNear(intent.hand_I[1], {0, 0, -0.04}, 1e-9, "up");
}

TEST(DeviceSurgeon, ANumberThatIsNoneLiftsTheGamepadsPedalAndMovesNothing) {
  DeviceBench bench(shipped("gamepad"));
  bench.tick(600);
  bench.samples[0].axis_count = bench.samples[1].axis_count = 8;
  bench.press(1U << 5U);
  ASSERT_TRUE(bench.tick().pedal);
  bench.samples[0].axes[0] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(bench.tick().pedal);
  EXPECT_EQ(bench.newest(), DeviceTrouble::kNotFinite);
  bench.samples[0].axes = {};
  bench.press(0);
  bench.tick();
  bench.press(1U << 5U);
  const Intent intent = bench.tick();
  for (const double coordinate : intent.hand_I[0])
    EXPECT_TRUE(std::isfinite(coordinate));
}

TEST(DeviceSurgeon, ForcesReachTheDeviceOnlyWhileEngagedAndNeverAboveItsLimit) {
  MasterConfig config = testMaster();
  config.force_per_newton = 2.0;
  DeviceBench bench(config);
  bench.warmUp();
  bench.senses.force.force_I[0] = {0.5, -1.0, 0.25};
  bench.tick();
  EXPECT_EQ(bench.force(), (Vec3{0, 0, 0}));
  bench.press();
  bench.tick();
  expectNear(bench.force(), {1.0, -2.0, 0.5}, 1e-12, "twice the newtons");
  EXPECT_NEAR(bench.report().hand_force[0], std::sqrt(0.25 + 1.0 + 0.0625), 1e-12);
  bench.senses.force.force_I[0] = {0.0, 0.0, -33.0};
  bench.tick();
  expectNear(bench.force(), {0, 0, -6.6}, 1e-9, "3.3 N");
  bench.senses.force.force_I[0] = {0.0, std::numeric_limits<double>::infinity(), 0.0};
  bench.tick();
  EXPECT_EQ(bench.force(), (Vec3{0, 0, 0}));
  bench.senses.force.force_I[0] = {1.0, 0.0, 0.0};
  bench.press(0);
  bench.tick();
  EXPECT_EQ(bench.force(), (Vec3{0, 0, 0}));
  EXPECT_EQ(bench.force(Arm::kGreen), (Vec3{0, 0, 0}));
}

TEST(DeviceSurgeon, TheLimitIsThatOfTheWholeForce) {
  const MasterConfig config = testMaster();  // 3.3 N
  const double share = 3.3 / std::sqrt(3.0);
  expectNear(toDevice(config, {3.3, -3.3, 3.3}), {share, -share, share}, 1e-12, "3.3 N in all");
  expectNear(toDevice(config, {0.0, 4.0, 3.0}), {0.0, 2.64, 1.98}, 1e-12, "in its direction");
  expectNear(toDevice(config, {0.0, 1.9, 1.9}), {0.0, 1.9, 1.9}, 1e-12, "below it");
}

TEST(DeviceSurgeon, AForceSaysWhetherThePedalHasEverCounted) {
  DeviceBench bench(testMaster());
  const auto has_begun = [&] { return bench.link.forces[1].load().has_begun; };
  bench.press();
  bench.tick(10);  // pressed too soon
  bench.press(0);
  bench.warmUp();
  EXPECT_EQ(has_begun(), 0);
  bench.press();
  bench.tick();
  EXPECT_EQ(has_begun(), 1);
  bench.press(0);
  bench.tick(10);
  EXPECT_EQ(has_begun(), 1);
  EXPECT_EQ(bench.report().engagements, 1U);
  bench.press();
  bench.tick(10);
  EXPECT_EQ(bench.report().engagements, 2U);
}

TEST(DeviceSurgeon, WithAForceGoesTheLastPlaceThatIsOne) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  DeviceBench bench(testMaster());
  const auto told = [&] { return bench.link.forces[0].load(); };
  bench.samples[0].position = {nan, 0.0, 0.0};
  bench.publishes = false;
  bench.tick(3);
  EXPECT_EQ(told().is_placed, 0) << "before the first pose";
  bench.publishes = true;
  bench.tick(3);
  EXPECT_EQ(told().is_placed, 0) << "before the first finite pose";
  EXPECT_EQ(told().position, (Vec3{0, 0, 0}));
  bench.samples[0].position = {0.01, 0.02, 0.03};
  bench.tick();
  EXPECT_EQ(told().is_placed, 1);
  bench.samples[0].position = {0.01, nan, 0.03};
  bench.tick();
  EXPECT_EQ(told().is_placed, 1);
  EXPECT_EQ(told().position, (Vec3{0.01, 0.02, 0.03}));
}

TEST(DeviceSurgeon, AForceRoundTripsThroughEveryMap) {
  for (const Published& family : kPublished) {
    const MasterConfig master = shipped(family.file);
    const Vec3 force{0.3, -0.7, 1.1};
    const Vec3 back = toArray(Vector3(axisMatrix(master.axes) * toEigen(toDevice(master, force))));
    expectNear(back, force, 1e-12, family.file);
  }
}

// ---- each device ----------------------------------------------------------------------------------------------------

class EachDevice : public ::testing::TestWithParam<Arm> {
 protected:
  static DeviceSample& own(DeviceBench* bench) { return at(bench->samples, GetParam()); }

  /** Both buttons, so that either may be the pedal. */
  static void press(DeviceBench* bench, std::uint32_t buttons = 1) {
    for (DeviceSample& sample : bench->samples)
      sample.buttons = buttons;
  }
};

TEST_P(EachDevice, LiftsThePedalByItself) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::array<Vec3, 4> wrong{{{nan, 0, 0}, {0, 0, -0.7}, {0, -0.02, 0}, {0.02, 0, 0}}};
  for (const Vec3& position : wrong) {
    DeviceBench bench(testMaster());
    bench.warmUp();
    press(&bench);
    ASSERT_TRUE(bench.tick().pedal);
    own(&bench).position = position;
    EXPECT_FALSE(bench.tick().pedal);
    EXPECT_NE(bench.newest(GetParam()), DeviceTrouble::kNone);
    EXPECT_EQ(bench.newest(otherArm(GetParam())), DeviceTrouble::kNone);
  }
}

TEST_P(EachDevice, ForbidsToStartIfItAloneHasNeverMoved) {
  DeviceBench bench(testMaster());
  for (int i = 0; i < 600; ++i) {
    at(bench.samples, otherArm(GetParam())).position[0] = 1e-3 * std::sin(0.05 * i);
    bench.tick();
  }
  press(&bench);
  EXPECT_FALSE(bench.tick().pedal);
  EXPECT_EQ(bench.newest(GetParam()), DeviceTrouble::kNeverMoved);
  EXPECT_EQ(bench.newest(otherArm(GetParam())), DeviceTrouble::kNone);
}

/** The hand moves to a slow driver's pose within ten ticks. The pedal goes down after three of them. */
TEST_P(EachDevice, MovesNothingByWhatIsLeftOfAPoseAsThePedalGoesDown) {
  MasterConfig master = testMaster();
  master.orientation = true;
  DeviceBench bench(master);
  bench.senses.may_move = true;
  bench.warmUp();
  bench.publishes = false;
  bench.tick(10);
  DeviceSample& sample = at(bench.samples, GetParam());
  sample.position[1] += 0.004;
  sample.orientation = {std::sin(0.05), 0.0, 0.0, std::cos(0.05)};
  ++sample.poses;
  const Intent before = bench.tick(3);
  ASSERT_GT(at(before.hand_I, GetParam())[1], 0.001);
  ASSERT_LT(at(before.hand_I, GetParam())[1], 0.002);
  bench.press();
  for (int i = 0; i < 20; ++i) {
    const Intent intent = bench.tick();
    ASSERT_TRUE(intent.pedal);
    EXPECT_EQ(at(intent.hand_I, GetParam()), at(before.hand_I, GetParam())) << i;
    EXPECT_EQ(at(intent.turn_I, GetParam()), at(before.turn_I, GetParam())) << i;
  }
}

/** The device's x is the hand's z, its y the hand's x. In these axes the second rotation follows the first one. */
TEST_P(EachDevice, AddsTheTurnsOfTwoEngagementsAboutItsOwnAxes) {
  MasterConfig master = testMaster();
  master.orientation = true;
  master.turn_axes = {Vec3{0, 1, 0}, Vec3{0, 0, 1}, Vec3{1, 0, 0}};
  DeviceBench bench(master);
  bench.senses.may_move = true;
  bench.warmUp();
  Quat turn = kIdentityQuat;
  for (const Eigen::Vector3d& about : {Eigen::Vector3d(Eigen::Vector3d::UnitX()), Eigen::Vector3d(0, 1, 0)}) {
    bench.press();
    bench.tick();
    Quat& orientation = at(bench.samples, GetParam()).orientation;
    orientation =
        toArray(Eigen::Quaterniond(Eigen::AngleAxisd(0.15, about)) * Eigen::Quaterniond(toEigen(orientation)));
    turn = at(bench.tick().turn_I, GetParam());
    bench.press(0);
    bench.tick();
  }
  const Eigen::Quaterniond expected(Eigen::AngleAxisd(0.15, Eigen::Vector3d::UnitX()) *
                                    Eigen::AngleAxisd(0.15, Eigen::Vector3d::UnitZ()));
  EXPECT_LT(Eigen::Quaterniond(toEigen(turn)).angularDistance(expected), 1e-9);
}

TEST_P(EachDevice, HasMovedIfItOnlyTurned) {
  MasterConfig master = testMaster();
  master.orientation = true;
  DeviceBench bench(master);
  bench.senses.may_move = true;
  for (int i = 0; i < 600; ++i) {
    for (const Arm arm : kArms) {
      const double angle = 0.01 * std::sin(0.05 * i);
      DeviceSample& sample = at(bench.samples, arm);
      if (arm == GetParam()) sample.orientation = {std::sin(0.5 * angle), 0.0, 0.0, std::cos(0.5 * angle)};
      if (arm != GetParam()) sample.position[0] = 1e-3 * std::sin(0.05 * i);
    }
    bench.tick();
  }
  bench.press();
  EXPECT_TRUE(bench.tick().pedal) << bench.said(GetParam());
}

TEST_P(EachDevice, GetsTheForceOnItsOwnHand) {
  MasterConfig config = testMaster();
  config.force_per_newton = 4.0;
  DeviceBench bench(config);
  bench.warmUp();
  press(&bench);
  at(bench.senses.force.force_I, GetParam()) = {0.0, -0.5, 0.0};
  bench.tick();
  expectNear(bench.force(GetParam()), {0.0, -2.0, 0.0}, 1e-12, "own");
  expectNear(bench.force(otherArm(GetParam())), {0.0, 0.0, 0.0}, 0.0, "other");
  EXPECT_NEAR(at(bench.report().hand_force, GetParam()), 0.5, 1e-12) << "reported in newtons";
  EXPECT_EQ(at(bench.report().hand_force, otherArm(GetParam())), 0.0);
}

TEST_P(EachDevice, IsReportedOnceForEachLock) {
  DeviceBench bench(testMaster());
  bench.warmUp();
  for (std::uint32_t lock = 1; lock <= 3; ++lock) {
    own(&bench).is_locked = 1;
    bench.tick(20);
    EXPECT_EQ(at(bench.report().found, GetParam()), lock);
    EXPECT_EQ(at(bench.report().found, otherArm(GetParam())), 0U);
    own(&bench).is_locked = 0;
    bench.tick(20);
  }
}

TEST_P(EachDevice, IsNoPedalAfterItsDriverDiedUntilItsButtonWasUp) {
  MasterConfig config = testMaster();
  config.pedal_from = GetParam() == Arm::kGold ? PedalFrom::kLeft : PedalFrom::kRight;
  DeviceBench bench(config);
  bench.warmUp();
  press(&bench);
  ASSERT_TRUE(bench.tick().pedal);
  bench.publishes = false;
  ASSERT_FALSE(bench.tick(200).pedal);
  bench.publishes = true;
  EXPECT_FALSE(bench.tick(50).pedal);
  own(&bench).buttons = 0;
  bench.tick();
  own(&bench).buttons = 1;
  EXPECT_TRUE(bench.tick().pedal);
}

TEST_P(EachDevice, IsTooWideBeyondFiveWorkspacesOnEitherSide) {
  // a workspace of 70 mm along z: five times that is 0.35 m
  for (const double side : {-1.0, 1.0}) {
    DeviceBench bench(testMaster());
    bench.warmUp();
    for (int i = 0; i <= 340; ++i) {
      own(&bench).position[2] = side * 1e-3 * i;
      bench.tick();
    }
    EXPECT_EQ(bench.newest(GetParam()), DeviceTrouble::kNone);
    for (int i = 341; i <= 360; ++i) {
      own(&bench).position[2] = side * 1e-3 * i;
      bench.tick();
    }
    EXPECT_EQ(bench.newest(GetParam()), DeviceTrouble::kTooWide) << side;
    EXPECT_EQ(bench.newest(otherArm(GetParam())), DeviceTrouble::kNone);
  }
}

TEST_P(EachDevice, KeepsItsRangeAfterAGlitch) {
  DeviceBench bench(testMaster());
  bench.warmUp();
  own(&bench).position[2] = -0.3;  // one pose, far off but within reach
  bench.tick();
  EXPECT_EQ(bench.newest(GetParam()), DeviceTrouble::kJump);
  own(&bench).position[2] = 0.0;
  bench.tick();
  const std::uint32_t found = at(bench.report().found, GetParam());
  for (int i = 0; i <= 200; ++i) {
    own(&bench).position[2] = 1e-3 * i;
    bench.tick();
  }
  EXPECT_EQ(at(bench.report().found, GetParam()), found) << "0.2 m are not five workspaces";
}

TEST_P(EachDevice, LeadsItsJawsByItsOwnAxisWithinTheirRange) {
  MasterConfig config = testMaster();
  config.gripper_from = GripperFrom::kAxis;
  for (DeviceTopics& device : config.devices)
    device.gripper_input = 2;
  config.reading_closed = -0.5;
  DeviceBench bench(config);  // jaws at 0.3 of 0.6, readings from -0.5 to 1
  bench.warmUp();
  press(&bench);
  const std::array<std::array<double, 2>, 5> readings{{{1.0, 0.6}, {0.25, 0.3}, {-0.5, 0.0}, {-9.0, 0.0}, {9.0, 0.6}}};
  own(&bench).axis_count = 3;
  for (const auto& [reading, opening] : readings) {
    own(&bench).axes[2] = reading;
    EXPECT_NEAR(at(bench.tick(300).grasp, GetParam()), opening, 1e-12) << reading;
  }
  own(&bench).axis_count = 2;  // the driver has only two: the third counts as 0
  EXPECT_NEAR(at(bench.tick(300).grasp, GetParam()), 0.2, 1e-12);
}

INSTANTIATE_TEST_SUITE_P(Arms, EachDevice, ::testing::ValuesIn(kArms), [](const auto& tested) {
  return std::string(name(tested.param));
});

TEST(DeviceSurgeon, AStickBeyondItsEndIsAtItsEndOnEitherSide) {
  for (const double side : {-1.0, 1.0}) {
    DeviceBench bench(shipped("gamepad"));
    bench.tick(600);
    bench.samples[0].axis_count = bench.samples[1].axis_count = 8;
    bench.press(1U << 5U);
    ASSERT_TRUE(bench.tick().pedal);
    bench.samples[0].axes = {0.0, 1.8 * side};
    expectNear(bench.tick(1000).hand_I[0], {0.08 * side, 0, 0}, 1e-9, "forward and back");
  }
}

/** A console with master devices, and a robot that is ready. */
struct RealConsole {
  explicit RealConsole(double scale = 0.1, bool orientation = false, double max_turn_jump = 0.2)
      : bench(master(scale, orientation, max_turn_jump)) {
    ConsoleConfig at_once = testConfig();
    at_once.start_delay = 0.0;
    at_once.scale = scale;
    console = std::make_unique<Console>(at_once, std::move(bench.source));
    console->setReady(true);
  }

  static MasterConfig master(double scale, bool orientation, double max_turn_jump) {
    MasterConfig config = testMaster();
    config.scale = scale;
    config.orientation = orientation;
    config.max_turn_jump = max_turn_jump;
    return config;
  }

  wire::ItpPacket tick() {
    for (const Arm arm : kArms) {
      if (!is_silent) ++at(bench.samples, arm).poses;
      at(bench.link.samples, arm).store(at(bench.samples, arm));
    }
    return console->tick();
  }

  void warmUp() {
    for (int i = 0; i < 600; ++i) {
      for (DeviceSample& sample : bench.samples)
        sample.position[0] = 1e-3 * std::sin(0.05 * i);
      tick();
    }
  }

  DeviceBench bench;
  std::unique_ptr<Console> console;
  bool is_silent{false};
};

TEST(RealHands, AForceMovesNoHandOfTheConsoles) {
  RealConsole real;
  real.warmUp();
  real.bench.press();
  ASSERT_EQ(real.tick().surgeon_mode, 1);
  ForcePacket force;
  force.runlevel = 3;
  force.force_I[0] = {2.0, 1.0, -1.0};
  for (int i = 0; i < 500; ++i) {
    ++force.sequence;
    ASSERT_EQ(real.console->applyForce(force), Reject::kNone);
    const wire::ItpPacket packet = real.tick();
    ASSERT_EQ(packet.delx_um[0], 0) << "the device is the hand, and it has not moved";
    ASSERT_EQ(packet.dely_um[0], 0);
  }
  expectNear(real.bench.force(), {2.0, 1.0, -1.0}, 1e-12, "felt");
  EXPECT_EQ(real.console->deflection()[0], (Vec3{0, 0, 0}));
  // the daemon falls silent
  for (int i = 0; i < 51; ++i)
    real.tick();
  EXPECT_EQ(real.bench.force(), (Vec3{0, 0, 0}));
}

TEST(RealHands, AreLookedAtBeforeTheRobotIsReadyAndMoveNothing) {
  RealConsole real;
  real.console->setReady(false);
  real.warmUp();
  real.bench.press();
  for (int i = 0; i < 10; ++i)
    ASSERT_EQ(real.tick().surgeon_mode, 0);
  EXPECT_EQ(real.bench.newest(), DeviceTrouble::kRobotNotReady);
}

TEST(RealHands, WhateverADevicePublishesEveryPacketIsOneThatTheDaemonTakes) {
  const double inf = std::numeric_limits<double>::infinity();
  const std::array<double, 6> odd{inf, -inf, std::nan(""), 1e300, 83.0, -0.4};
  Random random(5);
  RealConsole real(1.0, /*orientation=*/true, /*max_turn_jump=*/3.2);  // all random rotations reach the packet
  real.warmUp();
  int engaged = 0, moved = 0;
  for (int i = 0; i < 60000; ++i) {
    DeviceSample& left = real.bench.samples[0];
    const auto axis = static_cast<std::size_t>(random.uniform(0.0, 2.999));
    left.position[axis] += random.uniform(-0.004, 0.004);
    left.orientation = {random.uniform(-1, 1), random.uniform(-1, 1), 0.0, 1.0};
    const double norm = toEigen(left.orientation).norm();
    for (double& element : left.orientation)
      element /= norm;
    if (i % 97 == 0) left.position[axis] = odd[static_cast<std::size_t>(random.uniform(0.0, 5.999))];
    if (i % 97 == 1) left.position = {};
    if (i % 389 == 0) left.orientation[2] = odd[static_cast<std::size_t>(random.uniform(0.0, 5.999))];
    if (i % 11 == 0) real.bench.press(random.uniform(0.0, 1.0) < 0.7 ? 1 : 0);
    real.is_silent = i % 800 > 680;
    const wire::ItpPacket packet = real.tick();
    ASSERT_EQ(wire::checkItp(packet, {2000, 0.1}), Reject::kNone) << i;
    engaged += packet.surgeon_mode;
    moved += packet.delx_um[0] != 0 ? 1 : 0;
  }
  EXPECT_GT(engaged, 5000);
  EXPECT_GT(moved, 1000);
}

TEST(RealHands, WhatAHandDidBeforeThePedalWasDownMovesNothingHoweverLateItIsTold) {
  // GIVEN a driver that stalls: between two poses at 100 Hz, for less than silent_after, and for longer
  for (const int stall : {5, 60, 200}) {
    for (const bool pressed_amidst : {true, false}) {
      RealConsole real(0.1, /*orientation=*/true);
      real.warmUp();
      real.is_silent = true;
      for (int i = 0; i < stall; ++i)
        real.tick();
      if (pressed_amidst && stall < 100) {
        real.bench.press();
        ASSERT_EQ(real.tick().surgeon_mode, 1);
      }
      // WHEN the driver publishes the hand's motion of the stall at once, and the pedal goes down
      real.is_silent = false;
      DeviceSample& left = real.bench.samples[0];
      left.position[0] += 0.015;
      left.orientation = {std::sin(0.05), 0.0, 0.0, std::cos(0.05)};
      real.bench.press();
      // THEN the tool stays
      for (int i = 0; i < 100; ++i) {
        const wire::ItpPacket packet = real.tick();
        ASSERT_EQ(packet.surgeon_mode, 1);
        ASSERT_EQ(packet.delx_um[0], 0) << stall << " " << pressed_amidst << " " << i;
        ASSERT_NEAR(packet.Qx[0], 0.0, 1e-12);
      }
      // and the hand's later motion counts
      left.position[1] += 0.004;
      int moved = 0;
      for (int i = 0; i < 30; ++i)
        moved += real.tick().dely_um[0];
      EXPECT_EQ(moved, 400);
    }
  }
}

TEST(RealHands, ATurnIsAddedToTheOneBeforeTheClutch) {
  RealConsole real(0.1, /*orientation=*/true);
  real.warmUp();
  DeviceSample& left = real.bench.samples[0];
  const auto turnBy = [&](double angle, const Eigen::Vector3d& about) {
    left.orientation =
        toArray(Eigen::Quaterniond(Eigen::AngleAxisd(angle, about)) * Eigen::Quaterniond(toEigen(left.orientation)));
  };
  Eigen::Quaterniond turned = Eigen::Quaterniond::Identity();
  for (int stroke = 0; stroke < 3; ++stroke) {
    real.bench.press();
    real.tick();
    for (int i = 0; i < 100; ++i) {
      turnBy(0.005, Eigen::Vector3d::UnitZ());
      const wire::ItpPacket packet = real.tick();
      ASSERT_EQ(packet.surgeon_mode, 1);
      turned = Eigen::Quaterniond(packet.Qw[0], packet.Qx[0], packet.Qy[0], packet.Qz[0]) * turned;
    }
    real.bench.press(0);
    for (int i = 0; i < 100; ++i) {  // with the pedal up, the hand rotates elsewhere
      turnBy(-0.004, Eigen::Vector3d::UnitX());
      ASSERT_EQ(real.tick().surgeon_mode, 0);
    }
  }
  const Eigen::Quaterniond wanted(Eigen::AngleAxisd(3 * 0.5, Eigen::Vector3d::UnitZ()));
  EXPECT_LT(turned.angularDistance(wanted), 1e-6);
}

TEST(RealHands, TheSumOfTheIncrementsIsTheScaledMotion) {
  RealConsole real;
  real.warmUp();
  real.bench.press();
  Vec3& p = real.bench.samples[0].position;
  real.tick();
  const Vec3 start = p;
  std::array<std::int64_t, 3> sum{};
  for (int i = 0; i < 3000; ++i) {
    p = {start[0] + 0.03 * std::sin(1e-3 * i), start[1] + 1e-5 * i, start[2] - 0.5e-5 * i};
    const wire::ItpPacket packet = real.tick();
    ASSERT_EQ(packet.surgeon_mode, 1) << i;
    sum[0] += packet.delx_um[0];
    sum[1] += packet.dely_um[0];
    sum[2] += packet.delz_um[0];
  }
  for (std::size_t k = 0; k < 3; ++k)
    EXPECT_NEAR(static_cast<double>(sum[k]), 1e5 * (p[k] - start[k]), 0.51);
}

TEST(DeviceSurgeon, ThePedalIsTheButtonOfTheFileOnEitherDevice) {
  for (const Arm arm : kArms) {
    for (const int button : {0, 3, 31}) {
      MasterConfig config = testMaster();
      config.pedal_from = arm == Arm::kGold ? PedalFrom::kLeft : PedalFrom::kRight;
      config.pedal_button = button;
      DeviceBench bench(config);
      bench.warmUp();
      at(bench.samples, arm).buttons = ~(1U << static_cast<unsigned>(button));
      EXPECT_FALSE(bench.tick().pedal) << name(arm) << " " << button;
      at(bench.samples, arm).buttons = 1U << static_cast<unsigned>(button);
      EXPECT_TRUE(bench.tick().pedal) << name(arm) << " " << button;
    }
  }
}

TEST(DeviceSurgeon, AllNeedsEachDeviceThatIsThere) {
  for (const Arm arm : kArms) {
    for (const bool other_is_used : {true, false}) {
      MasterConfig config = testMaster();
      config.pedal_from = PedalFrom::kAll;
      at(config.devices, otherArm(arm)).is_used = other_is_used;
      DeviceBench bench(config);
      bench.warmUp();
      at(bench.samples, arm).buttons = 1;
      EXPECT_EQ(bench.tick().pedal, !other_is_used) << name(arm);
    }
  }
}

}  // namespace
}  // namespace raven2_trainer::console
