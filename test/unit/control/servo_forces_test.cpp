#include "raven2_trainer/control/servo_forces.h"

#include <gtest/gtest.h>

#include "raven2_trainer/control/servo_target.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"

namespace raven2_trainer::control {
namespace {

const JointArray kBent{0.6, 1.4, 0.35, 0.3, 0.9, 0.5, 0.9};

ArmGeometry geometryOfTheRaven() {
  ArmGeometry g;
  g.d4 = -0.47;
  g.lw = 0.013;
  return g;
}

/** Motion of the tool by one of its joints, per unit of that joint, in B. */
struct Motion {
  Vector3 v, w;
};

Motion motionBy(Arm arm, std::size_t joint) {
  constexpr double kStep = 1e-6;
  const auto poseAt = [&](double step) {
    ServoJoints joints = servoJoints(kBent);
    joints[joint] += step;
    return kinematics::forward(geometryOfTheRaven(), arm, withServoJoints(kBent, joints));
  };
  const Pose before = poseAt(-kStep), after = poseAt(kStep);
  const Eigen::AngleAxisd turn(Matrix3(after.R * before.R.transpose()));
  return {(after.p - before.p) / (2.0 * kStep), turn.angle() * turn.axis() / (2.0 * kStep)};
}

TEST(ServoForces, DoTheWorkOfTheirWrenchInEachOfItsFrames) {
  const Vector3 force(3.0, -2.0, 1.0), torque(0.05, 0.1, -0.15);
  for (const Arm arm : kArms) {
    const Pose X_BT = kinematics::forward(geometryOfTheRaven(), arm, kBent);
    for (const EffortKind kind : {EffortKind::kTip, EffortKind::kBody, EffortKind::kOrigin}) {
      Effort effort;
      effort.kind = kind;
      effort.numbers = {force[0], force[1], force[2], torque[0], torque[1], torque[2]};
      const ServoJoints forces = servoForces(geometryOfTheRaven(), arm, kBent, effort);
      const Matrix3 R = kind == EffortKind::kBody ? X_BT.R : Matrix3::Identity();
      for (std::size_t j = 0; j < kServoJointCount; ++j) {
        const Motion motion = motionBy(arm, j);
        const Vector3 of_origin = motion.v - motion.w.cross(X_BT.p);  // the tool's point at the origin of B
        const Vector3 v = kind == EffortKind::kOrigin ? of_origin : motion.v;
        EXPECT_NEAR(forces[j], (R * force).dot(v) + (R * torque).dot(motion.w), 1e-6)
            << name(arm) << ", kind " << static_cast<int>(kind) << ", joint " << j;
      }
    }
  }
}

TEST(ServoForces, OfJointsAndJawsAreThoseOfTheGraspersAndBack) {
  const JointArray tau{1.0, -2.0, 3.0, 0.4, -0.5, 0.06, 0.1};
  EXPECT_NEAR(servoForces(tau).back(), 0.04, 1e-12) << "grasper 2 goes as grasper 1 comes";
  EXPECT_NEAR(jawForce(tau), 0.08, 1e-12);
  const JointArray back = jointForces(servoForces(tau), jawForce(tau));
  for (std::size_t j = 0; j < kJointCount; ++j)
    EXPECT_NEAR(back[j], tau[j], 1e-12) << kJointNames[j];
}

}  // namespace
}  // namespace raven2_trainer::control
