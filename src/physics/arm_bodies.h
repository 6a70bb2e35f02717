#pragma once

#include <array>
#include <vector>

#include <ode/ode.h>

#include "physics/arm_recursion.h"
#include "physics/rigid_links.h"
#include "raven2_trainer/model/raven_model.h"
#include "raven2_trainer/physics/arm_world.h"
#include "raven2_trainer/physics/model_config.h"

namespace raven2_trainer::physics {

/** Motion of a link in a step beyond ODE's velocity: second order, since it moves along arcs. */
struct Excess {
  Vector3 shift{0, 0, 0};  ///< [m] in W, of a point of the link
  Vector3 turn{0, 0, 0};   ///< [rad] in W
};

/** Dry friction of a joint in ODE's equations. */
enum class DryFriction {
  kRow,       ///< its own bounded row: ODE finds out whether it holds. Dear: a row more, and bounds
  kHolds,     ///< a damper up to the creep rate, part of the rotor's row
  kForward,   ///< constant, against positive motion
  kBackward,  ///< constant, against negative motion
};

/**
 * The seven moving bodies of one arm and the joints between them.
 *
 * A step of h has these parts. The bodies are exactly on the chain in the middle of the step, q* = q + h/2 dq, so
 * hinges never open. Gravity and velocity terms (Coriolis, centrifugal, gyroscopic: ODE sees links at rest) are
 * subtracted from the joint torques. ODE solves for the mean acceleration a with rotors, contacts, stops and friction.
 * correct() corrects changes within the step, to fourth order in h. doc/model.md, Dynamics.
 *
 * Each robot joint is an ODE hinge or slider, and next to it an ODE motor joint along the same axis that adds these
 * parts.
 *  - rotor inertia and viscous friction as one implicit row. The motor's velocity equation is J v + cfm lambda =
 * target. With 1 / cfm = I/h + b t and target / cfm = (I/h - b (1 - t)) dq it gives lambda = -I (dq' - dq) / h - b (t
 * dq' + (1 - t) dq). The weight t is from 1/2 (second order) to 1 (implicit), so that a decay exp(-b h / I) is met for
 * any step. It is stable for any I and b.
 *  - Coulomb friction as a bounded row (no chatter, real sticking), only where it is not zero.
 *  - The stops of hinges. Those of ODE's own hinge end at +-pi, the tool roll goes further.
 *
 * Rates are computed from the bodies (dJointGetSliderPositionRate forgets the turning of the parent, sources.md 1.1).
 * Real-time safe after construction.
 */
class ArmBodies {
 public:
  /** `X_WL`: pose in W of every link of the robot, used for the links that are fixed. `step`: [s]. `alone`: nothing
   * will ever touch it, so that what turns about an axis fixed in W needs no rows (Part::pivots).
   *  @throw ModelException */
  ArmBodies(dWorldID world,
            const model::RavenModel& raven,
            const std::vector<Carrier>& carriers,
            const std::vector<Pose>& X_WL,
            Arm arm,
            const ModelConfig& config,
            double step,
            bool alone = false);

  /** The arm at `q`, moving with `dq`; forgets the past. */
  void setState(const JointArray& q, const JointArray& dq) noexcept;

  /** All of the past that the future depends on. */
  ArmMotion motion() const noexcept;
  void restore(const ArmMotion& motion) noexcept;

  /**
   * Dry friction without bounded rows, where nothing touches the arm: guessed before a step by the rates at its
   * beginning, to be checked after it by those that ODE found. Where they say otherwise, takeBack() and step again with
   * another guess or with useFrictionRows(), which is the state from the beginning. The solution is the same but for
   * rounding.
   */
  void guessFriction() noexcept;
  bool isFrictionAsGuessed() const noexcept;
  void guessFrictionAsSolved() noexcept;
  void useFrictionRows() noexcept;
  /** Instead of advance(): bodies where the step began. */
  void takeBack() noexcept { putBodies(); }

