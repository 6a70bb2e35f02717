#include "raven2_trainer/control/servo_trim.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "raven2_trainer/core/random.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"

namespace raven2_trainer::control {
namespace {

/** Joints' limits of raven2.md 2.3. */
ArmGeometry jointLimits() {
  ArmGeometry geometry;
  geometry.q_min = {0.0, 0.25 * kPi, 0.23};
  geometry.q_max = {0.5 * kPi, 0.75 * kPi, 0.56};
  return geometry;
}

constexpr JointArray kAsked{0.5, 1.6, 0.4, 0.1, -0.2, 0.7, 0.6};

/** Joints that dry friction stops short of their targets, and that creep once they are pushed beyond it. */
struct StickyRobot {
  ServoTrim::Joints friction{1.2e-3, 3.5e-3, 3.4e-4};  ///< [rad, rad, m] over its kp
  JointArray q{};

  void follow(const JointArray& asked) {
    for (std::size_t j = 0; j < ServoTrim::kJoints; ++j)
      q[j] = std::min(std::max(q[j], asked[j] - friction[j]), asked[j] + friction[j]);
  }
};

TEST(ServoTrim, BringsARobotThatStoppedShortToWhereItWasAskedToBe) {
  StickyRobot robot;
  robot.q = {0.3, 1.8, 0.3};  // from below and from above
  robot.follow(kAsked);
  ASSERT_NEAR(robot.q[1], kAsked[1] + 3.5e-3, 1e-12);
  ServoTrim trim(1.0, jointLimits());
  for (int tick = 0; tick < 3000; ++tick) {
    trim.step(kAsked, robot.q, /*rests=*/true);
    robot.follow(trim.with(kAsked));
  }
  for (std::size_t j = 0; j < ServoTrim::kJoints; ++j)
    EXPECT_NEAR(robot.q[j], kAsked[j], ServoTrim::kEnough[j] * 1.01) << j;
}

TEST(ServoTrim, AsksForNothingBeyondAJointsLimit) {
  const ArmGeometry geometry = jointLimits();
  for (const double side : {-1.0, 1.0}) {
    JointArray asked = side < 0.0 ? geometry.q_min : geometry.q_max, measured = asked;
    for (std::size_t j = 0; j < ServoTrim::kJoints; ++j) {
      asked[j] -= side * 0.2 * ServoTrim::kLimit[j];
      measured[j] = asked[j] - side * ServoTrim::kLimit[j];
    }
    ServoTrim trim(0.1, geometry);
    for (int tick = 0; tick < 3000; ++tick)
      trim.step(asked, measured, true);
    for (std::size_t j = 0; j < ServoTrim::kJoints; ++j)
      EXPECT_NEAR(trim.joints()[j], side * (0.2 * ServoTrim::kLimit[j] - ServoTrim::kInside), 1e-12) << j;
  }
}

TEST(ServoTrim, LeavesTheToolsJointsToTheRobot) {
  ServoTrim trim(1.0, jointLimits());
  JointArray measured = kAsked;
  for (double& q : measured)
    q += 0.01;
  for (int tick = 0; tick < 3000; ++tick)
    trim.step(kAsked, measured, true);
  for (std::size_t j = ServoTrim::kJoints; j < kAsked.size(); ++j)
    EXPECT_EQ(trim.with(kAsked)[j], kAsked[j]) << j;
}

TEST(ServoTrim, PressesNoHarderAgainstWhatHoldsTheToolBack) {
  ServoTrim trim(0.1, jointLimits());
  const JointArray held{0.4, 1.7, 0.3, 0.1, -0.2, 0.7, 0.6};
  for (int tick = 0; tick < 100000; ++tick)
    trim.step(kAsked, held, true);
  EXPECT_EQ(trim.joints()[0], ServoTrim::kLimit[0]);
  EXPECT_EQ(trim.joints()[1], -ServoTrim::kLimit[1]);
  EXPECT_EQ(trim.joints()[2], ServoTrim::kLimit[2]);
}

TEST(ServoTrim, IsForgottenWithoutAStepWhileTheSetPointMoves) {
  ServoTrim trim(1.0, jointLimits());
  JointArray measured = kAsked;
  measured[1] -= 3e-3;
  for (int tick = 0; tick < 2000; ++tick)
    trim.step(kAsked, measured, true);
  double before = trim.joints()[1];
  ASSERT_GT(before, 3e-3);
  for (int tick = 0; tick < 5000; ++tick) {
    trim.step(kAsked, measured, false);
    EXPECT_LE(std::abs(trim.joints()[1] - before), ServoTrim::kLimit[1] * kTickSeconds * 1.001);
    before = trim.joints()[1];
  }
  EXPECT_LT(std::abs(before), 1e-4);
}

TEST(ServoTrim, WithoutTimeOrAMeasurementThereIsNone) {
  ServoTrim none(0.0, jointLimits()), blind(1.0, jointLimits());
  JointArray measured{};
  none.step(kAsked, measured, true);
  measured.fill(std::numeric_limits<double>::quiet_NaN());
  blind.step(kAsked, measured, true);
  EXPECT_EQ(none.joints(), ServoTrim::Joints{});
  EXPECT_EQ(blind.joints(), ServoTrim::Joints{});
}

TEST(ServoTrim, WithAndWithoutAreEachOthersInverse) {
  Random random(7);
  ServoTrim trim(0.01, jointLimits());
  JointArray measured = kAsked;
  for (double& q : measured)
    q += random.uniform(-0.004, 0.004);
  for (int tick = 0; tick < 20; ++tick)
    trim.step(kAsked, measured, true);
  const JointArray back = trim.without(trim.with(kAsked));
  for (std::size_t j = 0; j < kAsked.size(); ++j)
    EXPECT_NEAR(back[j], kAsked[j], 1e-15) << j;
}

TEST(Displacement, IsThatOfTheTool) {
  ArmGeometry geometry;
  geometry.d4 = -0.47;
  geometry.lw = 0.013;
  JointArray to = kAsked;
  to[0] += 2e-3;
  to[1] -= 3e-3;
  to[2] += 3e-4;
  for (const Arm arm : kArms) {
    const Pose X = kinematics::forward(geometry, arm, kAsked), Y = kinematics::forward(geometry, arm, to);
    const Displacement d = displacement(geometry, arm, kAsked, to);
    EXPECT_GT(d.p.norm(), 1e-4);
    EXPECT_LT((d.of(X).p - Y.p).norm(), 1e-12);
    EXPECT_LT((d.of(X).R - Y.R).norm(), 1e-12);
    EXPECT_LT((d.before(Y).p - X.p).norm(), 1e-12);
    EXPECT_LT((d.before(Y).R - X.R).norm(), 1e-12);
  }
}

}  // namespace
}  // namespace raven2_trainer::control
