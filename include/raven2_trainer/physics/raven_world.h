#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "raven2_trainer/core/contact.h"
#include "raven2_trainer/core/exercise.h"
#include "raven2_trainer/core/state.h"
#include "raven2_trainer/model/raven_model.h"
#include "raven2_trainer/physics/model_config.h"
#include "raven2_trainer/physics/scene_snapshot.h"

namespace raven2_trainer::physics {

/**
 * Both arms of the nominal model and the training scene as one ODE world (double precision, dWorldStep, 1 ms).
 *
 * Traps of ODE 0.16.2, all measured (sources.md 1.1). Its slider rate is wrong on a rotating
 * parent, so joint rates are computed from the bodies. Each world has its own threading implementation, or two
 * worlds crash. Capsule-trimesh contacts are incomplete, so collisions use primitives only. A link that collides by
 * meshes only is refused; contacts are reduced to four a body pair; friction is bounded by the normal forces of the
 * step before (src/physics/contact_forces.h). Nothing is ever glued.
 *
 * A part that may break off (SceneModel::breakables) is fixed like the rest of the scene, to the last bit. It breaks
 * off if the forces of its contacts in the last sub-step of a tick, or their moment about its foot, exceed its strength
 * for a number of ticks in a row. From the next tick on it is a free body. With SceneModel::parking, free bodies that
 * have been at rest for 300 ticks, with nothing near that moves, are parked. They are left out of the equations, with
 * one contact for each body that holds them in the contact list, until the box of something that moves meets theirs.
 *
 * step() is real-time safe after a warm-up of some hundred steps. Not thread-safe: one thread owns a world.
 */
class RavenWorld {
 public:
  /** @throw ModelException if the models cannot be turned into bodies. */
  RavenWorld(const model::RavenModel& raven, const model::SceneModel& scene, const ModelConfig& config);
  ~RavenWorld();
  RavenWorld(const RavenWorld&) = delete;
  RavenWorld& operator=(const RavenWorld&) = delete;

  /** Puts an arm at joint positions `q` with rates `dq` (robot joint coordinates), all bodies exactly on the chain.
   *  Whatever is not finite freezes the world, as in step(). */
  void setJointState(Arm arm, const JointArray& q, const JointArray& dq) noexcept;

  /** Joint positions and rates now (robot joint coordinates). */
  void jointState(Arm arm, JointArray* q, JointArray* dq) const noexcept;

  /** Joint torques [Nm; N] that would hold both arms against gravity at their present positions. */
  JointArray gravityTorque(Arm arm) const noexcept;

  /** One step of 1 ms under these joint torques (robot joint coordinates); friction and the inertia of the rotors
   *  (ModelConfig) are added inside. Torques that are not finite freeze the world. */
  void step(const PerArm<JointArray>& tau) noexcept;

  /** Contact points on the arm in the last step, at most four for each pair of bodies. */
  std::uint32_t contacts(Arm arm) const noexcept;

  /** In the last step something touched the arm that does not give way: the fixed scene or the other arm. */
  bool isObstructed(Arm arm) const noexcept;

  /** Contacts of the last step: places and normals from its beginning, the forces it made, friction included. Contacts
   * without room are counted; `tick` is left to the caller. Fixed shapes never meet. Real-time safe. */
  void contactList(ContactList* list) const noexcept;

  /** Names of the URDF links, robot's and scene's, by the numbers of the contact list. */
  const std::vector<std::string>& bodyNames() const noexcept;

  /** Bodies of the scene that can move, in W: free bodies, then breakables, in SceneModel order. */
  void bodyPoses(std::array<RigidPose, kMaxSceneBodies>* poses) const noexcept;

  /** The parts of SceneModel::breakables that are off their foot. */
  BrokenOff brokenOff() const noexcept;

  /** Bit i: body i of bodyPoses() is parked. */
  std::uint16_t parked() const noexcept;

  /** The bodies of bodyPoses() with all that their future depends on, apart from the arms. Real-time safe. */
  void saveScene(SceneSnapshot* snapshot) const noexcept;

  /**
   * Puts them back as they were, whatever has become of them: held parts back on their feet. From equal states of the
   * arms it goes on with equal bits. Contacts are reported again from the next step on. Nothing happens if the world is
   * not healthy or the snapshot is of another number of bodies. Real-time safe.
   */
  void restoreScene(const SceneSnapshot& snapshot) noexcept;

  /** Lets an arm collide with the scene and the other arm, or not (planning mode, fault runs). */
  void setCollisions(Arm arm, bool enabled) noexcept;

  /** False once ODE reported an internal error or a state is not finite; the world then no longer moves. */
  bool healthy() const noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/**
 * Once per process, before the first world, on the main thread. Safe to call again.
 * ODE's errors become exceptions: ModelException in set-up; step() catches them and the world is unhealthy.
 * @throw ModelException if ODE cannot be initialised.
 */
void initialiseOde();

/** How often ODE's solver gave up in a step of any world of the process: some contacts of that step had no force. Any
 * thread. */
std::uint64_t solverWarnings() noexcept;

/** In every thread that steps a world, before its first step. */
void attachOdeToThread();

}  // namespace raven2_trainer::physics
