#pragma once

#include "raven2_trainer/control/joint_pid.h"
#include "raven2_trainer/core/config.h"
#include "raven2_trainer/physics/raven_world.h"

namespace raven2_trainer::runtime {

/** The nominal model's own control loop: gravity compensation, PD and PID of both arms on a world, as a session and the
 *  program model_follow run it. Real-time safe. */
class ModelDriver {
 public:
  /** @param[in] world outlives the driver. */
  ModelDriver(const ModelConfig& config, physics::RavenWorld* world) noexcept;

  /** Forgets the integral of an arm: it starts anew from where it is. */
  void reset(Arm arm) noexcept { at(pids_, arm).reset(); }

  /** [rad; m] What to ask for so that a joint at `q` moving with `dq` is where it should be: the law damps velocity,
   *  so a plain `q` would be followed with a lag of (kd + viscous friction) / kp. The jaws are left at `q`. */
  JointArray leading(Arm arm, const JointArray& q, const JointArray& dq) const noexcept;

  /** One step of 1 ms towards `q_d` [rad; m], robot joint coordinates. @return the torques applied [Nm; N]. */
  PerArm<JointArray> step(const PerArm<JointArray>& q_d) noexcept;

 private:
  physics::RavenWorld& world_;
  PerArm<control::JointPid> pids_;
  PerArm<JointArray> lag_{};  ///< [s]
  bool gravity_compensation_;
};

}  // namespace raven2_trainer::runtime