  /** Of the last step, for the point of link `joint` that was at `point` [m, in W] when it began (or h v further: that
   *  makes no difference of second order). */
  Excess excess(std::size_t joint, const Vector3& point) const noexcept;

  /** Hands torques, rotor inertia, friction and the terms of the turning to the coming step. */
  void applyTorque(const JointArray& tau) noexcept;

  /** After the step: takes the new rates from the bodies, moves the joints on and puts the bodies on the chain for the
   *  next step. `touched`: contacts acted on the arm; impacts within a step are no smooth path and are not corrected.
   *  @return false, nothing changed, if a number is not finite. */
  bool advance(bool touched) noexcept;

  const JointArray& q() const noexcept { return q_; }
  const JointArray& dq() const noexcept { return dq_; }

  JointArray gravityTorque() const noexcept;

  dBodyID body(std::size_t joint) const noexcept { return parts_[joint].body; }
  const Vector3& com(std::size_t joint) const noexcept { return recursion_.link(joint).inertial.com; }

 private:
  struct Part {
    double lower{}, upper{};  // URDF coordinates
    double coulomb{};
    DryFriction friction{DryFriction::kRow};
    /** Turns about an axis fixed in W: a body at that axis, so heavy that nothing else of it moves, with the inertia
     * about the axis that the link, its rotor and the implicit part of viscous friction have together. Six rows less in
     * ODE's matrix, whose factorisation is most of a step; the same motion to 1e-12. */
    bool pivots{};
    dBodyID body{nullptr};
    dJointID joint{nullptr};
    dJointID motor{nullptr};
  };

  /** The motion within a step: the mean acceleration and its slope. */
  struct Motion {
    Vector7 mean, slope;
  };

  void createPart(dWorldID world,
                  const model::RavenModel& raven,
                  const std::vector<Carrier>& carriers,
                  const std::vector<Pose>& X_WL,
                  std::size_t j);
  void createHinge(dWorldID world, std::size_t j, const Vector3& anchor, const Vector3& axis);
  void createSlider(dWorldID world, std::size_t j, const Vector3& axis);
  void chooseShares() noexcept;
  void setPivots() noexcept;
  /** [m] in W, from the origin of a link to that of its body. */
  Vector3 bodyOffset(std::size_t j) const noexcept { return parts_[j].pivots ? Vector3::Zero() : placed_[j].com; }
  dBodyID parentBody(std::size_t j) const noexcept;
  void placeBodies() noexcept;
  void putBodies() noexcept;
  void setFriction(std::size_t j, DryFriction friction) noexcept;
  DryFriction frictionAt(std::size_t j, double rate) const noexcept;
  double rate(std::size_t j) const noexcept;
  Motion correct(const Vector7& solved) const noexcept;
  void applyTo(std::size_t j, double torque) const noexcept;
  void setMotor(std::size_t j) const noexcept;

  Arm arm_;
  double d4_;
  double stop_erp_;
  double step_;
  bool alone_;
  ArmRecursion recursion_;
  std::array<Part, kJointCount> parts_{};
  Vector7 rotor_, viscous_;                         // [kg m2; kg], [Nms/rad; Ns/m]
  Vector7 share_{Vector7::Constant(0.5)};           // of the new rate in viscous friction
  bool stiff_{false};                               // friction ends a motion within the step: nothing to correct
  JointArray q_{}, dq_{};                           // robot joint coordinates, at the end of the last step
  Vector7 urdf_q_, urdf_dq_;                        // the same in URDF coordinates
  Vector7 acceleration_{Vector7::Zero()};           // at the end of the last step: the guess for the next one
  PlacedLinks placed_before_{};                     // and in the step before
  std::array<Vector3, kJointCount> v_com_{}, w_{};  // of the bodies, as ODE found them in the last step
  PlacedLinks placed_now_;                          // at urdf_q_
  PlacedLinks placed_;                              // in the middle of the coming step
  Vector7 bias_{Vector7::Zero()};                   // [Nm; N] that gravity and the turning of the links cost there
};

}  // namespace raven2_trainer::physics
