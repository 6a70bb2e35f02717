#pragma once

#include <memory>

#include "raven2_trainer/core/types.h"
#include "raven2_trainer/model/raven_model.h"
#include "raven2_trainer/physics/model_config.h"

namespace raven2_trainer::physics {

/** All that an ArmWorld's future depends on, apart from the torques. */
struct ArmMotion {
  JointArray q{}, dq{};  ///< [rad; m], [rad/s; m/s] robot joint coordinates
  JointArray urdf_q{},
      urdf_dq{};              ///< the same in URDF coordinates, as they were integrated: no conversion, no rounding
  JointArray acceleration{};  ///< [rad/s2; m/s2] URDF coordinates, at the end of the last step
};

/**
 * One arm of the nominal model alone in its own ODE world, without shapes, but for its jaws, which stop each
 * other. It moves as that arm of a RavenWorld does where nothing touches it: ODE solves the same equations in fewer
 * rows, so that they differ by rounding, less than 1e-9 over seconds. For roll-outs: what an arm would do, computed
 * in addition to the live world and faster than real time.
 *
 * Has its own threading implementation and solver memory, so that worlds in several threads do not meet
 * (sources.md 1.3). Not thread-safe: one thread at a time, which must have called attachOdeToThread().
 */
class ArmWorld {
 public:
  /** Of `config` the parts of friction, rotors, gravity, erp, cfm and sub_steps count. The arm starts at home.
   *  @throw ModelException if the model cannot be turned into bodies. */
  ArmWorld(const model::RavenModel& raven, Arm arm, const ModelConfig& config);
  ~ArmWorld();
  ArmWorld(const ArmWorld&) = delete;
  ArmWorld& operator=(const ArmWorld&) = delete;

  /** At `q`, moving with `dq` (robot joint coordinates), without a past. NaN and infinity freeze the world. */
  void setState(const JointArray& q, const JointArray& dq) noexcept;

  const JointArray& q() const noexcept;   ///< [rad; m] now
  const JointArray& dq() const noexcept;  ///< [rad/s; m/s] now

  /** [Nm; N] that would hold the arm against gravity where it is. */
  JointArray gravityTorque() const noexcept;

  /** One tick of 1 ms under these torques [Nm; N], in config.sub_steps steps. Torques that are not finite freeze it. */
  void step(const JointArray& tau) noexcept;

  /** Data for restore(), in this or an equal world, to go on with the same bits. */
  ArmMotion motion() const noexcept;
  void restore(const ArmMotion& motion) noexcept;

  /** False once ODE reported an internal error or a state was not finite; it then no longer moves. setState() and
   * restore() with finite numbers put that right, unless ODE was cut off in the midst of a step. */
  bool healthy() const noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace raven2_trainer::physics
