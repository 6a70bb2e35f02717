#include "raven2_trainer/control/servo_forces.h"

#include <algorithm>

#include "raven2_trainer/kinematics/arm_kinematics.h"

namespace raven2_trainer::control {

/** The column of the mid-line is that of grasper 2 going as grasper 1 comes. */
ServoJacobian servoJacobian(const ArmGeometry& geometry, Arm arm, const JointArray& q) noexcept {
  const kinematics::Jacobian J = kinematics::jacobian(geometry, arm, q);
  ServoJacobian J_B = J.leftCols<6>();
  J_B.col(5) = J.col(kGrasp2) - J.col(kGrasp1);
  return J_B;
}

/** Graspers are -midline + opening / 2 and midline + opening / 2. */
ServoJoints servoForces(const JointArray& tau) noexcept {
  ServoJoints forces{};
  std::copy_n(tau.begin(), kServoJointCount - 1, forces.begin());
  forces.back() = tau[kGrasp2] - tau[kGrasp1];
  return forces;
}

double jawForce(const JointArray& tau) noexcept {
  return (tau[kGrasp1] + tau[kGrasp2]) / 2;
}

JointArray jointForces(const ServoJoints& forces, double jaw) noexcept {
  JointArray tau{};
  std::copy_n(forces.begin(), kServoJointCount - 1, tau.begin());
  tau[kGrasp1] = jaw - forces.back() / 2;
  tau[kGrasp2] = jaw + forces.back() / 2;
  return tau;
}

ServoJoints servoForces(const ArmGeometry& geometry, Arm arm, const JointArray& q, const Effort& effort) noexcept {
  ServoJoints forces = effort.numbers;
  if (effort.kind == EffortKind::kJoints) return forces;
  const Pose X_BT = kinematics::forward(geometry, arm, q);
  Eigen::Matrix<double, 6, 1> wrench_B = Eigen::Map<const Eigen::Matrix<double, 6, 1>>(effort.numbers.data());
  if (effort.kind == EffortKind::kBody) wrench_B << X_BT.R * wrench_B.head<3>(), X_BT.R * wrench_B.tail<3>();
  if (effort.kind == EffortKind::kOrigin) wrench_B.tail<3>() -= X_BT.p.cross(Vector3(wrench_B.head<3>()));
  Eigen::Map<Eigen::Matrix<double, 6, 1>>(forces.data()) = servoJacobian(geometry, arm, q).transpose() * wrench_B;
  return forces;
}

}  // namespace raven2_trainer::control
