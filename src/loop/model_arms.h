#pragma once

#include "loop/increments.h"
#include "raven2_trainer/control/teleop_mapper.h"
#include "raven2_trainer/core/state.h"
#include "raven2_trainer/kinematics/arms_config.h"
#include "raven2_trainer/loop/model_driver.h"
#include "raven2_trainer/physics/raven_world.h"

namespace raven2_trainer::loop {

/**
 * Both arms of the nominal model in their world: where they are asked to be, how they get there, and whether they are
 * where the robot is or apart from it on purpose. One thread; real-time safe but for the constructor.
 */
class ModelArms {
 public:
  /** Puts the arms at their home. @throw ModelException if the models cannot be turned into bodies. */
  ModelArms(const ModelConfig& config,
            const ArmsConfig& arms,
            const model::RavenModel& raven,
            const model::SceneModel& scene);

  physics::RavenWorld& world() noexcept { return world_; }
  const physics::RavenWorld& world() const noexcept { return world_; }
  ModelDriver& driver() noexcept { return driver_; }
  const PerArm<control::TeleopMapper>& mappers() const noexcept { return mappers_; }

  /** [rad; m] where an arm is. */
  JointArray joints(Arm arm) const noexcept;
  PerArm<JointArray> joints() const noexcept { return {joints(Arm::kGold), joints(Arm::kGreen)}; }

  // ---- where they shall be
  /** [rad; m] */
  const PerArm<JointArray>& wanted() const noexcept { return q_d_; }
  void want(const PerArm<JointArray>& q) noexcept { q_d_ = q; }
  /** Whatever comes next starts from where the arms are. */
  void rebase() noexcept;
  /** Adds the hands' increments of one arm. @param[in] dgrasp [rad] */
  kinematics::IkStatus add(Arm arm, const Increments& increments, double dgrasp, const JointArray& now) noexcept;
  /** The jaws turn along, but go on pressing on what they hold: the opening stays the one that was asked for. */
  void wantOnPath(Arm arm, const JointArray& q) noexcept;
  /** [rad] The jaws' opening that is asked for. */
  double opening(Arm arm) const noexcept { return at(mappers_, arm).opening(); }
  /** The openings of these joints are asked for from now on. */
  void takeOpenings(const PerArm<JointArray>& q) noexcept;
  /** An arm that forces push goes where they take it: hands do not move it. */
  void yield(Arm arm, const JointArray& now, Increments* increments) noexcept;

  // ---- how they get there
  /** As configured, or as asked for. */
  void setCollisions(Arm arm, bool are_wanted) noexcept { at(collisions_, arm) = are_wanted; }
  /** Before drive(). @param[in] pass_through nothing stops the arms. */
  void prepare(bool pass_through) noexcept;
  /** One step of the world, the controllers driving the arms to `target` [rad; m]. */
  void drive(const PerArm<JointArray>& target, ModelState* state) noexcept;
  /** Puts an arm where it shall be, at rest: nothing else moves, and nothing is touched. */
  void show(Arm arm, ModelState* state) noexcept;
  /** Where they are, for the state of a tick. @param[in] touches they may touch something. */
  void describe(Arm arm, bool touches, ArmState* state) const noexcept;

  // ---- with the robot, and apart
  bool isApart() const noexcept { return is_apart_; }
  void meetRobot() noexcept { is_apart_ = false; }
  /** The jaws' openings that model and robot have in common are what the model comes back with. */
  void leaveRobot() noexcept;
  void keepOpenings() noexcept;
  /** [rad] with which the model comes back. */
  double openingKept(Arm arm) const noexcept { return at(kept_opening_, arm); }
  /** The common pose from which both start at pedal down. The jaws keep their opening: they may hold something. */
  void join(const PerArm<JointArray>& robot_q) noexcept;
  /** The arm shall be where the robot's is. @return what to ask of the controllers [rad; m]. */
  JointArray follow(Arm arm, const JointArray& robot_q) noexcept;
  /** Shoulder to wrist get the rates that bring them to the joints within some milliseconds: they move there, what the
   *  jaws hold moves along. @return what to ask of the controllers, so that they do not brake it. */
  JointArray bringTo(Arm arm, const JointArray& wanted) noexcept;

 private:
  ArmGeometry geometry_;
  physics::RavenWorld world_;
  PerArm<control::TeleopMapper> mappers_;
  ModelDriver driver_;
  PerArm<JointArray> q_d_{};
  PerArm<bool> collisions_{};
  bool is_apart_{false};
  PerArm<double> kept_opening_{};
};

}  // namespace raven2_trainer::loop
