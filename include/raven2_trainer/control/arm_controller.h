#pragma once

#include "raven2_trainer/control/controller_config.h"
#include "raven2_trainer/control/joint_pid.h"

namespace raven2_trainer::control {

/** Desired joint positions and velocities of an arm at one moment. */
struct JointTarget {
  JointArray q{};   ///< [rad; m]
  JointArray dq{};  ///< [rad/s; m/s]
};

/** The gains of one arm: that of the insertion's rate differs between the arms. */
std::array<JointGains, kJointCount> gainsOf(const ControllerConfig& config, Arm arm) noexcept;

/** The control law of one arm of the nominal model: gravity compensation, PD, and PID for the insertion (paper, 3.1),
 *  with that arm's gains. The live model and the planner's prediction use this same law. Real-time safe. */
class ArmController {
 public:
  ArmController(const ControllerConfig& config, Arm arm) noexcept;

  /** Clears the integral, for a new start from the present position. */
  void reset() noexcept { pid_.reset(); }

  /**
   * @return [rad; m] `q_d` for torque() that keeps a moving arm on its target: target.q + lag x target.dq. The law
   * damps velocity, so without this lead each joint lags by (kd + viscous friction) / kp, 25 to 99 ms. With the lead,
   * the law is PD on both errors, kp (q_d - q) + kd (dq_d - dq), plus feed-forward of the viscous friction at dq_d.
   */
  JointArray leading(const JointTarget& target) const noexcept;

  /** @return [Nm; N] torques that move the arm from `q` to `q_d`. @param[in] gravity [Nm; N] holds the arm at `q`. */
  JointArray torque(const JointArray& q_d,
                    const JointArray& q,
                    const JointArray& dq,
                    const JointArray& gravity) noexcept;

 private:
  bool gravity_compensation_;
  JointArray lag_{};  // [s]
  JointPid pid_;
};

}  // namespace raven2_trainer::control
