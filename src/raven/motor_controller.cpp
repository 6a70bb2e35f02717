#include "raven/motor_controller.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "raven2_trainer/raven/board_channels.h"

namespace raven2_trainer::raven {

MotorController::MotorController(Arm arm, const VirtualRavenConfig& config) noexcept : arm_(arm), axes_(config.axes) {
  if (arm == Arm::kGreen) axes_[kInsertion].kd = config.green_insertion_kd;
}

JointArray MotorController::torque(const JointArray& desired,
                                   const JointArray& motor,
                                   const JointArray& velocity) noexcept {
  JointArray tau;
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const double error = desired[j] - motor[j];
    integral_[j] += error * kTickSeconds;
    tau[j] = axes_[j].kp * error - axes_[j].kd * velocity[j] + axes_[j].ki * integral_[j];
  }
  return tau;
}

DacArray MotorController::toDac(const JointArray& torque) const noexcept {
  DacArray dac{};
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const double amps = torque[j] / (torqueSign(arm_, j) * axes_[j].torque_per_amp);
    const double counts = amps * axes_[j].counts_per_amp;
    if (std::isfinite(counts)) dac[j] = static_cast<std::int32_t>(std::clamp(counts, -32768.0, 32767.0));
  }
  return dac;
}

bool overdriveDetect(const VirtualRavenConfig& config, bool clips, DacArray* dac) noexcept {
  bool stop = false;
  for (std::size_t j = 0; j < kGrasp2; ++j) {
    std::int32_t& command = (*dac)[j];
    const std::int32_t clip = config.axes[j].dac_clip;
    if (std::abs(command) > config.max_inst_dac) {
      command = 0;
      stop = true;
    } else if (clips) {
      command = std::clamp(command, -clip, clip);
    }
  }
  return stop;
}

}  // namespace raven2_trainer::raven
