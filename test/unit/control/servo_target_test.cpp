#include "raven2_trainer/control/servo_target.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "raven2_trainer/control/teleop_mapper.h"

namespace raven2_trainer::control {
namespace {

constexpr double kDegree = kPi / 180.0;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

ArmGeometry raven() {
  ArmGeometry g;
  g.d4 = -0.47;
  g.lw = 0.013;
  g.q_min = {0, 45 * kDegree, 0.23, -182 * kDegree, -70 * kDegree, -105 * kDegree, -105 * kDegree};
  g.q_max = {90 * kDegree, 135 * kDegree, 0.56, 182 * kDegree, 70 * kDegree, 105 * kDegree, 105 * kDegree};
  g.home = {30 * kDegree, 90 * kDegree, 0.40, 0, 0, 45 * kDegree, 45 * kDegree};
  return g;
}

CrtkConfig limits() {
  CrtkConfig c;
  c.max_speed = 0.1;
  c.max_turn_rate = 2.0;
  c.max_step = 0.02;
  c.max_step_turn = 0.4;
  c.move_speed = 0.04;
  c.move_turn_rate = 0.5;
  c.twist_timeout = 0.1;
  return c;
}

ServoJoints sum(ServoJoints a, const ServoJoints& b) {
  for (std::size_t j = 0; j < kServoJointCount; ++j)
    a[j] += b[j];
  return a;
}

double turnBetween(const Matrix3& a, const Matrix3& b) {
  return Eigen::AngleAxisd(Matrix3(a * b.transpose())).angle();
}

/** An arm whose mapping accepts every set point; the test is the client. */
class ServoTargetTest : public ::testing::TestWithParam<Arm> {
 protected:
  ServoTargetTest() : arm(GetParam()), geometry(raven()), target(limits(), geometry, arm) {
    standAt({0.6, 1.4, 0.35, 0.3, 0.2, 0.5, 0.9});
  }

  void standAt(const JointArray& joints) {
    q = joints;
    target.startFrom(poseOf(q), q, kinematics::jawOpening(q));
  }

  Pose poseOf(const JointArray& joints) const { return kinematics::forward(geometry, arm, joints); }

  ServoCommand command(ServoKind kind) const {
    ServoCommand c;
    c.kind = kind;
    c.arm = arm;
    return c;
  }
  ServoVerdict joints(ServoKind kind, const ServoJoints& values) {
    ServoCommand c = command(kind);
    c.joints = values;
    return target.take(c);
  }
  ServoVerdict pose(ServoKind kind, const Pose& X) {
    ServoCommand c = command(kind);
    c.pose_B = toArray(X);
    return target.take(c);
  }
  ServoVerdict twist(const Vec3& v, const Vec3& w) {
    ServoCommand c = command(ServoKind::kServoTwist);
    c.v_B = v;
    c.w_B = w;
    return target.take(c);
  }
  ServoVerdict jaw(ServoKind kind, double opening) {
    ServoCommand c = command(kind);
    c.jaw = opening;
    return target.take(c);
  }

  /** The set point moved by and turned about z of B. */
  Pose shifted(const Vector3& by, double turn = 0.0) const {
    return {Eigen::AngleAxisd(turn, Vector3::UnitZ()) * target.pose().R, target.pose().p + by};
  }

  /** A tick in which the mapping accepts the whole set point. Records the speeds. */
  void tick() {
    target.keepTo(target.pose(), q, target.opening());
    const Pose before = target.pose();
    target.step();
    speed = (target.pose().p - before.p).norm() / kTickSeconds;
    turn_rate = turnBetween(target.pose().R, before.R) / kTickSeconds;
    top_speed = std::max(top_speed, speed);
    top_turn_rate = std::max(top_turn_rate, turn_rate);
    const auto ik = kinematics::inverseWithinLimits(geometry, arm, target.pose(), target.opening(), q);
    ASSERT_TRUE(kinematics::isUsable(ik.status));
    for (std::size_t j = 0; j < kServoJointCount; ++j) {
      const double step = std::abs(servoJoints(ik.q)[j] - servoJoints(q)[j]);
      if (j != kInsertion) top_joint_rate = std::max(top_joint_rate, step / kTickSeconds);
    }
    q = ik.q;
  }
  void tick(int count) {
    for (int i = 0; i < count; ++i)
      tick();
  }
  /** @return ticks until no move is under way. */
  int finish() {
    int ticks = 0;
    for (; target.isMoving() && ticks < 100000; ++ticks)
      tick();
    return ticks;
  }

  /** Roll and the jaws' line rotated in opposite directions. */
  Pose bentOtherwise(double roll) const {
    JointArray to = bent;
    to[kToolRotation] += roll;
    kinematics::setJaws(kinematics::jawMidline(bent) + roll, kinematics::jawOpening(bent), &to);
    return poseOf(to);
  }

