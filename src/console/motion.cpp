#include "motion.h"

#include <algorithm>
#include <cmath>

#include "raven2_trainer/control/axis_map.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"

namespace raven2_trainer::console {

Vector3 worldToItp(const Vector3& v_W) noexcept {
  return {v_W.x(), -v_W.y(), -v_W.z()};
}

double minimumJerk(double s) noexcept {
  const double x = std::clamp(s, 0.0, 1.0);
  return x * x * x * (10.0 + x * (-15.0 + 6.0 * x));
}

Vector3 homeTip(const ArmsConfig& arms, Arm arm) noexcept {
  return kinematics::forward(arms.geometry, arm, arms.geometry.home).p;
}

Vector3 fromHome(const ArmsConfig& arms, Arm arm, const Vector3& p_W) noexcept {
  const Vector3 from_rcm_I = worldToItp(p_W - toEigen(at(arms.rcm_W, arm)));
  return from_rcm_I - control::itpToBase(arm).transpose() * homeTip(arms, arm);
}

Tremor::Tremor(const ConsoleConfig& config, Random* random)
    : wave_amplitude_(config.tremor_amplitude / static_cast<double>(kWaves)) {
  for (auto& axis : waves_) {
    for (Wave& wave : axis) {
      wave.frequency = random->uniform(config.tremor_low, config.tremor_high);
      wave.phase = random->uniform(0.0, 2.0 * kPi);
    }
  }
}

Vector3 Tremor::at(double t) const noexcept {
  Vector3 sum = Vector3::Zero();
  for (int axis = 0; axis < 3; ++axis) {
    for (const Wave& wave : waves_[static_cast<std::size_t>(axis)]) {
      sum[axis] += wave_amplitude_ * std::sin(2.0 * kPi * wave.frequency * t + wave.phase);
    }
  }
  return sum;
}

}  // namespace raven2_trainer::console
