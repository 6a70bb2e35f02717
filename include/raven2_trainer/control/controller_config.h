#pragma once

#include <array>

#include "raven2_trainer/core/types.h"

namespace raven2_trainer {

/** Gains of one joint controller of the nominal model. */
struct JointGains {
  double kp{};     ///< [Nm/rad; N/m]
  double kd{};     ///< [Nms/rad; Ns/m] on the joint velocity (the robot never sets a desired velocity)
  double ki{};     ///< [Nm/(rad s); N/(m s)] only the insertion joint (paper, 3.1)
  double limit{};  ///< [Nm; N] bound of |tau|
};

/** The arms' controllers (config/model.yaml). */
struct ControllerConfig {
  std::array<JointGains, kJointCount> gains{};
  double green_insertion_kd{};  ///< [Ns/m] the one gain that differs between the robot's arms (raven2.md 3.6)
  bool gravity_compensation{};
  JointArray viscous_friction{};  ///< [Nms/rad; Ns/m] of the joints
};

}  // namespace raven2_trainer