  const Arm arm;
  const ArmGeometry geometry;
  const JointArray bent{0.6, 1.4, 0.35, 0.3, 1.1, 0.5, 0.9};
  ServoTarget target;
  JointArray q{};
  double speed{}, turn_rate{}, top_speed{}, top_turn_rate{}, top_joint_rate{};  // [m/s], [rad/s]
};

TEST_P(ServoTargetTest, ServoJpLeadsAllJointsThereTogetherAndNoFasterThanAllowed) {
  const ServoJoints from = servoJoints(q), to{0.65, 1.36, 0.355, 0.1, 0.3, 0.35};
  ASSERT_EQ(joints(ServoKind::kServoJoints, to).reason, ServoRefusal::kNone);
  tick(50);
  const ServoJoints now = servoJoints(q);
  const double share = (now[0] - from[0]) / (to[0] - from[0]);
  EXPECT_GT(share, 0.05);
  EXPECT_LT(share, 0.95);
  for (std::size_t j = 0; j < kServoJointCount; ++j)
    EXPECT_NEAR((now[j] - from[j]) / (to[j] - from[j]), share, 1e-6) << j;
  tick(500);
  for (std::size_t j = 0; j < kServoJointCount; ++j)
    EXPECT_NEAR(servoJoints(q)[j], to[j], 1e-7) << j;
  EXPECT_LT(speed, 1e-9);
  EXPECT_LT(top_speed, 0.1 * 1.001);
  EXPECT_LT(top_turn_rate, 2.0 * 1.001);
  EXPECT_GT(std::max(top_speed / 0.1, top_turn_rate / 2.0), 0.99) << "as fast as it may";
  EXPECT_FALSE(target.isMoving()) << "only moves are";
}

TEST_P(ServoTargetTest, ServoCpLeadsAlongTheStraightLineWithTheTurnSpreadOverIt) {
  const Pose from = target.pose(), to = shifted({0.008, -0.006, 0.004}, 0.1);
  ASSERT_EQ(pose(ServoKind::kServoPose, to).reason, ServoRefusal::kNone);
  EXPECT_TRUE(target.hasGoal());
  EXPECT_NEAR((target.goal().p - to.p).norm(), 0.0, 1e-12);
  const Vector3 way = (to.p - from.p).normalized();
  for (int i = 0; i < 100; ++i) {
    tick();
    const Vector3 gone = target.pose().p - from.p;
    EXPECT_LT((gone - gone.dot(way) * way).norm(), 1e-9);
    EXPECT_NEAR(turnBetween(target.pose().R, from.R) / 0.1, gone.norm() / (to.p - from.p).norm(), 1e-6);
  }
  tick(50);  // 10.8 mm at 0.1 m/s: 108 ms
  EXPECT_LT((target.pose().p - to.p).norm(), 1e-12);
  EXPECT_LT(turnBetween(target.pose().R, to.R), 1e-9);
  EXPECT_NEAR(top_speed, 0.1, 1e-6);
}

TEST_P(ServoTargetTest, TheNewestServoCommandCounts) {
  const Pose first = shifted({0.015, 0.0, 0.0}), second = shifted({0.0, 0.01, 0.0});
  ASSERT_EQ(pose(ServoKind::kServoPose, first).reason, ServoRefusal::kNone);
  tick(50);
  ASSERT_EQ(pose(ServoKind::kServoPose, second).reason, ServoRefusal::kNone);
  tick(300);
  EXPECT_LT((target.pose().p - second.p).norm(), 1e-12);
}

TEST_P(ServoTargetTest, RelativeServoCommandsAddUp) {
  const Pose from = target.pose();
  for (int i = 0; i < 5; ++i)
    ASSERT_EQ(pose(ServoKind::kServoPoseBy, {Matrix3::Identity(), Vector3(0.001, 0.0, -0.002)}).reason,
              ServoRefusal::kNone);
  const Matrix3 turn = Eigen::AngleAxisd(0.05, Vector3::UnitX()).toRotationMatrix();
  ASSERT_EQ(pose(ServoKind::kServoPoseBy, {turn, Vector3::Zero()}).reason, ServoRefusal::kNone);
  tick(300);
  EXPECT_LT((target.pose().p - from.p - Vector3(0.005, 0.0, -0.01)).norm(), 1e-9);
  EXPECT_LT(turnBetween(target.pose().R, turn * from.R), 1e-7);
  const ServoJoints before = servoJoints(q);
  for (int i = 0; i < 3; ++i)
    ASSERT_EQ(joints(ServoKind::kServoJointsBy, {0.01, 0.0, 0.001, 0.0, 0.0, -0.02}).reason, ServoRefusal::kNone);
  tick(500);
  EXPECT_NEAR(servoJoints(q)[0], before[0] + 0.03, 1e-7);
  EXPECT_NEAR(servoJoints(q)[2], before[2] + 0.003, 1e-7);
  EXPECT_NEAR(servoJoints(q)[5], before[5] - 0.06, 1e-7);
}

TEST_P(ServoTargetTest, MillimetresForMetresAreTooFar) {
  const Pose before = target.pose();
  const ServoVerdict far = pose(ServoKind::kServoPose, shifted({5.0, 0.0, 0.0}));
  EXPECT_EQ(far.reason, ServoRefusal::kTooFar);
  EXPECT_EQ(far.is_turn, 0);
  EXPECT_NEAR(far.value, 5.0, 1e-9);
  EXPECT_EQ(far.limit, 0.02);
  const ServoVerdict turned = pose(ServoKind::kServoPose, shifted({0.0, 0.0, 0.001}, 0.5));
  EXPECT_EQ(turned.reason, ServoRefusal::kTooFar);
  EXPECT_EQ(turned.is_turn, 1);
  EXPECT_NEAR(turned.value, 0.5, 1e-9);
  EXPECT_EQ(pose(ServoKind::kServoPoseBy, {Matrix3::Identity(), Vector3(0.0, 3.0, 0.0)}).reason, ServoRefusal::kTooFar);
  ServoJoints to = servoJoints(q);
  to[kInsertion] += 0.03;
  const ServoVerdict pushed = joints(ServoKind::kServoJoints, to);
  EXPECT_EQ(pushed.reason, ServoRefusal::kTooFar);
  EXPECT_EQ(pushed.joint, kInsertion);
  EXPECT_EQ(pushed.is_turn, 0);
  EXPECT_NEAR(pushed.value, 0.03, 1e-12);
  EXPECT_EQ(joints(ServoKind::kServoJointsBy, {0.0, 0.0, 0.0, 0.5, 0.0, 0.0}).reason, ServoRefusal::kTooFar);
  tick(100);
  EXPECT_EQ(target.pose().p, before.p) << "a refused command moves nothing";
  EXPECT_FALSE(target.hasGoal());
}

TEST_P(ServoTargetTest, AJointThatStepsTooFarIsNamedInEitherDirection) {
  standAt({0.6, 1.4, 0.35, 0.0, 0.0, 0.5, 0.9});
  for (const double sign : {-1.0, 1.0}) {
    for (std::size_t j = 0; j < kServoJointCount; ++j) {
      ServoJoints by{};
      by[j] = sign * (j == kInsertion ? 0.03 : 0.5);
      const ServoVerdict verdict = joints(ServoKind::kServoJointsBy, by);
      EXPECT_EQ(verdict.reason, ServoRefusal::kTooFar) << j << " " << sign;
      EXPECT_EQ(verdict.joint, j) << sign;
      EXPECT_NEAR(verdict.value, std::abs(by[j]), 1e-12) << j << " " << sign;
    }
  }
}

TEST_P(ServoTargetTest, JointsBeyondTheirLimitsAreNamed) {
  ServoJoints to = servoJoints(q);
  to[kWrist] = 71 * kDegree;
  for (const ServoKind kind : {ServoKind::kServoJoints, ServoKind::kMoveJoints}) {
    const ServoVerdict verdict = joints(kind, to);
    EXPECT_EQ(verdict.reason, ServoRefusal::kOutOfRange);
    EXPECT_EQ(verdict.joint, kWrist);
    EXPECT_EQ(verdict.value, to[kWrist]);
    EXPECT_EQ(verdict.limit, geometry.q_max[kWrist]);
  }
  to = servoJoints(q);
  to[5] = -106 * kDegree;
  EXPECT_EQ(joints(ServoKind::kMoveJoints, to).joint, 5);
  to[5] = 0.0;
  to[kInsertion] = 0.22;
  EXPECT_EQ(joints(ServoKind::kMoveJoints, to).limit, 0.23);
  const ServoVerdict wide = jaw(ServoKind::kServoJaw, 90.0);  // degrees
  EXPECT_EQ(wide.reason, ServoRefusal::kOutOfRange);
  EXPECT_EQ(wide.joint, 6);
  EXPECT_EQ(wide.limit, 1.57);
  for (const ServoKind kind : {ServoKind::kServoJaw, ServoKind::kMoveJaw})
    EXPECT_EQ(jaw(kind, -61.0 * kDegree).reason, ServoRefusal::kOutOfRange);
  for (const ServoKind kind : {ServoKind::kServoJawBy, ServoKind::kMoveJawBy})
    EXPECT_EQ(jaw(kind, -11.0 * kDegree - target.opening()).reason, ServoRefusal::kOutOfRange);
}

TEST_P(ServoTargetTest, WhatIsNoNumberOrNoTurnIsRefused) {
  ServoJoints bad = servoJoints(q);
  bad[2] = kNan;
  EXPECT_EQ(joints(ServoKind::kServoJoints, bad).reason, ServoRefusal::kNotFinite);
  EXPECT_EQ(joints(ServoKind::kMoveJoints, bad).reason, ServoRefusal::kNotFinite);
  EXPECT_EQ(joints(ServoKind::kMoveJointsBy, bad).reason, ServoRefusal::kNotFinite);
  for (const ServoKind kind :
       {ServoKind::kServoJaw, ServoKind::kServoJawBy, ServoKind::kMoveJaw, ServoKind::kMoveJawBy})
    EXPECT_EQ(jaw(kind, kNan).reason, ServoRefusal::kNotFinite);
  ServoCommand ratio = command(ServoKind::kRatio);
  ratio.number = kNan;
  EXPECT_EQ(target.take(ratio).reason, ServoRefusal::kNotFinite);
  EXPECT_EQ(twist({0.0, kNan, 0.0}, {}).reason, ServoRefusal::kNotFinite);
  EXPECT_EQ(twist({}, {std::numeric_limits<double>::infinity(), 0.0, 0.0}).reason, ServoRefusal::kNotFinite);
  ServoCommand c = command(ServoKind::kServoPose);
  c.pose_B = toArray(target.pose());
  const Quat unit = c.pose_B.q;
  c.pose_B.q = {0.0, 0.0, 0.0, 0.0};
  EXPECT_EQ(target.take(c).reason, ServoRefusal::kNotFinite);
  for (std::size_t i = 0; i < 4; ++i)
    c.pose_B.q[i] = 0.9 * unit[i];
  EXPECT_EQ(target.take(c).reason, ServoRefusal::kNotFinite);
  for (std::size_t i = 0; i < 4; ++i)
    c.pose_B.q[i] = 1.005 * unit[i];
  EXPECT_EQ(target.take(c).reason, ServoRefusal::kNone) << "rounded to three digits";
  EXPECT_NEAR(target.goal().R.determinant(), 1.0, 1e-12);
  c.pose_B.p[1] = kNan;
  EXPECT_EQ(target.take(c).reason, ServoRefusal::kNotFinite);
}

TEST_P(ServoTargetTest, APoseWithoutJointsIsUnreachable) {
  JointArray outside = q;
  outside[kShoulder] = -0.05;
  EXPECT_EQ(pose(ServoKind::kMovePose, poseOf(outside)).reason, ServoRefusal::kUnreachable);
  EXPECT_EQ(pose(ServoKind::kMovePose, shifted({0.0, 0.0, 2.0})).reason, ServoRefusal::kUnreachable);
  EXPECT_FALSE(target.isMoving());
  JointArray edge = q;
  edge[kInsertion] = 0.5595;
  standAt(edge);
  JointArray past = q;
  past[kInsertion] = 0.565;
  EXPECT_EQ(pose(ServoKind::kServoPose, poseOf(past)).reason, ServoRefusal::kUnreachable);
}

/** With the wrist point within lw, 13 mm, of the remote centre, every inverse gives up. The centre is at 470 mm of
 * insertion. The robot's inverse gives up at the first of two points. Past the centre, this point is lw beyond the
 * tip, so that the robot's inverse gives up until 509 mm. */
TEST_P(ServoTargetTest, JointsOnWhoseWayAnInverseGivesUpAreUnreachable) {
  const auto inserted = [this](double metres) {
    ServoJoints to = servoJoints(q);
    to[kInsertion] = metres;
    return to;
  };
  standAt({0.6, 1.4, 0.445, 0.3, 0.2, 0.5, 0.9});
  const Pose before = target.pose();
  EXPECT_EQ(joints(ServoKind::kServoJoints, inserted(0.46)).reason, ServoRefusal::kUnreachable);
  EXPECT_EQ(joints(ServoKind::kServoJointsBy, {0.0, 0.0, 0.019, 0.0, 0.0, 0.0}).reason, ServoRefusal::kUnreachable);
  EXPECT_EQ(joints(ServoKind::kMoveJoints, inserted(0.47)).reason, ServoRefusal::kUnreachable);
  EXPECT_EQ(joints(ServoKind::kMoveJoints, inserted(0.55)).reason, ServoRefusal::kUnreachable) << "past the centre";
  EXPECT_FALSE(target.isMoving());
  EXPECT_EQ(joints(ServoKind::kMoveJoints, inserted(0.30)).reason, ServoRefusal::kNone);
  EXPECT_EQ(joints(ServoKind::kMoveJoints, inserted(0.55)).reason, ServoRefusal::kUnreachable)
      << "from the end of the queued move";
  target.hold();
  EXPECT_EQ(joints(ServoKind::kServoJoints, inserted(0.43)).reason, ServoRefusal::kNone);
  target.hold();
  EXPECT_EQ(target.pose().p, before.p);
  standAt({0.6, 1.4, 0.515, 0.3, 0.2, 0.5, 0.9});
  EXPECT_EQ(joints(ServoKind::kServoJoints, inserted(0.50)).reason, ServoRefusal::kUnreachable) << "for the robot";
  EXPECT_EQ(joints(ServoKind::kMoveJoints, inserted(0.56)).reason, ServoRefusal::kNone) << "to its very limit";
  standAt({0.6, 1.4, 0.47, 0.3, 0.2, 0.5, 0.9});
  EXPECT_EQ(joints(ServoKind::kServoJoints, inserted(0.486)).reason, ServoRefusal::kUnreachable) << "nor away from it";
}

TEST_P(ServoTargetTest, AnyWayInJointsAwayFromTheRemoteCentreIsTaken) {
  for (const double roll : {-3.1, -1.0, 2.0, 3.1}) {
    for (const double wrist : {-1.2, 0.0, 1.2}) {
      for (const double insertion : {0.231, 0.40}) {
        const ServoJoints to{1.5, 0.8, insertion, roll, wrist, -1.0};
        ASSERT_EQ(joints(ServoKind::kMoveJoints, to).reason, ServoRefusal::kNone) << roll << " " << wrist;
        target.hold();
      }
    }
  }
}

TEST_P(ServoTargetTest, AServoCommandThatCameToLeadTooFarIsDropped) {
  const auto stoodElsewhere = [this](double metres) {
    JointArray elsewhere = q;
    elsewhere[kInsertion] += metres;
    target.startFrom(poseOf(elsewhere), elsewhere, kinematics::jawOpening(elsewhere));
    return target.hasGoal();
  };
  const Pose start = target.pose();
  ASSERT_EQ(pose(ServoKind::kServoPose, shifted({0.0, 0.002, 0.0})).reason, ServoRefusal::kNone);
  EXPECT_TRUE(stoodElsewhere(0.005)) << "not far";
  EXPECT_FALSE(stoodElsewhere(-0.03));
  standAt(q);
  ServoJoints to = servoJoints(q);
  to[kShoulder] += 0.01;
  ASSERT_EQ(joints(ServoKind::kServoJoints, to).reason, ServoRefusal::kNone);
  EXPECT_TRUE(stoodElsewhere(0.005));
  EXPECT_FALSE(stoodElsewhere(-0.03));
  standAt(q);
  ASSERT_EQ(pose(ServoKind::kMovePose, start).reason, ServoRefusal::kNone);
  EXPECT_TRUE(stoodElsewhere(-0.03)) << "a move goes anywhere";
}

TEST_P(ServoTargetTest, AMoveOfTheJawsThatStartsAgainFromFartherAwayIsNoFaster) {
  ServoCommand move = command(ServoKind::kMoveJaw);
  move.jaw = target.opening() - 0.1;
  ASSERT_EQ(target.take(move).reason, ServoRefusal::kNone);
  target.startFrom(target.pose(), q, move.jaw + 1.0);
  double fastest = 0.0;
  for (int i = 0; i < 10000 && target.isMoving(); ++i) {
    const double before = target.opening();
    target.step();
    fastest = std::max(fastest, std::abs(target.opening() - before) / 1e-3);
  }
  EXPECT_NEAR(target.opening(), move.jaw, 1e-9);
  EXPECT_LT(fastest, 1.001 * limits().move_turn_rate) << "[rad/s]";
}

TEST_P(ServoTargetTest, MoveJpGoesFromRestToRestWithinTheRatesOfMoves) {
  const ServoJoints from = servoJoints(q), to{1.1, 1.9, 0.31, -1.2, -0.4, 0.0};
  ASSERT_EQ(joints(ServoKind::kMoveJoints, to).reason, ServoRefusal::kNone);
  EXPECT_TRUE(target.isMoving());
  tick(2);
  EXPECT_LT(speed, 1e-3);
  int ticks = 2;
  JointArray before = q;
  double fastest = 0.0;
  for (; target.isMoving() && ticks < 100000; ++ticks, before = q) {
    tick();
    const double share = (servoJoints(q)[0] - from[0]) / (to[0] - from[0]);
    for (std::size_t j = 1; j < kServoJointCount; ++j)
      ASSERT_NEAR((servoJoints(q)[j] - from[j]) / (to[j] - from[j]), share, 1e-6) << j;
    fastest = std::max(fastest, std::abs(q[kToolRotation] - before[kToolRotation]) / kTickSeconds);
  }
  EXPECT_LT(speed, 1e-3);
  for (std::size_t j = 0; j < kServoJointCount; ++j)
    EXPECT_NEAR(servoJoints(q)[j], to[j], 1e-7);
  EXPECT_LT(top_speed, 0.04 * 1.01);
  EXPECT_LT(top_turn_rate, 0.5 * 1.01);
  EXPECT_LT(fastest, 0.5 * 1.01);
  EXPECT_GT(std::max({top_speed / 0.04, top_turn_rate / 0.5, fastest / 0.5}), 0.9) << "no slower than necessary";
}

TEST_P(ServoTargetTest, MoveCpGoesStraightAndItsTimeIsThatOfTheQuintic) {
  const Pose from = target.pose(), to = shifted({0.03, 0.0, 0.0});
  ASSERT_EQ(pose(ServoKind::kMovePose, to).reason, ServoRefusal::kNone) << "farther than a servo command may";
  EXPECT_EQ(finish(), 1407) << "15/8 x 30 mm / 40 mm/s = 1.40625 s";
  EXPECT_LT((target.pose().p - to.p).norm(), 1e-12);
  EXPECT_NEAR(top_speed, 0.04, 1e-4);
  EXPECT_LT((target.pose().R - from.R).norm(), 1e-12);
}

/** With the wrist bent, the axes of roll and of the jaws' line are near each other. One rotated against the other
 * rotates the tip less than either alone. */
TEST_P(ServoTargetTest, NoJointIsFasterThanAllowedOnAStraightWayEither) {
  double slowest = 10.0, fastest = 0.0;  // [rad/s]
  for (const Vec3& axis : {Vec3{1.0, 0.0, 0.0}, Vec3{0.0, 1.0, 0.0}, Vec3{0.0, 0.0, 1.0}}) {
    standAt(bent);
    top_joint_rate = top_turn_rate = 0.0;
    ASSERT_EQ(twist({}, {2.0 * axis[0], 2.0 * axis[1], 2.0 * axis[2]}).reason, ServoRefusal::kNone);
    tick(60);
    EXPECT_LT(top_joint_rate, 2.0 * 1.002);
    slowest = std::min(slowest, top_turn_rate);
    fastest = std::max(fastest, top_joint_rate);
  }
  EXPECT_LT(slowest, 1.9) << "or no joint was slowed down";
  EXPECT_GT(fastest, 1.99) << "no slower than necessary";
  // a servo_cp of the same kind gets there, later
  standAt(bent);
  top_joint_rate = 0.0;
  const Pose to = bentOtherwise(0.35);
  ASSERT_EQ(pose(ServoKind::kServoPose, to).reason, ServoRefusal::kNone);
  tick(600);
  EXPECT_LT((target.pose().p - to.p).norm(), 1e-12);
  EXPECT_LT(turnBetween(target.pose().R, to.R), 1e-9);
  EXPECT_LT(top_joint_rate, 2.0 * 1.002);
}

TEST_P(ServoTargetTest, AMoveCpTakesTheTimeThatItsJointsNeed) {
  standAt(bent);
  const Pose to = bentOtherwise(0.6);
  const double turn = turnBetween(to.R, target.pose().R);
  ASSERT_LT(turn, 0.45);
  ASSERT_EQ(pose(ServoKind::kMovePose, to).reason, ServoRefusal::kNone);
  const double seconds = static_cast<double>(finish()) * kTickSeconds;
  EXPECT_LT((target.pose().p - to.p).norm(), 1e-12);
  EXPECT_LT(turnBetween(target.pose().R, to.R), 1e-9);
  EXPECT_LT(top_joint_rate, 0.5 * 1.002);
  EXPECT_GT(top_joint_rate, 0.49);
  EXPECT_LT(turn_rate, 1e-2) << "to rest";
  EXPECT_GT(seconds, 0.6 / 0.5) << "the time of roll at its highest rate";
  EXPECT_GT(seconds, 1.1 * 15.0 / 8 * turn / 0.5) << "or no joint was slowed down";
}

TEST_P(ServoTargetTest, MovesWaitForEachOtherAndTheNinthIsRefused) {
  const Vector3 from = target.pose().p;
  std::vector<Vector3> ends;
  for (int i = 0; i < 8; ++i) {
    ends.push_back(from + Vector3(0.002 * (i + 1), i % 2 == 0 ? 0.003 : 0.0, 0.0));
    ASSERT_EQ(pose(ServoKind::kMovePose, {target.pose().R, ends.back()}).reason, ServoRefusal::kNone);
  }
  EXPECT_EQ(pose(ServoKind::kMovePose, {target.pose().R, from}).reason, ServoRefusal::kQueueFull);
  EXPECT_LT((target.goal().p - ends.back()).norm(), 1e-12) << "the newest";
  std::size_t reached = 0;
  for (int i = 0; target.isMoving() && i < 100000; ++i) {
    tick();
    if (reached < ends.size() && (target.pose().p - ends[reached]).norm() < 1e-12) ++reached;
  }
  EXPECT_EQ(reached, 8U);
  EXPECT_EQ(pose(ServoKind::kMovePose, {target.pose().R, from}).reason, ServoRefusal::kNone);
}

TEST_P(ServoTargetTest, AServoCommandEndsMovesAndHoldEndsAll) {
  ASSERT_EQ(pose(ServoKind::kMovePose, shifted({0.03, 0.0, 0.0})).reason, ServoRefusal::kNone);
  ASSERT_EQ(pose(ServoKind::kMovePose, shifted({0.0, 0.0, 0.0})).reason, ServoRefusal::kNone);
  tick(400);
  const Pose here = shifted({0.0, 0.002, 0.0});
  ASSERT_EQ(pose(ServoKind::kServoPose, here).reason, ServoRefusal::kNone);
  EXPECT_FALSE(target.isMoving());
  tick(100);
  EXPECT_LT((target.pose().p - here.p).norm(), 1e-12);
  ASSERT_EQ(pose(ServoKind::kMovePose, shifted({0.03, 0.0, 0.0})).reason, ServoRefusal::kNone);
  ASSERT_EQ(jaw(ServoKind::kMoveJaw, 0.2).reason, ServoRefusal::kNone);
  tick(300);
  ASSERT_EQ(target.take(command(ServoKind::kHold)).reason, ServoRefusal::kNone);
  const Vector3 held = target.pose().p;
  const double opening = target.opening();
  tick(500);
  EXPECT_EQ(target.pose().p, held);
  EXPECT_EQ(target.opening(), opening);
  EXPECT_FALSE(target.isMoving());
}

TEST_P(ServoTargetTest, GoalsWithWhichADvrkClosesItsJawsCloseOurs) {
  for (const double goal : {-20.0 * kDegree, -0.6, -60.0 * kDegree}) {
    for (const ServoKind kind : {ServoKind::kMoveJaw, ServoKind::kServoJaw}) {
      ASSERT_EQ(jaw(ServoKind::kMoveJaw, 0.5).reason, ServoRefusal::kNone);
      finish();
      ASSERT_EQ(jaw(kind, goal).reason, ServoRefusal::kNone) << goal;
      EXPECT_EQ(target.isMoving(), kind == ServoKind::kMoveJaw);
      tick(3000);
      EXPECT_EQ(target.opening(), kMinOpening) << goal;
    }
  }
}

TEST_P(ServoTargetTest, ATwistLastsForItsTime) {
  const Pose from = target.pose();
  ASSERT_EQ(twist({0.02, 0.0, -0.01}, {0.0, 0.0, 0.4}).reason, ServoRefusal::kNone);
  tick(60);
  ASSERT_EQ(twist({0.02, 0.0, -0.01}, {0.0, 0.0, 0.4}).reason, ServoRefusal::kNone);
  tick(100);
  EXPECT_LT((target.pose().p - from.p - 0.16 * Vector3(0.02, 0.0, -0.01)).norm(), 1e-9) << "60 + 100 ms";
  EXPECT_EQ(target.runOut(), 0U);
  tick(1);
  EXPECT_EQ(target.runOut(), 1U);
  tick(400);
  const double seconds = 0.16 + 0.1;  // and half of the 200 ms in which it slows down
  EXPECT_LT((target.pose().p - from.p - seconds * Vector3(0.02, 0.0, -0.01)).norm(), 2e-5);
  EXPECT_NEAR(turnBetween(target.pose().R, from.R), seconds * 0.4, 4e-4);
  EXPECT_EQ(speed, 0.0);
  EXPECT_EQ(target.runOut(), 1U);
}

TEST_P(ServoTargetTest, ATwistOfTheBranchsClientsEndsWhenTheySendNoMore) {
  for (const CrtkDialect dialect : {CrtkDialect::kModern, CrtkDialect::kRaven}) {
    CrtkConfig own = limits();
    own.twist_timeout = 15.0;
    own.dialect = dialect;
    target = ServoTarget(own, geometry, arm);
    standAt(q);
    const Pose from = target.pose();
    ASSERT_EQ(twist({0.01, 0.0, 0.0}, {}).reason, ServoRefusal::kNone);
    tick(1000);
    const double seconds = dialect == CrtkDialect::kRaven ? 0.1 + 0.1 : 1.0;  // and half of the 200 ms to slow down
    EXPECT_NEAR((target.pose().p - from.p)[0], seconds * 0.01, 2e-5);
  }
}

TEST_P(ServoTargetTest, ATwistThatTimedOutComesToRestGently) {
  ASSERT_EQ(twist({0.02, 0.0, 0.0}, {}).reason, ServoRefusal::kNone);
  tick(100);
  double last = 0.02, brake = 0.0;
  for (int i = 0; i < 300; ++i) {
    const Vector3 before = target.pose().p;
    tick(1);
    const double now = (target.pose().p - before).norm() / kTickSeconds;
    EXPECT_LE(now, last + 1e-9) << i;
    brake = std::max(brake, (last - now) / kTickSeconds);
    last = now;
  }
  EXPECT_LT(brake, 0.11) << "[m/s2] 20 mm/s in 200 ms";
  EXPECT_EQ(last, 0.0);
}

TEST_P(ServoTargetTest, ATwistOfNothingEndsOneAndNeverTimesOut) {
  ASSERT_EQ(twist({0.02, 0.0, 0.0}, {}).reason, ServoRefusal::kNone);
  tick(50);
  ASSERT_EQ(twist({}, {}).reason, ServoRefusal::kNone);
  const Vector3 there = target.pose().p;
  tick(500);
  EXPECT_EQ(target.pose().p, there);
  EXPECT_EQ(target.runOut(), 0U);
}

TEST_P(ServoTargetTest, RatesOfNothingEndOthersAndNeverTimeOut) {
  ASSERT_EQ(joints(ServoKind::kServoRates, {0.1, 0.0, 0.0, 0.0, 0.0, 0.0}).reason, ServoRefusal::kNone);
  tick(50);
  ASSERT_EQ(joints(ServoKind::kServoRates, {}).reason, ServoRefusal::kNone);
  const ServoJoints there = servoJoints(target.joints());
  tick(500);
  for (std::size_t j = 0; j < there.size(); ++j)
    EXPECT_NEAR(servoJoints(target.joints())[j], there[j], 1e-12) << j;
  EXPECT_EQ(target.runOut(), 0U);
}

TEST_P(ServoTargetTest, ATwistOfWhoIsGoneSlowsDownButNothingElseDoes) {
  ASSERT_EQ(twist({0.02, 0.0, 0.0}, {}).reason, ServoRefusal::kNone);
  tick(10);
  ASSERT_EQ(target.take(command(ServoKind::kEndTwist)).reason, ServoRefusal::kNone);
  const Vector3 from = target.pose().p;
  tick(400);
  EXPECT_NEAR((target.pose().p - from).norm(), 0.02 * 0.1, 3e-5);
  EXPECT_EQ(target.runOut(), 0U);
  const ServoJoints goal = sum(servoJoints(q), {0.1, 0, 0, 0, 0, 0});
  ASSERT_EQ(joints(ServoKind::kMoveJoints, goal).reason, ServoRefusal::kNone);
  ASSERT_EQ(target.take(command(ServoKind::kEndTwist)).reason, ServoRefusal::kNone);
  finish();
  EXPECT_NEAR(servoJoints(q)[0], goal[0], 1e-4);
}

TEST_P(ServoTargetTest, AMoveByCountsFromWhereAServoCommandLeads) {
  const ServoJoints from = servoJoints(q);
  const ServoJoints by{0.02, 0.0, 0.005, 0.0, 0.0, 0.0};
  ASSERT_EQ(joints(ServoKind::kServoJointsBy, by).reason, ServoRefusal::kNone);
  tick(5);
  ASSERT_LT(servoJoints(q)[kInsertion], from[kInsertion] + 0.001) << "the servo command is still under way";
  ASSERT_EQ(joints(ServoKind::kMoveJointsBy, by).reason, ServoRefusal::kNone);
  finish();
  EXPECT_NEAR(servoJoints(q)[kShoulder], from[kShoulder] + 0.04, 1e-6);
  EXPECT_NEAR(servoJoints(q)[kInsertion], from[kInsertion] + 0.01, 1e-6);
}

TEST_P(ServoTargetTest, RatesOfAClientThatIsGoneSlowDownToo) {
  ASSERT_EQ(joints(ServoKind::kServoRates, {0.1, 0.0, 0.0, 0.0, 0.0, 0.0}).reason, ServoRefusal::kNone);
  tick(10);
  const double from = servoJoints(q)[0];
  ASSERT_EQ(target.take(command(ServoKind::kEndRates)).reason, ServoRefusal::kNone);
  tick(400);
  EXPECT_NEAR(servoJoints(q)[0] - from, 0.1 * 0.1, 1e-4) << "half of 0.1 rad/s for 0.2 s";
  EXPECT_EQ(target.runOut(), 0U);
}

TEST_P(ServoTargetTest, AClientOfAnotherTopicThatIsGoneEndsNothing) {
  ASSERT_EQ(twist({0.01, 0.0, 0.0}, {}).reason, ServoRefusal::kNone);
  ASSERT_EQ(target.take(command(ServoKind::kEndRates)).reason, ServoRefusal::kNone);
  tick(10);
  const Vector3 from = target.pose().p;
  tick(80);
  EXPECT_NEAR((target.pose().p - from).norm(), 0.01 * 0.08, 1e-6);
  ASSERT_EQ(joints(ServoKind::kServoRates, {0.1, 0.0, 0.0, 0.0, 0.0, 0.0}).reason, ServoRefusal::kNone);
  ASSERT_EQ(target.take(command(ServoKind::kEndTwist)).reason, ServoRefusal::kNone);
  tick(10);
  const double shoulder = servoJoints(q)[0];
  tick(80);
  EXPECT_NEAR(servoJoints(q)[0] - shoulder, 0.1 * 0.08, 1e-6);
}

TEST_P(ServoTargetTest, RatesMoveEachJointForTheirTime) {
  const ServoJoints rates{0.1, -0.2, 0.01, 0.3, -0.1, 0.2}, from = servoJoints(q);
  ASSERT_EQ(joints(ServoKind::kServoRates, rates).reason, ServoRefusal::kNone);
  tick(50);
  for (std::size_t j = 0; j < kServoJointCount; ++j)
    EXPECT_NEAR(servoJoints(target.joints())[j] - from[j], 0.05 * rates[j], 1e-9) << j;
  tick(500);
  EXPECT_EQ(target.runOut(), 1U);
  for (std::size_t j = 0; j < kServoJointCount; ++j)
    EXPECT_NEAR(servoJoints(target.joints())[j] - from[j], 0.2 * rates[j], 2e-3) << j;
  ServoJoints fast{};
  fast[kInsertion] = 0.11;
  const ServoVerdict verdict = joints(ServoKind::kServoRates, fast);
  EXPECT_EQ(verdict.reason, ServoRefusal::kTooFast);
  EXPECT_EQ(verdict.joint, kInsertion);
  EXPECT_EQ(verdict.limit, 0.1);
  fast = {};
  fast[4] = -2.1;
  EXPECT_EQ(joints(ServoKind::kServoRates, fast).reason, ServoRefusal::kTooFast);
  fast[4] = kNan;
  EXPECT_EQ(joints(ServoKind::kServoRates, fast).reason, ServoRefusal::kNotFinite);
}

TEST_P(ServoTargetTest, RatesEndAtAJointsLimit) {
  JointArray edge = q;
  edge[kInsertion] = 0.545;
  standAt(edge);
  ServoJoints down{};
  down[kInsertion] = 0.1;
  for (int i = 0; i < 4; ++i) {
    ASSERT_EQ(joints(ServoKind::kServoRates, down).reason, ServoRefusal::kNone);
    tick(90);
  }
  EXPECT_LE(target.joints()[kInsertion], 0.56);
  EXPECT_GT(target.joints()[kInsertion], 0.5595);
}

TEST_P(ServoTargetTest, MovesByCountFromWhereTheNewestLeads) {
  const ServoJoints from = servoJoints(q), by{0.05, -0.05, 0.005, 0.1, 0.05, 0.0};
  ASSERT_EQ(joints(ServoKind::kMoveJointsBy, by).reason, ServoRefusal::kNone);
  ASSERT_EQ(joints(ServoKind::kMoveJointsBy, by).reason, ServoRefusal::kNone);
  EXPECT_TRUE(target.isMoving());
  finish();
  for (std::size_t j = 0; j < kServoJointCount; ++j)
    EXPECT_NEAR(servoJoints(q)[j], from[j] + 2 * by[j], 2e-4) << j;
  ServoJoints far{};
  far[kInsertion] = 1.0;
  EXPECT_EQ(joints(ServoKind::kMoveJointsBy, far).reason, ServoRefusal::kOutOfRange);
  ASSERT_EQ(jaw(ServoKind::kMoveJaw, 0.5).reason, ServoRefusal::kNone);
  ASSERT_EQ(jaw(ServoKind::kMoveJawBy, 0.2).reason, ServoRefusal::kNone);
  finish();
  EXPECT_NEAR(target.opening(), 0.7, 1e-3);
}

TEST_P(ServoTargetTest, OneNumberMovesTheShoulderAlone) {
  const ServoJoints from = servoJoints(q);
  ServoCommand c = command(ServoKind::kServoJoints);
  c.is_shoulder = 1;
  c.joints[0] = from[0] + 0.05;
  ASSERT_EQ(target.take(c).reason, ServoRefusal::kNone);
  tick(200);
  EXPECT_NEAR(servoJoints(q)[0], from[0] + 0.05, 1e-4);
  for (std::size_t j = 1; j < kServoJointCount; ++j)
    EXPECT_NEAR(servoJoints(q)[j], from[j], 1e-4) << j;
}

TEST_P(ServoTargetTest, ARatioSlowsMovesDown) {
  const auto secondsFor = [this](double ratio) {
    ServoCommand c = command(ServoKind::kRatio);
    c.number = ratio;
    EXPECT_EQ(target.take(c).reason, ServoRefusal::kNone);
    EXPECT_EQ(target.ratio(), ratio);
    ServoJoints by{};
    by[0] = q[0] > 0.6 ? -0.1 : 0.1;
    EXPECT_EQ(joints(ServoKind::kMoveJointsBy, by).reason, ServoRefusal::kNone);
    return finish();
  };
  const int whole = secondsFor(1.0), half = secondsFor(0.5);
  EXPECT_NEAR(half, 2 * whole, 4);
  for (const double wrong : {0.0, -1.0, 1.5}) {
    ServoCommand c = command(ServoKind::kRatio);
    c.number = wrong;
    EXPECT_EQ(target.take(c).reason, ServoRefusal::kNoRatio) << wrong;
  }
  EXPECT_EQ(target.ratio(), 0.5);
}

TEST_P(ServoTargetTest, TheJointsOfAStraightMoveKeepToTheRatioWithWhichItBegan) {
  ServoCommand ratio = command(ServoKind::kRatio);
  standAt(bent);
  ratio.number = 0.5;
  ASSERT_EQ(target.take(ratio).reason, ServoRefusal::kNone);
  ASSERT_EQ(pose(ServoKind::kMovePose, bentOtherwise(0.6)).reason, ServoRefusal::kNone);
  ratio.number = 1.0;  // of the next move
  ASSERT_EQ(target.take(ratio).reason, ServoRefusal::kNone);
  finish();
  EXPECT_LT(top_joint_rate, 0.25 * 1.002);
  EXPECT_GT(top_joint_rate, 0.245) << "or no joint was slowed down";
}

TEST_P(ServoTargetTest, ARatioSlowsTheJawsDownToo) {
  ServoCommand ratio = command(ServoKind::kRatio);
  ratio.number = 0.5;
  ASSERT_EQ(target.take(ratio).reason, ServoRefusal::kNone);
  for (const double by : {-0.4, 0.4}) {
    ASSERT_EQ(jaw(ServoKind::kMoveJawBy, by).reason, ServoRefusal::kNone);
    EXPECT_NEAR(finish(), 3000, 1) << "15/8 x 0.4 rad / 0.25 rad/s";
  }
}

TEST_P(ServoTargetTest, AMoveOfTheJawsByCountsFromWhereAServoCommandLeads) {
  for (const double by : {-0.1, 0.1}) {
    ASSERT_EQ(jaw(ServoKind::kServoJaw, 0.5).reason, ServoRefusal::kNone);
    tick(5);
    ASSERT_GT(std::abs(target.opening() - 0.5), 0.05) << "the servo command is still under way";
    ASSERT_EQ(jaw(ServoKind::kMoveJawBy, by).reason, ServoRefusal::kNone);
    finish();
    EXPECT_NEAR(target.opening(), 0.5 + by, 1e-12);
  }
}

TEST_P(ServoTargetTest, OneNumberLeavesTheOtherJointsTheGoalsThatTheyHad) {
  for (const double sign : {-1.0, 1.0}) {
    standAt({0.6, 1.4, 0.35, 0.3, 0.2, 0.5, 0.9});
    const ServoJoints to = sum(servoJoints(q), {0.0, 0.05 * sign, 0.005 * sign, 0.1, 0.0, 0.0});
    ASSERT_EQ(joints(ServoKind::kServoJoints, to).reason, ServoRefusal::kNone);
    tick(5);
    ServoCommand shoulder = command(ServoKind::kServoJoints);
    shoulder.is_shoulder = 1;
    shoulder.joints[0] = to[0] + 0.05 * sign;
    ASSERT_EQ(target.take(shoulder).reason, ServoRefusal::kNone);
    tick(500);
    EXPECT_NEAR(servoJoints(q)[0], shoulder.joints[0], 1e-6) << sign;
    for (std::size_t j = 1; j < kServoJointCount; ++j)
      EXPECT_NEAR(servoJoints(q)[j], to[j], 1e-6) << j << " " << sign;
  }
}

TEST_P(ServoTargetTest, ATwistThatIsTooFastIsRefused) {
  const ServoVerdict fast = twist({0.08, 0.08, 0.0}, {});
  EXPECT_EQ(fast.reason, ServoRefusal::kTooFast);
  EXPECT_EQ(fast.is_turn, 0);
  EXPECT_NEAR(fast.value, 0.08 * std::sqrt(2.0), 1e-12);
  const ServoVerdict spin = twist({}, {0.0, -2.1, 0.0});
  EXPECT_EQ(spin.reason, ServoRefusal::kTooFast);
  EXPECT_EQ(spin.is_turn, 1);
  EXPECT_EQ(spin.limit, 2.0);
}

TEST_P(ServoTargetTest, ATwistEndsWhereTheArmDoes) {
  JointArray edge = q;
  edge[kInsertion] = 0.55452;
  standAt(edge);
  JointArray on = edge;
  on[kInsertion] += 1e-3;
  const Vector3 way = (poseOf(on).p - poseOf(edge).p).normalized() * 0.05;  // down the shaft
  for (int i = 0; i < 5; ++i) {
    ASSERT_EQ(twist(toArray(way), {}).reason, ServoRefusal::kNone);
    tick(50);
  }
  EXPECT_LT(q[kInsertion], 0.56);
  EXPECT_GT(q[kInsertion], 0.5599) << "5.5 mm further, 12.5 commanded";
}

TEST_P(ServoTargetTest, WhatTheMappingDidNotTakeIsNotGoneOnFrom) {
  const Pose from = target.pose();
  ASSERT_EQ(pose(ServoKind::kServoPose, shifted({0.015, 0.0, 0.0})).reason, ServoRefusal::kNone);
  for (int i = 0; i < 100; ++i) {
    target.keepTo(from, q, target.opening());  // it stays where it was
    target.step();
    ASSERT_LT((target.pose().p - from.p).norm(), 3.1e-4);
  }
  tick(200);
  EXPECT_LT((target.pose().p - from.p - Vector3(0.015, 0.0, 0.0)).norm(), 1e-9) << "once the mapping accepts it";
}

TEST_P(ServoTargetTest, RoundingOfTheMappingDoesNotStopASlowMotion) {
  const Pose from = target.pose();
  for (int tenth = 0; tenth < 10; ++tenth) {
    ASSERT_EQ(twist({1e-4, 0.0, 0.0}, {}).reason, ServoRefusal::kNone);  // 0.1 um a tick
    for (int i = 0; i < 100; ++i) {
      Pose rounded = target.pose();
      rounded.p = (rounded.p * 1e6).unaryExpr([](double um) { return std::round(um); }) * 1e-6;
      target.keepTo(rounded, q, target.opening());
      target.step();
    }
  }
  EXPECT_NEAR(target.pose().p.x() - from.p.x(), 1e-4, 2e-6);
}

TEST_P(ServoTargetTest, AMoveThatWasHeldUpGoesOnFromRest) {
  const Pose to = shifted({0.03, 0.0, 0.0});
  ASSERT_EQ(pose(ServoKind::kMovePose, to).reason, ServoRefusal::kNone);
  tick(700);
  EXPECT_GT(speed, 0.03);
  const Pose stuck = shifted({-0.001, 0.0, 0.0});
  target.keepTo(stuck, q, target.opening());
  target.step();
  EXPECT_LT((target.pose().p - stuck.p).norm(), 1e-6) << "it does not leap";
  finish();
  EXPECT_LT((target.pose().p - to.p).norm(), 1e-12);
  EXPECT_LT(top_speed, 0.0401);
}

TEST_P(ServoTargetTest, TheJawsGoAtTheirOwnRate) {
  const double from = target.opening();  // 1.4
  ASSERT_EQ(jaw(ServoKind::kServoJaw, 0.2).reason, ServoRefusal::kNone) << "any opening within their range";
  tick(100);
  EXPECT_NEAR(target.opening(), from - 0.2, 1e-9) << "2 rad/s";
  tick(600);
  EXPECT_NEAR(target.opening(), 0.2, 1e-12);
  ASSERT_EQ(jaw(ServoKind::kServoJawBy, 0.1).reason, ServoRefusal::kNone);
  ASSERT_EQ(jaw(ServoKind::kServoJawBy, 0.1).reason, ServoRefusal::kNone);
  tick(300);
  EXPECT_NEAR(target.opening(), 0.4, 1e-12);
  ASSERT_EQ(jaw(ServoKind::kMoveJaw, 0.8).reason, ServoRefusal::kNone);
  EXPECT_TRUE(target.isMoving());
  EXPECT_NEAR(finish(), 1500, 1) << "15/8 x 0.4 rad / 0.5 rad/s";
  EXPECT_NEAR(target.opening(), 0.8, 1e-12);
  EXPECT_EQ(top_speed, 0.0) << "the arm holds";
}

TEST_P(ServoTargetTest, TheJawsOpenAndCloseAtTheSameRateAndAServoCommandEndsTheirMove) {
  for (const double sign : {-1.0, 1.0}) {
    standAt({0.6, 1.4, 0.35, 0.3, 0.2, 0.3, 0.3});
    ASSERT_EQ(jaw(ServoKind::kMoveJaw, 0.6 - 0.5 * sign).reason, ServoRefusal::kNone);
    tick(50);
    const double from = target.opening();
    ASSERT_EQ(jaw(ServoKind::kServoJaw, 0.6 + 0.5 * sign).reason, ServoRefusal::kNone);
    EXPECT_FALSE(target.isMoving());
    tick(100);
    EXPECT_NEAR(target.opening(), from + 0.2 * sign, 1e-9) << "2 rad/s";
    target.take(command(ServoKind::kHold));
    tick(100);
    EXPECT_NEAR(target.opening(), from + 0.2 * sign, 1e-9) << "a hold ends that, too";
    ASSERT_EQ(jaw(ServoKind::kServoJawBy, 0.01 * sign).reason, ServoRefusal::kNone);
    tick(50);
    EXPECT_NEAR(target.opening(), from + 0.21 * sign, 1e-9) << "from where they are held";
  }
}

TEST_P(ServoTargetTest, WhatTheMappingDidNotTakeOfTurnOrJawsIsNotGoneOnFrom) {
  const Pose from = target.pose();
  const double opening = target.opening();
  ASSERT_EQ(pose(ServoKind::kServoPose, shifted({0.0, 0.0, 0.0}, 0.3)).reason, ServoRefusal::kNone);
  ASSERT_EQ(jaw(ServoKind::kServoJaw, opening - 0.5).reason, ServoRefusal::kNone);
  for (int i = 0; i < 100; ++i) {
    target.keepTo(from, q, opening);  // both stay where they were
    target.step();
    ASSERT_LT(turnBetween(target.pose().R, from.R), 3.1e-3) << i;
    ASSERT_LT(std::abs(target.opening() - opening), 0.0221) << i;
  }
  // a move of the jaws that met a limit is over
  ASSERT_EQ(jaw(ServoKind::kMoveJaw, opening - 1.0).reason, ServoRefusal::kNone);
  for (int i = 0; target.isMoving() && i < 2000; ++i) {
    target.keepTo(target.pose(), q, opening);
    target.step();
  }
  EXPECT_FALSE(target.isMoving());
  target.keepTo(target.pose(), q, opening);
  target.step();
  EXPECT_EQ(target.opening(), opening);
}

TEST_P(ServoTargetTest, MovesGoOnFromWhereTheArmWasTakenMeanwhileWithoutALeap) {
  ASSERT_EQ(pose(ServoKind::kMovePose, shifted({0.03, 0.0, 0.0})).reason, ServoRefusal::kNone);
  ASSERT_EQ(jaw(ServoKind::kMoveJaw, 0.2).reason, ServoRefusal::kNone);
  const Pose to = target.goal();
  tick(700);
  JointArray elsewhere = q;
  elsewhere[kInsertion] -= 0.01;
  kinematics::setJaws(kinematics::jawMidline(q), 0.6, &elsewhere);
  standAt(elsewhere);
  const Pose before = target.pose();
  tick();
  EXPECT_LT((target.pose().p - before.p).norm(), 1e-6);
  EXPECT_NEAR(target.opening(), 0.6, 1e-6);
  top_speed = 0.0;
  finish();
  EXPECT_LT((target.pose().p - to.p).norm(), 1e-12);
  EXPECT_NEAR(target.opening(), 0.2, 1e-12);
  EXPECT_LT(top_speed, 0.0401);
}

TEST_P(ServoTargetTest, BeginsWithAnOpeningThatTheJawsCanHave) {
  for (const auto& [opening, expected] : {std::pair{-0.5, -0.174}, {0.3, 0.3}, {2.0, 1.57}}) {
    JointArray joints = bent;
    kinematics::setJaws(0.1, opening, &joints);
    standAt(joints);
    EXPECT_NEAR(target.opening(), expected, 1e-12);
    target.keepTo(target.pose(), q, opening);
    EXPECT_NEAR(target.opening(), expected, 1e-12);
  }
}

TEST_P(ServoTargetTest, ATwistTurnsAboutItsAxisOfTheBaseTheRightWayRound) {
  for (int axis = 0; axis < 3; ++axis) {
    for (const double rate : {-0.4, 0.4}) {
      standAt({0.6, 1.4, 0.35, 0.3, 0.2, 0.5, 0.9});
      const Pose from = target.pose();
      Vec3 w{};
      w[static_cast<std::size_t>(axis)] = rate;
      ASSERT_EQ(twist({}, w).reason, ServoRefusal::kNone);
      tick(100);
      const Matrix3 turned = Eigen::AngleAxisd(0.1 * rate, Vector3::Unit(axis)) * from.R;  // 100 ms
      EXPECT_LT(turnBetween(target.pose().R, turned), 1e-7) << axis << " " << rate;
      EXPECT_LT((target.pose().p - from.p).norm(), 1e-9) << "the tip stays";
    }
  }
}

TEST_P(ServoTargetTest, EachJointIsRefusedBeyondEitherLimit) {
  const ServoJoints middle{0.8, 1.6, 0.35, 0.0, 0.0, 0.0};
  for (std::size_t j = 0; j < kServoJointCount; ++j) {
    const bool is_midline = j + 1 == kServoJointCount;
    for (const bool is_upper : {false, true}) {
      const double low = geometry.q_min[is_midline ? kGrasp1 : j], high = geometry.q_max[is_midline ? kGrasp2 : j];
      const double limit = is_upper ? high : low;
      ServoJoints to = middle;
      to[j] = limit + (is_upper ? 6e-5 : -6e-5);
      const ServoVerdict verdict = joints(ServoKind::kMoveJoints, to);
      EXPECT_EQ(verdict.reason, ServoRefusal::kOutOfRange) << j;
      EXPECT_EQ(verdict.joint, j);
      EXPECT_EQ(verdict.value, to[j]);
      EXPECT_EQ(verdict.limit, limit);
      EXPECT_EQ(verdict.is_turn, j == kInsertion ? 0 : 1);
    }
  }
}

/** An arm that has one joint at a limit, and the others in the middle. */
class AtALimit : public ServoTargetTest {
 protected:
  struct Limit {
    std::size_t joint{};
    double value{}, outwards{};  // [rad; m], sign
  };
  std::vector<Limit> all() const {
    std::vector<Limit> limits;
    for (std::size_t j = 0; j < kServoJointCount; ++j) {
      const bool is_midline = j + 1 == kServoJointCount;
      limits.push_back({j, geometry.q_min[is_midline ? kGrasp1 : j], -1.0});
      limits.push_back({j, geometry.q_max[is_midline ? kGrasp2 : j], 1.0});
    }
    return limits;
  }
  void stand(const Limit& limit, double beyond) {
    ServoJoints at = middle;
    at[limit.joint] = limit.value + limit.outwards * beyond;
    JointArray full{};
    kinematics::setJaws(0.0, 0.4, &full);
    target.hold();
    standAt(withServoJoints(full, at));
  }
  /** The robot holds the mid-line against its lower limit alone. */
  static bool isHeld(const Limit& limit) { return limit.joint + 1 < kServoJointCount || limit.outwards < 0.0; }
  /** A twist that moves this joint outwards, and no other. @param[in] rate [rad/s; m/s]. */
  ServoVerdict twistOutwards(const Limit& limit, double rate) {
    ServoJoints out = servoJoints(target.joints());
    out[limit.joint] += limit.outwards * 1e-4;
    const Pose to = poseOf(withServoJoints(target.joints(), out));
    const Eigen::AngleAxisd turn(Matrix3(to.R * target.pose().R.transpose()));
    return twist(toArray(Vector3((to.p - target.pose().p) * rate * 1e4)),
                 toArray(Vector3(turn.axis() * turn.angle() * rate * 1e4)));
  }

