#pragma once

#include <Eigen/Core>

#include "raven2_trainer/raven/virtual_raven_config.h"

namespace raven2_trainer::raven {

/** Joint to motor positions and back through the cables, raven2.md 3.3 (tool `r_grasper`: no wrist coupling,
 *  OPPOSE_GRIP). Linear: motor = A * joint, the tool rows with the signs of the arm. Real-time safe. */
class CableCoupling {
 public:
  /** @throw ConfigException if a transmission ratio is not positive. */
  CableCoupling(Arm arm, const VirtualRavenConfig& config);
  /** [rad] from [rad; m]. */
  JointArray toMotor(const JointArray& q) const noexcept;
  /** As the control law wants it: the tool rows follow the measured insertion motor [rad], not the desired one. */
  JointArray toMotorMeasured(const JointArray& q, double insertion_motor) const noexcept;
  /** [rad; m] from [rad]; also for rates. */
  JointArray toJoint(const JointArray& motor) const noexcept;
  const Eigen::Matrix<double, 7, 7>& matrix() const noexcept { return matrix_; }
  const Eigen::Matrix<double, 7, 7>& inverse() const noexcept { return inverse_; }

 private:
  Eigen::Matrix<double, 7, 7> matrix_, inverse_;
  JointArray tool_per_insertion_{};  // [rad/rad] tool motor per insertion motor
};

}  // namespace raven2_trainer::raven
