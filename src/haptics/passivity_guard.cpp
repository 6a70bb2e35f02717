#include "raven2_trainer/haptics/passivity_guard.h"

#include <algorithm>
#include <cmath>

#include "raven2_trainer/core/ticks.h"
#include "raven2_trainer/core/types.h"

namespace raven2_trainer::haptics {

using Eigen::Vector3d;

namespace {

// Motion comes in whole micrometres of the tip and in packets that come in bunches: squared tick by tick, both would
// count as speed. Over a block the mean speed never says more than there was (Cauchy and Schwarz); 16 ms are short
// against the periods of 80 ms and more in which a hand can swing.
constexpr int kBlockTicks = 16;

constexpr double kReserve = 0.5;    ///< of the budget: below it the force fades
constexpr double kYielding = 0.75;  ///< of the budget: below it what yields fades, to nothing at kReserve

}  // namespace

PassivityGuard::PassivityGuard(const PassivityConfig& config) noexcept
    : config_(config),
      delays_(static_cast<std::size_t>(std::clamp<std::int64_t>(toTicks(config.max_delay), 0, kMaxGuardDelay)) + 1),
      rest_ticks_(static_cast<std::int64_t>(delays_) + toTicks(config.rest)),
      allowance_(config.budget) {}

void PassivityGuard::observe(const Vector3d& hand) noexcept {
  if (!std::isfinite(hand.squaredNorm())) return;
  const Vector3d step = has_position_ ? Vector3d(hand - position_) : Vector3d::Zero();
  position_ = hand;
  has_position_ = true;
  if (resting_) return;
  addAllowance(hand);
  addWork(step, hand - anchor_);
}

void PassivityGuard::addWork(const Vector3d& step, const Vector3d& from_anchor) noexcept {
  const double* x = &forces_[0][newest_];
  const double* y = &forces_[1][newest_];
  const double* z = &forces_[2][newest_];
  const double least = allowance_ - config_.bank;
  double largest = -1e300;
  for (std::size_t d = 0; d < delays_; ++d) {
    const double returned = x[d] * from_anchor.x() + y[d] * from_anchor.y() + z[d] * from_anchor.z();
    const double sum = work_[d] + x[d] * step.x() + y[d] * step.y() + z[d] * step.z();
    work_[d] = std::max(sum, least + std::min(0.0, returned));
    largest = std::max(largest, work_[d] - std::max(0.0, returned));
  }
  energy_ = largest;
}

void PassivityGuard::addAllowance(const Vector3d& hand) noexcept {
  if (++block_ticks_ < kBlockTicks) return;
  allowance_ += config_.hand_damping * (hand - block_).squaredNorm() / (kBlockTicks * kTickSeconds);
  block_ = hand;
  block_ticks_ = 0;
}

void PassivityGuard::given(const Vector3d& force, bool is_asked) noexcept {
  const bool acts = is_asked || force != Vector3d::Zero();
  if (resting_ && !acts) return;
  if (resting_) {
    resting_ = false;
    anchor_ = block_ = position_;
  }
  newest_ = newest_ == 0 ? kSlots - 1 : newest_ - 1;
  for (std::size_t axis = 0; axis < 3; ++axis)
    forces_[axis][newest_] = forces_[axis][newest_ + kSlots] = force[static_cast<Eigen::Index>(axis)];
  silence_ = acts ? 0 : silence_ + 1;
  if (silence_ >= rest_ticks_) startAgain();
}

void PassivityGuard::startAgain() noexcept {
  for (auto& axis : forces_)
    axis.fill(0.0);
  work_.fill(0.0);
  energy_ = 0.0;
  allowance_ = config_.budget;
  resting_ = true;
  silence_ = 0;
  block_ticks_ = 0;
}

void PassivityGuard::forget() noexcept {
  resting_ = false;
  silence_ = 0;
}

double PassivityGuard::gain() const noexcept {
  if (!config_.enabled) return 1.0;
  return std::clamp((allowance_ - energy_) / (kReserve * config_.budget), 0.0, 1.0);
}

double PassivityGuard::yieldingGain() const noexcept {
  if (!config_.enabled) return 1.0;
  const double left = (allowance_ - energy_) / config_.budget;
  return std::clamp((left - kReserve) / (kYielding - kReserve), 0.0, 1.0);
}

Vector3d shortened(const Vector3d& force, double gain, double floor) noexcept {
  const double length = force.norm();
  const double wanted = std::max(gain * length, std::min(length, floor));
  return length > wanted ? Vector3d(force * (wanted / length)) : force;
}

}  // namespace raven2_trainer::haptics
