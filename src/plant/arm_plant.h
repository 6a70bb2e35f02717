#pragma once

#include <array>
#include <cstdint>

#include "plant/arm_dynamics.h"
#include "plant/friction_solver.h"
#include "raven2_trainer/raven/cable_coupling.h"
#include "raven2_trainer/raven/usb_packets.h"
#include "raven2_trainer/raven/virtual_raven_config.h"

namespace raven2_trainer::plant {

/**
 * Amplifiers, motors, cables, links and encoders of one arm: DAC to encoder. All motor torques and angles are those of
 * the motor shaft. With rigid cables joint = A^-1 motor, so the equations are those of the seven motors. With elastic
 * ones motors and joints are fourteen positions, and a spring and a damper act on the stretch motor - A joint of each
 * cable. Semi-implicit Euler with sub-steps; springs, dampers and viscous friction implicit, so that no stiffness is
 * too high for the step. Real-time safe after construction.
 */
class ArmPlant {
 public:
  ArmPlant(const model::RavenModel& raven, Arm arm, const VirtualRavenConfig& config);

  /** 1 ms. @param[in] dac [counts] by board channel; 0 where the amplifiers are off. */
  void step(const std::array<std::int16_t, raven::kChannels>& dac, bool brakes_on) noexcept;

  /** Puts the motors there, cables unstretched, and forgets which axes stuck. [rad], [rad/s] */
  void setMotors(const Vector7& position, const Vector7& rate) noexcept;

  /** Moves the motors only; rigid cables take the links along, elastic ones are stretched. [rad], [rad/s] */
  void leadMotors(const Vector7& position, const Vector7& rate) noexcept;

  /** [counts] as the board counts, by channel. */
  std::array<std::int32_t, raven::kChannels> encoders() const noexcept;

  const Vector7& jointPositions() const noexcept { return q_; }
  const Vector7& jointVelocities() const noexcept { return dq_; }
  const Vector7& motorPositions() const noexcept { return motor_; }
  const Vector7& motorRates() const noexcept { return motor_rate_; }
  /** [rad] of the motor shaft by which each cable is longer than tight; zero if cables are rigid. */
  Vector7 cableStretch() const noexcept { return motor_ - coupling_ * q_; }
  /** [Nm/rad] at the motor shaft. */
  const Vector7& cableStiffness() const noexcept { return cable_stiffness_; }
  /** [J] of motors, links and cables. */
  double energy() const noexcept;
  ArmDynamics& dynamics() noexcept { return dynamics_; }

  static constexpr int kSubSteps = 4;

 private:
  void readAxes(const VirtualRavenConfig& config);
  Vector7 motorTorques(const std::array<std::int16_t, raven::kChannels>& dac) const noexcept;
  void subStep(const Vector7& torque, const FrictionSolver::Vector& friction) noexcept;
  void solveRigid(const Vector7& torque) noexcept;
  void coupleLinks() noexcept;
  void solveElastic(const Vector7& torque) noexcept;
  std::size_t findStops() noexcept;
  void moveOn(const FrictionSolver::Vector& rate) noexcept;

  Arm arm_;
  bool elastic_;
  bool has_link_friction_{false};
  double amplifier_limit_;                                       // [counts]
  Vector7 amplifier_offset_, torque_per_count_, torque_offset_;  // [counts], [Nm/count], [Nm]
  Matrix7 coupling_, inverse_;                                   // motor = coupling * joint
  ArmDynamics dynamics_;
  FrictionSolver friction_solver_;
  Vector7 armature_, motor_damping_, link_damping_;  // [kg m2], [Nms/rad] at the shaft; [Nms/rad; Ns/m] at the joint
  Matrix7 damping_;  // [kg m2] sub-step times the joints' viscous friction, at the motor shafts
  Vector7 cable_stiffness_, cable_damping_;          // [Nm/rad, Nms/rad] at the shaft
  FrictionSolver::Vector coulomb_, brake_;           // [Nm] motors, [Nm; N] joints
  Vector7 stop_low_, stop_high_;
  FrictionSolver::Stops stops_;

  // of one sub-step: rates without dry friction, and what impulses add to them
  FrictionSolver::Vector free_;
  FrictionSolver::Matrix admittance_{FrictionSolver::Matrix::Zero()};

  Vector7 motor_, motor_rate_;  // [rad, rad/s]
  Vector7 q_, dq_;              // [rad; m], [rad/s; m/s]
};

}  // namespace raven2_trainer::plant
