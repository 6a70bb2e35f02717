#include "raven2_trainer/control/teleop_mapper.h"

#include <gtest/gtest.h>

#include "raven2_trainer/control/axis_map.h"
#include "raven2_trainer/core/random.h"

namespace raven2_trainer::control {
namespace {

using kinematics::IkStatus;

constexpr double kDegree = kPi / 180.0;

ArmGeometry raven() {
  ArmGeometry g;
  g.d4 = -0.47;
  g.lw = 0.013;
  g.q_min = {0, 45 * kDegree, 0.23, -182 * kDegree, -70 * kDegree, -105 * kDegree, -105 * kDegree};
  g.q_max = {90 * kDegree, 135 * kDegree, 0.56, 182 * kDegree, 70 * kDegree, 105 * kDegree, 105 * kDegree};
  g.home = {30 * kDegree, 90 * kDegree, 0.40, 0, 0, 45 * kDegree, 45 * kDegree};
  return g;
}

TEST(AxisMap, MatchesTheRunningRobot) {
  // raven2.md 1.4, observed: gold dely = +1000 -> z +1000; green delx = +1000 -> y +1000
  EXPECT_EQ(Vector3(itpToBase(Arm::kGold) * Vector3(0, 1, 0)), Vector3(0, 0, 1));
  EXPECT_EQ(Vector3(itpToBase(Arm::kGold) * Vector3(0, 0, 1)), Vector3(-1, 0, 0));
  EXPECT_EQ(Vector3(itpToBase(Arm::kGreen) * Vector3(1, 0, 0)), Vector3(0, 1, 0));
  for (const Arm arm : kArms)
    EXPECT_DOUBLE_EQ(itpToBase(arm).determinant(), 1.0);
}

TEST(TeleopMapper, SumOfIncrementsIsTheDisplacement) {
  const ArmGeometry g = raven();
  for (const Arm arm : kArms) {
    TeleopMapper mapper(g, arm);
    const Vector3 start = mapper.desiredPose().p;
    Random random(3);
    Vector3 sum = Vector3::Zero();
    JointArray q = g.home;
    for (int i = 0; i < 2000; ++i) {
      const Vec3 dp{std::round(random.uniform(-40, 40)) * 1e-6, std::round(random.uniform(-40, 40)) * 1e-6,
                    std::round(random.uniform(-40, 40)) * 1e-6};
      sum += toEigen(dp);
      ASSERT_EQ(mapper.add(dp, kIdentityQuat, 0.0, q), IkStatus::kOk);
      q = mapper.desired();
    }
    const Vector3 moved = mapper.desiredPose().p - start;
    EXPECT_LT((moved - itpToBase(arm) * sum).norm(), 1e-9);
    EXPECT_LT((kinematics::forward(g, arm, q).p - mapper.desiredPose().p).norm(), 1e-9);
  }
}

TEST(TeleopMapper, TruncatesToWholeMicrometres) {
  TeleopMapper mapper(raven(), Arm::kGold);
  const Vector3 start = mapper.desiredPose().p;
  mapper.add({0.9e-6, 0.0, 0.0}, kIdentityQuat, 0.0, raven().home);
  EXPECT_EQ(mapper.desiredPose().p, start);
}

TEST(TeleopMapper, TheDesiredPositionIsWholeMicrometresEvenAfterALimit) {
  // as in the robot, raven2.md 1.4: rounding at every re-basing moves the pose on
  const auto off_grid = [](const TeleopMapper& mapper) {
    const Vector3 um = mapper.desiredPose().p * 1e6;
    return (um - um.array().round().matrix()).norm();
  };
  const ArmGeometry g = raven();
  JointArray q = g.home;
  q[kElbow] += 0.0123456;
  TeleopMapper mapper(g, Arm::kGold);
  mapper.rebase(q);
  EXPECT_LT(off_grid(mapper), 1e-6);
  const Vector3 exact = kinematics::forward(g, Arm::kGold, q).p;
  for (int i = 0; i < 3; ++i)
    EXPECT_LE(std::abs(mapper.desiredPose().p[i]), std::abs(exact[i])) << "cut towards zero";
  IkStatus status = IkStatus::kOk;
  for (int i = 0; i < 5000 && status != IkStatus::kClamped; ++i)
    status = mapper.add({0.0, 0.0, 100e-6}, kIdentityQuat, 0.0, mapper.desired());
  ASSERT_EQ(status, IkStatus::kClamped);
  EXPECT_LT(off_grid(mapper), 1e-6);
}

TEST(TeleopMapper, ReBasesAtALimitSoThatTheWayBackStartsAtOnce) {
  const ArmGeometry g = raven();
  TeleopMapper mapper(g, Arm::kGold);
  JointArray q = g.home;
  const Vec3 deeper{0.0, 0.0, 100e-6};  // ITP z is down: into the body
  IkStatus status = IkStatus::kOk;
  for (int i = 0; i < 5000 && status == IkStatus::kOk; ++i) {
    status = mapper.add(deeper, kIdentityQuat, 0.0, q);
    q = mapper.desired();
  }
  ASSERT_EQ(status, IkStatus::kClamped);
  for (int i = 0; i < 200; ++i)
    mapper.add(deeper, kIdentityQuat, 0.0, q);  // pushing on must not wind up
  const JointArray at_limit = mapper.desired();
  for (int i = 0; i < 10; ++i)
    mapper.add({0.0, 0.0, -100e-6}, kIdentityQuat, 0.0, mapper.desired());
  const Pose before = kinematics::forward(g, Arm::kGold, at_limit);
  const Pose after = kinematics::forward(g, Arm::kGold, mapper.desired());
  EXPECT_NEAR((after.p - before.p).norm(), 1e-3, 1e-5);
}

TEST(TeleopMapper, KeepsTheJointsWhenTheTargetIsRefused) {
  const ArmGeometry g = raven();
  TeleopMapper mapper(g, Arm::kGold);
  // 60 mm in one packet: far beyond the robot's rule for one step
  EXPECT_NE(mapper.add({0.0, 0.0, 0.06}, kIdentityQuat, 0.0, g.home), IkStatus::kOk);
  EXPECT_EQ(mapper.desired(), g.home);
}

TEST(TeleopMapper, GoesOnThroughASingularWrist) {
  // The jaw axis passes through the remote centre where lw = d cos(wrist), d the insertion above it.
  const ArmGeometry g = raven();
  JointArray q{0.6, 1.5, 0.0, 0.4, 0.9, 0.2, 0.5};
  // 8 um from it: cutting the position to micrometres then swings the roll by a fraction of a radian only.
  q[kInsertion] = g.lw / std::cos(q[kWrist]) - g.d4 + 8e-6 / std::cos(q[kWrist]);
  TeleopMapper mapper(g, Arm::kGold);
  mapper.rebase(q);
  EXPECT_EQ(mapper.add({}, kIdentityQuat, 0.1, q), IkStatus::kSingularWrist);
  EXPECT_NEAR(kinematics::jawOpening(mapper.desired()), 0.6, 1e-9) << "the jaws still close";
  EXPECT_NEAR(mapper.desired()[kToolRotation], q[kToolRotation], 0.5);
  EXPECT_LT((kinematics::forward(g, Arm::kGold, mapper.desired()).p - mapper.desiredPose().p).norm(), 1e-12);
}

TEST(TeleopMapper, ClampsTheGrasp) {
  const ArmGeometry g = raven();
  TeleopMapper mapper(g, Arm::kGold);
  mapper.add({}, kIdentityQuat, 10.0, g.home);
  EXPECT_NEAR(kinematics::jawOpening(mapper.desired()), -0.174, 1e-12);
  mapper.add({}, kIdentityQuat, -10.0, mapper.desired());
  EXPECT_NEAR(kinematics::jawOpening(mapper.desired()), 1.570, 1e-12);
}

TEST(TeleopMapper, TheWantedOpeningIsKeptUpTo45DegreesFromTheRobotsEitherWay) {
  // raven2.md 1.4: with the pedal up
  const ArmGeometry g = raven();
  for (const Arm arm : kArms) {
    for (const double degrees : {-46.0, -44.0, 44.0, 46.0}) {
      TeleopMapper mapper(g, arm);
      mapper.setOpening(0.8);
      JointArray robot = g.home;
      const double actual = 0.8 + degrees * kDegree;
      kinematics::setJaws(0.3, actual, &robot);
      mapper.rebase(robot);
      const double expected = std::abs(degrees) < 45.0 ? 0.8 : actual;
      EXPECT_NEAR(mapper.opening(), expected, 1e-12) << degrees;
      EXPECT_NEAR(kinematics::jawOpening(mapper.desired()), expected, 1e-12) << degrees;
      EXPECT_NEAR(kinematics::jawMidline(mapper.desired()), 0.3, 1e-12) << degrees;
      mapper.rebasePose(g.home);
      EXPECT_NEAR(kinematics::jawOpening(mapper.desired()), expected, 1e-12) << "what is held stays held";
    }
  }
}

TEST(TeleopMapper, AQuaternionAndItsNegativeAreTheSameRotationForBothArms) {
  const ArmGeometry g = raven();
  Random random(8);
  for (const Arm arm : kArms) {
    for (int i = 0; i < 50; ++i) {
      const Vector3 axis(random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0));
      const Quaternion turn(Eigen::AngleAxisd(random.uniform(-0.1, 0.1), axis.normalized()));
      const Matrix3 expected =
          itpToBase(arm) * turn.toRotationMatrix() * itpToBase(arm).transpose() * kinematics::forward(g, arm, g.home).R;
      for (const Quat& dq : {toArray(turn), toArray(Quaternion(-turn.coeffs()))}) {
        TeleopMapper mapper(g, arm);
        ASSERT_EQ(mapper.add({}, dq, 0.0, g.home), IkStatus::kOk);
        EXPECT_LT((mapper.desiredPose().R - expected).norm(), 1e-12);
        EXPECT_LT((kinematics::forward(g, arm, mapper.desired()).R - expected).norm(), 1e-9);
      }
    }
  }
}

TEST(TeleopMapper, RotationsMultiplyFromTheLeftInTheBase) {
  const ArmGeometry g = raven();
  TeleopMapper mapper(g, Arm::kGreen);
  const Matrix3 before = mapper.desiredPose().R;
  const Quaternion turn(Eigen::AngleAxisd(0.05, Vector3::UnitX()));
  mapper.add({}, toArray(turn), 0.0, g.home);
  const Vector3 axis_B = itpToBase(Arm::kGreen) * Vector3::UnitX();
  const Matrix3 expected = Eigen::AngleAxisd(0.05, axis_B).toRotationMatrix() * before;
  EXPECT_LT((mapper.desiredPose().R - expected).norm(), 1e-12);
}

}  // namespace
}  // namespace raven2_trainer::control
