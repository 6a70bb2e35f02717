#pragma once

#include <array>
#include <cstdint>

#include "plant/arm_dynamics.h"
#include "plant/friction_solver.h"
#include "raven2_trainer/core/config.h"
#include "raven2_trainer/raven/cable_coupling.h"
#include "raven2_trainer/raven/usb_packets.h"

namespace raven2_trainer::plant {

/**
 * Motors, cables, links and encoders of one arm. Cables are tight in this version: joint = A^-1 motor, so the state is
 * that of the seven motors and the equations are written there. Semi-implicit Euler with sub-steps, viscous friction
 * implicit. Real-time safe after construction.
 */
class ArmPlant {
 public:
  ArmPlant(const model::RavenModel& raven, Arm arm, const VirtualRavenConfig& config);

  /** 1 ms. @param[in] dac [counts] by board channel; 0 where the amplifiers are off. */
  void step(const std::array<std::int16_t, raven::kChannels>& dac, bool brakes_on) noexcept;

  /** [counts] as the board counts, by channel. */
  std::array<std::int32_t, raven::kChannels> encoders() const noexcept;

  const Vector7& jointPositions() const noexcept { return q_; }
  const Vector7& jointVelocities() const noexcept { return dq_; }
  ArmDynamics& dynamics() noexcept { return dynamics_; }

  static constexpr int kSubSteps = 4;

 private:
  Vector7 motorTorques(const std::array<std::int16_t, raven::kChannels>& dac) const noexcept;
  void subStep(const Vector7& torque, const Vector7& friction) noexcept;
  std::size_t findStops(const Vector7& rate) noexcept;

  Arm arm_;
  std::array<MotorAxis, kJointCount> axes_;
  Matrix7 coupling_, inverse_;  // motor = coupling * joint
  ArmDynamics dynamics_;
  FrictionSolver friction_;
  Matrix7 armature_, damping_;  // motor coordinates
  Vector7 coulomb_, brake_;     // [Nm] at the motor shaft
  Vector7 stop_low_, stop_high_;
  std::array<FrictionSolver::Stop, kJointCount> stops_;

  Vector7 motor_, motor_rate_;  // [rad, rad/s]
  Vector7 q_, dq_;              // [rad; m], [rad/s; m/s]
};

}  // namespace raven2_trainer::plant