  const ServoJoints middle{0.8, 1.6, 0.35, 0.1, 0.3, 0.2};
};

/** A set point in whole micrometres is up to 12 urad or 0.7 um beyond a limit; ServoTrim keeps 50 off it. */
TEST_P(AtALimit, ASetPointHardlyBeyondItCanBeSentBackInEveryWay) {
  for (const Limit& limit : all()) {
    for (const double beyond : {0.0, 1.2e-5, 4.9e-5}) {
      const auto where = [&] { return ::testing::Message() << limit.joint << " " << limit.outwards << " " << beyond; };
      for (const ServoKind kind : {ServoKind::kServoJoints, ServoKind::kMoveJoints}) {
        stand(limit, beyond);
        EXPECT_EQ(joints(kind, servoJoints(target.joints())).reason, ServoRefusal::kNone) << where();
        EXPECT_LT(turnBetween(target.goal().R, target.pose().R), 6e-5) << where();
        tick(300);
        EXPECT_NEAR(servoJoints(target.joints())[limit.joint], limit.value, 1e-9) << where() << ": at the limit";
      }
      for (const ServoKind kind : {ServoKind::kServoPose, ServoKind::kMovePose}) {
        stand(limit, beyond);
        EXPECT_EQ(pose(kind, target.pose()).reason, ServoRefusal::kNone) << where();
        tick(300);
        EXPECT_EQ(target.ended(), 0U) << where();
        if (isHeld(limit)) EXPECT_NEAR(servoJoints(q)[limit.joint], limit.value, 1e-9) << where() << ": at the limit";
      }
    }
  }
}

TEST_P(AtALimit, AnotherJointCanBeMoved) {
  for (const Limit& limit : all()) {
    const std::size_t other = limit.joint == kShoulder ? kElbow : kShoulder;
    ServoJoints by{};
    by[other] = 0.02;
    for (const ServoKind kind : {ServoKind::kServoJointsBy, ServoKind::kMoveJointsBy, ServoKind::kServoRates}) {
      stand(limit, 1.2e-5);
      EXPECT_EQ(joints(kind, by).reason, ServoRefusal::kNone) << limit.joint << limit.outwards;
      tick(250);
      const double way = kind == ServoKind::kServoRates ? 0.02 * 0.2 : 0.02;
      EXPECT_NEAR(servoJoints(q)[other] - middle[other], way, 1e-3) << limit.joint << limit.outwards;
    }
    if (limit.joint == kShoulder) continue;
    stand(limit, 1.2e-5);
    ServoCommand shoulder = command(ServoKind::kServoJoints);
    shoulder.is_shoulder = 1;
    shoulder.joints[0] = middle[0] + 0.02;
    EXPECT_EQ(target.take(shoulder).reason, ServoRefusal::kNone) << limit.joint << limit.outwards;
  }
}

TEST_P(AtALimit, FartherBeyondItOrOutwardsThereIsNoMotion) {
  for (const Limit& limit : all()) {
    stand(limit, 0.0);
    ServoJoints to = servoJoints(target.joints());
    to[limit.joint] += limit.outwards * 6e-5;
    EXPECT_EQ(joints(ServoKind::kServoJoints, to).reason, ServoRefusal::kOutOfRange) << limit.joint << limit.outwards;
    if (isHeld(limit)) {
      const Pose outside = poseOf(withServoJoints(target.joints(), to));
      EXPECT_EQ(pose(ServoKind::kServoPose, outside).reason, ServoRefusal::kUnreachable)
          << limit.joint << limit.outwards;
    }
    for (const double beyond : {0.0, 1.2e-5}) {  // then 10 urad or 10 um a tick
      stand(limit, beyond);
      ServoJoints rates{};
      rates[limit.joint] = limit.outwards * 0.01;
      const std::uint32_t ended = target.ended();
      ASSERT_EQ(joints(ServoKind::kServoRates, rates).reason, ServoRefusal::kNone);
      tick(5);
      EXPECT_EQ(target.ended(), ended + 1) << limit.joint << limit.outwards;
      if (!isHeld(limit)) continue;
      ASSERT_EQ(twistOutwards(limit, 0.01).reason, ServoRefusal::kNone);
      tick(5);
      EXPECT_EQ(target.ended(), ended + 2) << limit.joint << limit.outwards;
    }
  }
}

TEST_P(AtALimit, OfTheJawsRoundingIsNoReasonToRefuse) {
  for (const ServoKind kind : {ServoKind::kServoJaw, ServoKind::kMoveJaw}) {
    for (const auto& [limit, outwards] : {std::pair{kMinOpening, -1.0}, {kMaxOpening, 1.0}}) {
      EXPECT_EQ(jaw(kind, limit + outwards * 1e-15).reason, ServoRefusal::kNone) << limit;
      for (int i = 0; i < 8000; ++i)
        target.step();
      EXPECT_EQ(target.opening(), limit);
      const bool is_squeeze = outwards < 0.0;  // below closed it closes
      EXPECT_EQ(jaw(kind, limit + outwards * 6e-5).reason,
                is_squeeze ? ServoRefusal::kNone : ServoRefusal::kOutOfRange);
    }
  }
}

/** Between two poses that are looked at the straight path may leave the joints' limits. */
class EndsEarly : public AtALimit {
 protected:
  /** A pose, relative to the arm at this limit. The straight line to it has joints at its samples, but not in between.
   *  Found by trying turns and distances along and about each axis. */
  struct Way {
    std::size_t joint;
    double outwards, turn, metres;
    int axis;
  };
  static constexpr Way kWays[] = {{0, -1.0, -0.15, -0.0099, 8}, {0, 1.0, 0.19, -0.0099, 7},
                                  {1, -1.0, -0.19, 0.0099, 1},  {3, -1.0, -0.19, 0.0099, 8},
                                  {3, 1.0, -0.19, -0.006, 8},   {4, -1.0, -0.19, -0.0099, 5},
                                  {4, 1.0, -0.19, 0.0099, 3}};
  /** @return false: no way is known from this limit, or it does not do it with this arm. */
  bool findGoal(const Limit& limit, Pose* goal) {
    for (const Way& way : kWays) {
      if (way.joint != limit.joint || way.outwards != limit.outwards) continue;
      const Vector3 p = way.metres * Vector3::Unit(way.axis % 3), w = Vector3::Unit(way.axis / 3);
      *goal = {Eigen::AngleAxisd(way.turn, w) * target.pose().R, target.pose().p + p};
      return meetsALimit(*goal);
    }
    return false;
  }
  bool meetsALimit(const Pose& goal) {
    ServoTarget trial = target;
    ServoCommand c = command(ServoKind::kMovePose);
    c.pose_B = toArray(goal);
    if (trial.take(c).reason != ServoRefusal::kNone) return false;
    const std::uint32_t ended = trial.ended();
    for (int i = 0; i < 5000 && trial.isMoving(); ++i)
      trial.step();
    return trial.ended() > ended;
  }
};

TEST_P(EndsEarly, AMoveThatMeetsALimitIsCountedAsBegunAndAsEnded) {
  int found = 0;
  for (const Limit& limit : all()) {
    stand(limit, 0.0);
    Pose goal;
    if (!findGoal(limit, &goal)) continue;
    ++found;
    const std::uint32_t ended = target.ended(), moves = target.moves();
    ASSERT_EQ(pose(ServoKind::kMovePose, goal).reason, ServoRefusal::kNone);
    EXPECT_EQ(target.moves(), moves + 1) << "its client waits until the arm is busy";
    for (int i = 0; i < 5000 && target.isMoving(); ++i)
      target.step();
    EXPECT_FALSE(target.isMoving());
    EXPECT_EQ(target.ended(), ended + 1);
  }
  EXPECT_GE(found, 3);
}

TEST_P(EndsEarly, ATwistIntoALimitIsCountedButNotItsTimeOut) {
  for (const Limit& limit : all()) {
    if (!isHeld(limit)) continue;
    stand(limit, -1e-3);
    const std::uint32_t ended = target.ended();
    ASSERT_EQ(twistOutwards(limit, 0.04).reason, ServoRefusal::kNone);
    tick(400);
    EXPECT_EQ(target.ended(), ended + 1) << limit.joint << limit.outwards;
    EXPECT_EQ(target.moves(), 0u) << "a servo command is no move";
  }
  standAt({0.6, 1.4, 0.35, 0.3, 0.2, 0.5, 0.9});
  const std::uint32_t ended = target.ended();
  ASSERT_EQ(twist({0.01, 0.0, 0.0}, {}).reason, ServoRefusal::kNone);
  tick(400);
  ASSERT_EQ(joints(ServoKind::kServoRates, {0.01, 0.0, 0.0, 0.0, 0.0, 0.0}).reason, ServoRefusal::kNone);
  tick(400);
  ASSERT_EQ(pose(ServoKind::kMovePose, shifted({0.01, 0.0, 0.0})).reason, ServoRefusal::kNone);
  finish();
  EXPECT_EQ(target.ended(), ended);
}

TEST_P(EndsEarly, AHoldEndsAMoveAtOnce) {
  ASSERT_EQ(pose(ServoKind::kMovePose, shifted({0.01, 0.0, 0.0})).reason, ServoRefusal::kNone);
  tick(3);
  EXPECT_TRUE(target.isMoving());
  target.hold();
  EXPECT_FALSE(target.isMoving());
}

TEST_P(ServoTargetTest, AQuaternionOfAnotherLengthIsNoRotationWhetherLongerOrShorter) {
  ServoCommand c = command(ServoKind::kServoPose);
  for (const double norm : {0.97, 0.981, 1.019, 1.03, 2.0}) {
    c.pose_B = toArray(target.pose());
    for (double& x : c.pose_B.q)
      x *= -norm;  // the negative is the same rotation
    const bool is_unit = std::abs(norm - 1.0) <= 0.02;
    EXPECT_EQ(target.take(c).reason, is_unit ? ServoRefusal::kNone : ServoRefusal::kNotFinite) << norm;
  }
  tick(100);
  EXPECT_LT(turnBetween(target.pose().R, poseOf(q).R), 1e-9);
}

TEST_P(ServoTargetTest, TheShortestMoveTakesAFifthOfASecond) {
  // 10/sqrt(3) x 1 mm / (0.2 s)^2 = 0.144 m/s2
  for (const double millimetres : {0.01, 1.0}) {
    ASSERT_EQ(pose(ServoKind::kMovePose, shifted({1e-3 * millimetres, 0.0, 0.0})).reason, ServoRefusal::kNone);
    EXPECT_EQ(finish(), 200) << millimetres;
  }
  ASSERT_EQ(jaw(ServoKind::kMoveJaw, target.opening() - 0.001).reason, ServoRefusal::kNone);
  EXPECT_EQ(finish(), 200);
}

TEST_P(ServoTargetTest, AMoveOfTheRollTakesTheTimeOfItsAngleEitherWayUpToARevolution) {
  // up to 170 degrees the tip rotates by the angle of the roll
  for (const double roll : {-170.0, -130.0, 130.0, 170.0}) {
    standAt({0.6, 1.4, 0.35, -0.5 * roll * kDegree, 0.0, 0.5, 0.9});
    ServoJoints to = servoJoints(q);
    to[kToolRotation] += roll * kDegree;
    ASSERT_EQ(joints(ServoKind::kMoveJoints, to).reason, ServoRefusal::kNone);
    EXPECT_NEAR(finish(), 1000.0 * 15.0 / 8.0 * std::abs(roll) * kDegree / 0.5, 2.0) << roll;
  }
}

INSTANTIATE_TEST_SUITE_P(Arms, AtALimit, ::testing::ValuesIn(kArms), [](const auto& arm) {
  return std::string(name(arm.param));
});
INSTANTIATE_TEST_SUITE_P(Arms, EndsEarly, ::testing::ValuesIn(kArms), [](const auto& arm) {
  return std::string(name(arm.param));
});
TEST_P(ServoTargetTest, WhoLeavesWhileItsTwistRunsOutDoesNotSpeedItUp) {
  ASSERT_EQ(twist({0.02, 0.0, 0.0}, {}).reason, ServoRefusal::kNone);
  tick(200);  // half of the deceleration
  const Vector3 before = target.pose().p;
  tick();
  const double step = (target.pose().p - before).norm();
  ASSERT_EQ(target.take(command(ServoKind::kEndTwist)).reason, ServoRefusal::kNone);
  const Vector3 after = target.pose().p;
  tick();
  EXPECT_LE((target.pose().p - after).norm(), step + 1e-9);
}

INSTANTIATE_TEST_SUITE_P(Arms, ServoTargetTest, ::testing::ValuesIn(kArms), [](const auto& arm) {
  return std::string(name(arm.param));
});

}  // namespace
}  // namespace raven2_trainer::control
