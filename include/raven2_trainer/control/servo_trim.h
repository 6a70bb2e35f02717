#pragma once

#include <array>
#include <cstddef>

#include "raven2_trainer/kinematics/arms_config.h"
#include "raven2_trainer/kinematics/eigen.h"

namespace raven2_trainer::control {

/**
 * What dry friction keeps a robot's shoulder, elbow and insertion from: their control has no integral (raven2.md 3.6),
 * so that they rest away from their commanded position, the virtual Raven's elbow 3.5 mrad. While a CRTK client's set
 * point rests, what is missing is asked for in addition, as slowly as the robot's own integral works in its tool
 * joints; what moves forgets it as slowly. Bounded: a tool that is held back by what it touches presses no harder than
 * by kLimit. At a joint's limit the arm is asked to be kInside of it. Pure; real-time safe.
 */
class ServoTrim {
 public:
  static constexpr std::size_t kJoints = 3;
  using Joints = std::array<double, kJoints>;  ///< [rad, rad, m]

  static constexpr Joints kLimit{5e-3, 5e-3, 5e-4};   ///< friction over kp is 1.2 mrad, 3.5 mrad and 0.34 mm there
  static constexpr Joints kEnough{5e-4, 5e-4, 5e-5};  ///< missing less than this is let be: 0.03 degrees

  static constexpr double kInside = 5e-5;  ///< [rad, m] a pose in whole micrometres is not beyond the limit, either

  /** @param[in] time [s] constant of the approach; 0: there is no trim. @param[in] geometry limits of the joints. */
  ServoTrim(double time, const ArmGeometry& geometry) noexcept
      : time_(time), q_min_(geometry.q_min), q_max_(geometry.q_max) {}

  /** A tick. @param[in] asked, measured [rad; m] the set point and the robot. @param[in] rests the set point does. */
  void step(const JointArray& asked, const JointArray& measured, bool rests) noexcept;
  void forget() noexcept { joints_ = {}; }

  const Joints& joints() const noexcept { return joints_; }  ///< asked for in addition
  JointArray with(const JointArray& q) const noexcept;
  JointArray without(const JointArray& q) const noexcept;

 private:
  double time_;
  JointArray q_min_, q_max_;  ///< [rad, rad, m]
  Joints joints_{};
};

/** Displacement of the tool by a change of joints: in B, with the rotation about the tip. */
struct Displacement {
  Vector3 p = Vector3::Zero();
  Matrix3 R = Matrix3::Identity();

  Pose of(const Pose& X) const noexcept { return {R * X.R, X.p + p}; }
  Pose before(const Pose& X) const noexcept { return {R.transpose() * X.R, X.p - p}; }
};

Displacement displacement(const ArmGeometry& geometry, Arm arm, const JointArray& from, const JointArray& to) noexcept;

}  // namespace raven2_trainer::control
