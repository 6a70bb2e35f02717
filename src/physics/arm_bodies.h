#pragma once

#include <array>
#include <vector>

#include <ode/ode.h>

#include "physics/rigid_links.h"
#include "raven2_trainer/model/raven_model.h"

namespace raven2_trainer::physics {

/**
 * The seven moving bodies of one arm and the joints between them.
 *
 * Each robot joint is an ODE hinge or slider, and beside it an ODE motor joint along the same axis that adds
 *  - rotor inertia and viscous friction as one implicit row: the motor's velocity equation
 *    J v + cfm lambda = target, with cfm = 1 / (I/h + b) and target = dq_old (I/h) / (I/h + b) - h Jdot v, says
 *    lambda = -I (dq - dq_old) / h - b dq with dq = J v + h Jdot v: stable for any I and b;
 *  - Coulomb friction as a bounded row (no chatter, real sticking), only where it is not zero;
 *  - the stops of hinges: those of ODE's own hinge end at +-pi, the tool roll goes further.
 *
 * Positions and rates are computed from the bodies (dJointGetSliderPositionRate forgets the turning of the parent,
 * performance.md section 0). Real-time safe after construction.
 */
class ArmBodies {
 public:
  /** `X_WL`: pose in W of every link of the robot, used for the links that are fixed. @throw ModelException */
  ArmBodies(dWorldID world,
            const model::RavenModel& raven,
            const std::vector<Carrier>& carriers,
            const std::vector<Pose>& X_WL,
            Arm arm,
            const ModelConfig& config);

  /** Puts all bodies on the chain at `q`, moving with `dq`. */
  void setState(const JointArray& q, const JointArray& dq) noexcept;

  /** Reads positions and rates from the bodies. @return false, nothing changed, if one is not finite. */
  bool measure() noexcept;

  const JointArray& q() const noexcept { return q_; }
  const JointArray& dq() const noexcept { return dq_; }

  JointArray gravityTorque() const noexcept;

  /** Hands torques, rotor inertia and friction to the coming step. */
  void applyTorque(const JointArray& tau) noexcept;

  dBodyID body(std::size_t joint) const noexcept { return parts_[joint].body; }
  const Vector3& com(std::size_t joint) const noexcept { return parts_[joint].inertial.com; }

 private:
  struct Part {
    int parent{-1};         // index of the part that carries the joint; -1: the world
    Pose X_PJ;              // joint in the parent's link frame, or in W
    Vector3 axis{0, 0, 1};  // in the joint frame, and so in the link frame
    bool slides{};
    double lower{}, upper{};  // URDF coordinates
    double rotor{};           // [kg m2; kg]
    double viscous{}, coulomb{};
    model::Inertial inertial;
    std::array<bool, kJointCount> carries{};  // this joint moves that part
    dBodyID body{nullptr};
    dJointID joint{nullptr};
    dJointID motor{nullptr};
  };

  void createPart(dWorldID world,
                  const model::RavenModel& raven,
                  const std::vector<Carrier>& carriers,
                  const std::vector<Pose>& X_WL,
                  std::size_t j);
  void createHinge(dWorldID world, Part* part, const Vector3& anchor, const Vector3& axis);
  void createSlider(dWorldID world, Part* part, const Vector3& axis);
  void findCarried() noexcept;
  dBodyID parentBody(const Part& part) const noexcept;
  Pose linkPose(int part) const noexcept;
  Pose jointFrame(const Part& part) const noexcept;
  double position(const Part& part, double last) const noexcept;
  double rate(const Part& part) const noexcept;
  double biasAcceleration(const Part& part) const noexcept;  // part of the joint's acceleration at constant velocities
  void setMotor(const Part& part, double position, double rate) const noexcept;

  Arm arm_;
  double d4_;
  double stop_erp_;
  std::array<Part, kJointCount> parts_{};
  JointArray urdf_q_{}, urdf_dq_{};  // in URDF coordinates
  JointArray q_{}, dq_{};            // in robot coordinates
};

}  // namespace raven2_trainer::physics
