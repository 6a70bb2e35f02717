#pragma once

#include <memory>

#include "raven2_trainer/control/arm_controller.h"
#include "raven2_trainer/control/effort.h"
#include "raven2_trainer/physics/arm_world.h"
#include "raven2_trainer/physics/model_config.h"
#include "raven2_trainer/physics/raven_world.h"

namespace raven2_trainer::loop {

/** The nominal model's own control loop: gravity compensation, PD and PID of both arms on a world, as a session and the
 *  program model_follow run it. Real-time safe. */
class ModelDriver {
 public:
  /** @param[in] world outlives the driver. */
  ModelDriver(const ModelConfig& config, const ArmGeometry& geometry, physics::RavenWorld* world) noexcept;

  /** Set-up for openLoop(). @throw ModelException if the model cannot be turned into bodies. */
  void allowOpenLoop(const model::RavenModel& raven, const ModelConfig& config);

  /** Forgets the integral of an arm and what pushes it: it starts again from where it is, in closed loop. */
  void reset(Arm arm) noexcept;

  /** From the next step on these forces, each within what that joint's controller may use, take the place of the
   *  controllers' torques. */
  void push(Arm arm, const Effort& effort) noexcept { at(efforts_, arm) = effort; }
  /** Something pushes the arm, so that it has no fixed place: not the jaws alone. */
  bool isPushed(Arm arm) const noexcept { return at(efforts_, arm).kind != EffortKind::kNone; }

  /** From now on an arm gets the torques of a separate arm in a separate world. That arm starts at its place, at rest,
   *  and the law drives it to the set points. The jaws are excepted: they hold objects that the separate arm does not
   * have. */
  void openLoop(Arm arm) noexcept;

  /** [rad; m] What to ask for so that an arm in motion is where it should be: the law damps velocity,
   *  so a plain `q` would be followed with a lag (control::ArmController). */
  JointArray leading(Arm arm, const control::JointTarget& target) const noexcept {
    return at(controllers_, arm).leading(target);
  }

  /** One step of 1 ms towards `q_d` [rad; m], robot joint coordinates. @return the torques applied [Nm; N]. */
  PerArm<JointArray> step(const PerArm<JointArray>& q_d) noexcept;

 private:
  /** An arm that is predicted. */
  struct Twin {
    std::unique_ptr<physics::ArmWorld> world;  ///< null: not allowed
    bool leads{false};
  };
  JointArray closedTorque(Arm arm, const JointArray& q_d) noexcept;
  void applyEffort(Arm arm, JointArray* tau) const noexcept;
  void takeOver(Twin& twin, Arm arm, const JointArray& q_d, JointArray* tau) noexcept;

  ArmGeometry geometry_;
  std::array<JointGains, kJointCount> gains_;
  physics::RavenWorld& world_;
  PerArm<control::ArmController> controllers_, twin_controllers_;
  PerArm<Twin> twins_;
  PerArm<Effort> efforts_{};
};

}  // namespace raven2_trainer::loop
