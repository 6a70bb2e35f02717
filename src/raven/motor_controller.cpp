#include "raven/motor_controller.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "raven2_trainer/raven/board_channels.h"

namespace raven2_trainer::raven {
namespace {

constexpr int kHardCount = 10;  // overdrive_detect.cpp:71-122

}  // namespace

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
    tau[j] = scale_[j] * (axes_[j].kp * error - axes_[j].kd * velocity[j] + axes_[j].ki * integral_[j]);
  }
  return tau;
}

DacArray MotorController::toDac(const JointArray& torque) const noexcept {
  DacArray dac{};
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const double amps = torque[j] / (torqueSign(arm_, j) * axes_[j].torque_per_amp);
    const double counts = amps * axes_[j].counts_per_amp;
    if (std::isfinite(counts)) dac[j] = static_cast<std::int32_t>(std::clamp(counts, -32767.0, 32767.0));
  }
  return dac;
}

OverdriveCheck::OverdriveCheck(const VirtualRavenConfig& config) noexcept
    : max_inst_dac_(config.max_inst_dac), policy_(config.overdrive_policy) {
  for (std::size_t j = 0; j < kJointCount; ++j)
    clip_[j] = config.axes[j].dac_clip;
}

bool OverdriveCheck::check(bool clips, DacArray* dac) noexcept {
  bool stop = false;
  for (std::size_t j = 0; j < kGrasp2; ++j) {
    std::int32_t& command = (*dac)[j];
    if (std::abs(std::int64_t{command}) > max_inst_dac_) {
      command = 0;
      count_ = 0;
      stop = true;
    } else if (clips && std::abs(std::int64_t{command}) > clip_[j]) {
      stop = regulate(j, &command) || stop;
    }
  }
  return stop;
}

bool OverdriveCheck::regulate(std::size_t joint, std::int32_t* command) noexcept {
  if (policy_ == OverdrivePolicy::kSoft) *command = std::clamp(*command, -clip_[joint], clip_[joint]);
  if (policy_ != OverdrivePolicy::kHard) return false;
  const bool stop = count_ > kHardCount;
  count_ = stop ? 1 : count_ + 1;
  if (stop) *command = 0;
  return stop;
}

}  // namespace raven2_trainer::raven
