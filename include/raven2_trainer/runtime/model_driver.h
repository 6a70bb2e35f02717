#pragma once

#include "raven2_trainer/control/arm_controller.h"
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
  void reset(Arm arm) noexcept { at(controllers_, arm).reset(); }

  /** [rad; m] What to ask for so that an arm in motion is where it should be: the law damps velocity,
   *  so a plain `q` would be followed with a lag (control::ArmController). */
  JointArray leading(Arm arm, const control::JointTarget& target) const noexcept {
    return at(controllers_, arm).leading(target);
  }

  /** One step of 1 ms towards `q_d` [rad; m], robot joint coordinates. @return the torques applied [Nm; N]. */
  PerArm<JointArray> step(const PerArm<JointArray>& q_d) noexcept;

 private:
  physics::RavenWorld& world_;
  PerArm<control::ArmController> controllers_;
};

}  // namespace raven2_trainer::runtime
