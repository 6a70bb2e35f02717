#pragma once

#include <memory>

#include "raven2_trainer/control/arm_controller.h"
#include "raven2_trainer/control/effort.h"
#include "raven2_trainer/physics/arm_world.h"
#include "raven2_trainer/physics/model_config.h"
#include "raven2_trainer/physics/raven_world.h"

namespace raven2_trainer::loop {

/** Control loop of the nominal model: gravity compensation, PD and PID of both arms in a RavenWorld. Sessions and the
 *  program model_follow use it. Real-time safe. */
class ModelDriver {
 public:
  /** @param[in] world outlives the driver. */
  ModelDriver(const ModelConfig& config, const ArmGeometry& geometry, physics::RavenWorld* world) noexcept;

  /** Set-up for openLoop(). @throw ModelException if bodies cannot be made from the model. */
  void allowOpenLoop(const model::RavenModel& raven, const ModelConfig& config);

  /** Clears an arm's integral and effort: it starts again from its position, in closed loop. */
  void reset(Arm arm) noexcept;

  /** From the next step on these forces replace the controllers' torques, each within that joint's controller limit. */
  void push(Arm arm, const Effort& effort) noexcept { at(efforts_, arm) = effort; }
  /** Whether an effort moves the arm; one on the jaws alone does not. */
  bool isPushed(Arm arm) const noexcept { return at(efforts_, arm).kind != EffortKind::kNone; }

  /** From now on an arm gets the torques of a twin in a separate world, except its jaws: they hold objects that the
   *  twin does not have. The twin starts at rest at the arm's joints; the control law drives it to the set points. */
  void openLoop(Arm arm) noexcept;

  /** [rad; m] Set point that compensates the lag of an arm in motion: the law damps velocity
   *  (control::ArmController). */
  JointArray leading(Arm arm, const control::JointTarget& target) const noexcept {
    return at(controllers_, arm).leading(target);
  }

  /** One step of 1 ms towards `q_d` [rad; m], robot joint coordinates. @return the torques applied [Nm; N]. */
  PerArm<JointArray> step(const PerArm<JointArray>& q_d) noexcept;

 private:
  /** The twin of openLoop(). */
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
