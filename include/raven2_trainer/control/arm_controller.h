#pragma once

#include "raven2_trainer/control/controller_config.h"
#include "raven2_trainer/control/joint_pid.h"

namespace raven2_trainer::control {

/** Where an arm shall be at some moment, and how fast it shall move there. */
struct JointTarget {
  JointArray q{};   ///< [rad; m]
  JointArray dq{};  ///< [rad/s; m/s]
};

/** The control law of one arm of the nominal model: gravity compensation, PD, PID of the insertion (paper, 3.1), with
 *  that arm's gains. One law for the live model and for what is predicted of it. Real-time safe. */
class ArmController {
 public:
  ArmController(const ControllerConfig& config, Arm arm) noexcept;

  /** Forgets the integral: the arm starts again from where it is. */
  void reset() noexcept { pid_.reset(); }

  /**
   * [rad; m] What to ask for so that the arm is at its target in motion: target.q + lag x target.dq. The law damps
   * velocity, so a plain q is followed with a lag of (kd + viscous friction) / kp, 25 to 99 ms, another one for each
   * joint. With it the law is PD on both errors, kp (q_d - q) + kd (dq_d - dq), and the viscous friction at dq_d in
   * advance.
   */
  JointArray leading(const JointTarget& target) const noexcept;

  /** [Nm; N] towards `q_d` from where the arm is. @param[in] gravity [Nm; N] that would hold it there. */
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
