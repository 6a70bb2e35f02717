#include "raven2_trainer/control/path_relay.h"

#include <gtest/gtest.h>

#include <cmath>

#include "raven2_trainer/control/path_follower.h"
#include "raven2_trainer/core/random.h"
#include "support/sanitizer.h"

namespace raven2_trainer::control {
namespace {

constexpr double kDegree = kPi / 180.0;
constexpr IncrementLimits kLimits{2000.0, 0.1};               // network.yaml
const ArmController kNoLead(ControllerConfig{}, Arm::kGold);  // a law without gains
constexpr JointArray kVelocity{0.5, 0.5, 0.1, 2.0, 2.0, 2.0, 2.0};
constexpr JointArray kAcceleration{2.0, 2.0, 0.5, 10.0, 10.0, 10.0, 10.0};

ArmGeometry raven() {
  ArmGeometry g;
  g.d4 = -0.47;
  g.lw = 0.013;
  g.q_min = {0, 45 * kDegree, 0.23, -182 * kDegree, -70 * kDegree, -105 * kDegree, -105 * kDegree};
  g.q_max = {90 * kDegree, 135 * kDegree, 0.56, 182 * kDegree, 70 * kDegree, 105 * kDegree, 105 * kDegree};
  g.home = {30 * kDegree, 90 * kDegree, 0.40, 0, 0, 45 * kDegree, 45 * kDegree};
  return g;
}

/**
 * The robot's side of the increments, written down from raven2.md 1.4 with integers and a rotation matrix: gold
 * (x, y, z)_B = (-z, -x, y)_I, green (-z, x, -y)_I; micrometres and rotations are added up.
 */
class RobotSide {
 public:
  RobotSide(const ArmGeometry& geometry, Arm arm, const JointArray& q) : geometry_(geometry), arm_(arm), q_(q) {
    const Pose X_BT = kinematics::forward(geometry, arm, q);
    for (std::size_t i = 0; i < 3; ++i)
      p_um_[i] = static_cast<long>(X_BT.p[static_cast<Eigen::Index>(i)] * 1e6);
    R_BT_ = X_BT.R;
    opening_ = kinematics::jawOpening(q);
  }

  /** Takes a packet's content: whole micrometres, and the quaternion's doubles. */
  void receive(const TipIncrement& increment) {
    std::array<long, 3> um{};
    for (std::size_t i = 0; i < 3; ++i)
      um[i] = std::lround(increment.dp_I[i] * 1e6);
    const long sign = arm_ == Arm::kGold ? 1 : -1;
    p_um_[0] -= um[2];
    p_um_[1] -= sign * um[0];
    p_um_[2] += sign * um[1];
    const Quat& dq = increment.dq_I;
    const double side = static_cast<double>(sign);
    const Quaternion in_base(dq[3], -dq[2], -side * dq[0], side * dq[1]);
    R_BT_ = in_base.normalized().toRotationMatrix() * R_BT_;
    const auto ik = kinematics::inverseWithinLimits(geometry_, arm_, pose(), opening_, q_);
    usable_ = usable_ && ik.status == kinematics::IkStatus::kOk;
    q_ = ik.q;
  }

  Pose pose() const { return {R_BT_, Vector3(p_um_[0], p_um_[1], p_um_[2]) * 1e-6}; }
  const JointArray& joints() const { return q_; }
  bool usable() const { return usable_; }

