#include "raven/quick_homing.h"

#include <algorithm>
#include <cmath>

#include "raven2_trainer/core/ticks.h"

namespace raven2_trainer::raven {
namespace {

/** Cycles at home before READY, for the integral of the tool joints; ours (the robot waits 200 before phase 2). */
constexpr std::int64_t kSettleCycles = 500;

}  // namespace

QuickHoming::QuickHoming(const JointArray& home, double time) noexcept
    : home_(home), length_(std::max<std::int64_t>(1, toTicks(time))) {}

void QuickHoming::hold(const PerArm<JointArray>& q) noexcept {
  if (done_) return;
  elapsed_ = 0;
  start_ = q;
}

void QuickHoming::tick() noexcept {
  if (!done_ && ++elapsed_ >= length_ + kSettleCycles) done_ = true;
}

JointArray QuickHoming::desired(Arm arm) const noexcept {
  const double s = std::min(1.0, static_cast<double>(elapsed_) / static_cast<double>(length_));
  const double blend = 0.5 * (1.0 - std::cos(kPi * s));
  JointArray q;
  for (std::size_t j = 0; j < kJointCount; ++j)
    q[j] = at(start_, arm)[j] + blend * (home_[j] - at(start_, arm)[j]);
  return q;
}

}  // namespace raven2_trainer::raven