 private:
  ArmGeometry geometry_;
  Arm arm_;
  JointArray q_;
  std::array<long, 3> p_um_{};
  Matrix3 R_BT_;
  double opening_;
  bool usable_{true};
};

JointArray near(const JointArray& q, Random* random) {
  constexpr JointArray kReach{0.3, 0.3, 0.03, 0.8, 0.5, 0.3, 0.3};
  JointArray moved = q;
  for (std::size_t j = 0; j < kGrasp1; ++j)
    moved[j] += random->uniform(-kReach[j], kReach[j]);
  kinematics::setJaws(random->uniform(-0.5, 0.5), kinematics::jawOpening(q), &moved);
  return moved;
}

/** A path of random waypoints in the middle of the workspace, each edge as fast as the planner's limits allow. */
PlanResult randomPlan(Arm arm, std::uint64_t seed) {
  Random random(seed);
  PlanResult plan;
  plan.status = PlanStatus::kSuccess;
  plan.arm = arm;
  plan.waypoint_count = 4;
  plan.waypoints[0] = raven().home;
  for (std::uint32_t i = 1; i < plan.waypoint_count; ++i) {
    plan.waypoints[i] = near(raven().home, &random);
    JointArray delta{};
    for (std::size_t j = 0; j < kJointCount; ++j)
      delta[j] = plan.waypoints[i][j] - plan.waypoints[i - 1][j];
    plan.arrival[i] = plan.arrival[i - 1] + quinticDuration(delta, kVelocity, kAcceleration);
  }
  return plan;
}

/** A straight edge to `goal` in two seconds. */
PlanResult edgeTo(const JointArray& goal) {
  PlanResult plan;
  plan.status = PlanStatus::kSuccess;
  plan.waypoint_count = 2;
  plan.waypoints[0] = raven().home;
  plan.waypoints[1] = goal;
  plan.arrival[1] = 2.0;
  return plan;
}

double tipDistance(const Pose& a, const Pose& b) {
  return (a.p - b.p).norm();
}

double angleBetween(const Matrix3& a, const Matrix3& b) {
  return Eigen::AngleAxisd(a * b.transpose()).angle();
}

TEST(PathRelay, TheRobotsInverseKinematicsComesToThePathsJointsAtEveryTick) {
  const std::uint64_t seeds = raven2_trainer::testing::kIsSanitized ? 4 : 20;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    const Arm arm = seed % 2 == 0 ? Arm::kGold : Arm::kGreen;
    const PlanResult plan = randomPlan(arm, seed);
    PathRelay relay(raven(), kLimits);
    RobotSide robot(raven(), arm, plan.waypoints[0]);
    relay.start(arm, plan.waypoints[0]);
    PathFollower path;
    for (path.start(plan); path.active();) {
      const JointArray q = path.tick();
      robot.receive(relay.advance(q));
      const Pose X_BT = kinematics::forward(raven(), arm, q);
      ASSERT_TRUE(relay.isUpToDate());
      ASSERT_TRUE(robot.usable()) << "seed " << seed;
      // half a micrometre an axis, sqrt(3)/2 um in all
      ASSERT_LT(tipDistance(robot.pose(), X_BT), 0.9e-6) << "seed " << seed;
      ASSERT_LT(tipDistance(kinematics::forward(raven(), arm, robot.joints()), X_BT), 1e-6);
      ASSERT_LT(angleBetween(robot.pose().R, X_BT.R), 1e-9);
      for (std::size_t j = 0; j < kJointCount; ++j)
        ASSERT_NEAR(robot.joints()[j], q[j], 2e-4) << kJointNames[j] << ", seed " << seed;
    }
    EXPECT_TRUE(robotFollows(raven(), kLimits, kNoLead, plan)) << "seed " << seed;
  }
}

TEST(PathRelay, StartsFromWhereverTheRobotStands) {
  const JointArray home = raven().home;
  JointArray apart = home;
  apart[0] += 0.004;
  PathRelay relay(raven(), kLimits);
  RobotSide robot(raven(), Arm::kGold, apart);
  relay.start(Arm::kGold, apart);
  robot.receive(relay.advance(home));
  for (std::size_t j = 0; j < kJointCount; ++j)
    EXPECT_NEAR(robot.joints()[j], home[j], 1e-4);
}

TEST(PathRelay, WhatAPacketCannotHoldComesInTheNext) {
  JointArray far = raven().home;
  far[0] += 0.05;
  far[3] += 0.35;
  PathRelay relay(raven(), kLimits);
  RobotSide robot(raven(), Arm::kGold, raven().home);
  relay.start(Arm::kGold, raven().home);
  int packets = 0;
  do {
    const TipIncrement increment = relay.advance(far);
    for (const double step : increment.dp_I)
      ASSERT_LE(std::abs(step), 2000e-6 + 1e-12);
    ASSERT_LE(2.0 * std::acos(std::min(1.0, toEigen(increment.dq_I).w())), 0.1 + 1e-9);
    robot.receive(increment);
    ++packets;
  } while (!relay.isUpToDate() && packets < 100);
  EXPECT_GE(packets, 4) << "0.35 rad of 0.1 each";
  EXPECT_LE(packets, 6);
  EXPECT_LT(tipDistance(robot.pose(), kinematics::forward(raven(), Arm::kGold, far)), 1e-6);
}

TEST(PathRelay, SendsNothingWhileThePathStandsStill) {
  PathRelay relay(raven(), kLimits);
  relay.start(Arm::kGreen, raven().home);
  relay.advance(raven().home);  // sends the remainder of rounding at the start
  const TipIncrement increment = relay.advance(raven().home);
  EXPECT_EQ(increment.dp_I, Vec3{});
  EXPECT_LT(toEigen(increment.dq_I).vec().norm(), 1e-12);
}

TEST(PathRelay, SendsTheShortRotationWhereverTheOrientationIs) {
  // GIVEN a full revolution of the roll, and the wrist's range: the pose's quaternion changes its sign in between
  for (const Arm arm : kArms) {
    for (const std::size_t joint : {kToolRotation, kWrist}) {
      PathRelay relay(raven(), kLimits);
      JointArray q = raven().home;
      const double end = joint == kWrist ? 1.2 : kPi;
      q[joint] = -end;
      relay.start(arm, q);
      relay.advance(q);
      while ((q[joint] += 0.01) < end) {
        const Quat dq = relay.advance(q).dq_I;
        ASSERT_TRUE(relay.isUpToDate()) << q[joint];
        ASSERT_NEAR(dq[3], std::cos(0.005), 1e-9) << q[joint];
      }
    }
  }
}

TEST(PathRelay, FillsNoPacketBeyondItsLimitInAnyDirection) {
  for (const Arm arm : kArms) {
    for (const double sign : {-1.0, 1.0}) {
      for (std::size_t j = 0; j < kGrasp1; ++j) {
        PathRelay relay(raven(), {500.0, 0.01});
        relay.start(arm, raven().home);
        JointArray far = raven().home;
        far[j] += sign * (j == kInsertion ? 0.02 : 0.2);
        const TipIncrement increment = relay.advance(far);
        EXPECT_FALSE(relay.isUpToDate());
        for (const double step : increment.dp_I)
          EXPECT_LE(std::abs(step), 500e-6 + 1e-12) << kJointNames[j];
        EXPECT_LE(2.0 * toEigen(increment.dq_I).vec().norm(), 0.01 + 1e-9) << kJointNames[j];
      }
    }
  }
}

TEST(RobotFollows, NotWhereTheLawLeadsBeyondALimitThatThePathItselfKeeps) {
  // GIVEN the wrist to 69 of its 70 degrees in 2 s: a lead of 0.2 s is beyond the end of a quintic by
  // 40 (0.2 / 2)^3 = 4 % at most, 2.8 degrees
  ControllerConfig leading;
  leading.gains.fill({100.0, 20.0, 0.0, 50.0});
  for (const Arm arm : kArms) {
    for (const double degrees : {-69.0, 69.0}) {
      JointArray goal = raven().home;
      goal[kWrist] = degrees * kDegree;
      PlanResult plan = edgeTo(goal);
      plan.arm = arm;
      EXPECT_TRUE(robotFollows(raven(), kLimits, kNoLead, plan)) << degrees;
      EXPECT_FALSE(robotFollows(raven(), kLimits, ArmController(leading, arm), plan)) << degrees;
    }
  }
}

TEST(RobotFollows, NotThroughAJointLimit) {
  JointArray beyond = raven().home;
  beyond[4] = 75 * kDegree;
  EXPECT_FALSE(robotFollows(raven(), kLimits, kNoLead, edgeTo(beyond)));
}

TEST(RobotFollows, NotWhereTheWristComesTooNearToTheRemoteCentre) {
  JointArray near_centre = raven().home;
  near_centre[2] = 0.465;  // the remote centre is at 470 mm: 5 mm away, less than 13
  EXPECT_FALSE(robotFollows(raven(), kLimits, kNoLead, edgeTo(near_centre)));
  near_centre[2] = 0.44;
  EXPECT_TRUE(robotFollows(raven(), kLimits, kNoLead, edgeTo(near_centre)));
}

TEST(RobotFollows, NotInPacketsThatAreTooSmall) {
  JointArray moved = raven().home;
  moved[0] += 0.2;
  EXPECT_TRUE(robotFollows(raven(), kLimits, kNoLead, edgeTo(moved)));
  EXPECT_FALSE(robotFollows(raven(), {2.0, 0.1}, kNoLead, edgeTo(moved)));
  EXPECT_FALSE(robotFollows(raven(), {2000.0, 1e-6}, kNoLead, edgeTo(moved)));
}

TEST(RobotFollows, NotAPlanThatIsNone) {
  PlanResult plan = edgeTo(raven().home);
  plan.status = PlanStatus::kNoPath;
  EXPECT_FALSE(robotFollows(raven(), kLimits, kNoLead, plan));
  plan.status = PlanStatus::kSuccess;
  plan.waypoint_count = 0;
  EXPECT_FALSE(robotFollows(raven(), kLimits, kNoLead, plan));
  plan.waypoint_count = kMaxWaypoints + 1;
  EXPECT_FALSE(robotFollows(raven(), kLimits, kNoLead, plan));
}

}  // namespace
}  // namespace raven2_trainer::control
