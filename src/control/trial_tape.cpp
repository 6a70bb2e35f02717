#include "raven2_trainer/control/trial_tape.h"

#include <algorithm>
#include <cmath>

#include "raven2_trainer/control/path_follower.h"

namespace raven2_trainer::control {
namespace {

// As long as an execution takes to come up to speed. A step of 5 mm, the lag at top speed, becomes 0.1 m/s.
constexpr double kJoinTicks = 100.0;

void addScaled(const PerArm<JointArray>& offset, double share, PerArm<JointArray>* q) noexcept {
  for (const Arm arm : kArms) {
    for (std::size_t j = 0; j < kJointCount; ++j)
      at(*q, arm)[j] += share * at(offset, arm)[j];
  }
}

PerArm<JointArray> difference(const PerArm<JointArray>& a, const PerArm<JointArray>& b) noexcept {
  PerArm<JointArray> delta = a;
  addScaled(b, -1.0, &delta);
  return delta;
}

}  // namespace

void TrialTape::clear() noexcept {
  size_ = since_mark_ = 0;
  is_marked_ = false;
  offset_ = {};
}

bool TrialTape::add(const TrialSample& sample) noexcept {
  if (isFull()) return false;
  if (is_marked_ && size_ > 0) {
    offset_ = difference(samples_[size_ - 1].q_d, sample.q_d);
    since_mark_ = 0;
  }
  is_marked_ = false;
  TrialSample& kept = samples_[size_++];
  kept = sample;
  addScaled(offset_, 1.0 - quinticBlend(static_cast<double>(since_mark_++) / kJoinTicks), &kept.q_d);
  return true;
}

TrialSample TrialTape::at(double ticks) const noexcept {
  const double last = static_cast<double>(size_ - 1);
  const double place = std::clamp(ticks, 0.0, last);
  const auto before = static_cast<std::size_t>(place);
  const double share = place - std::floor(place);
  TrialSample sample = samples_[before];
  if (share <= 0.0) return sample;
  const TrialSample& next = samples_[before + 1];
  addScaled(difference(next.q_d, sample.q_d), share, &sample.q_d);
  for (const Arm arm : kArms) {
    Vec3& tip = raven2_trainer::at(sample.tip_B, arm);
    for (std::size_t i = 0; i < tip.size(); ++i)
      tip[i] += share * (raven2_trainer::at(next.tip_B, arm)[i] - tip[i]);
  }
  return sample;
}

void TapeExecution::start(const TrialTape& tape, const PerArm<JointArray>& from) noexcept {
  tape_ = &tape;
  duration_ = static_cast<double>(tape.size() - 1);
  desired_ = tape.at(0.0);
  goal_ = tape.at(duration_).q_d;
  offset_ = difference(from, desired_.q_d);
  desired_.q_d = from;
  elapsed_ = waiting_ = resting_ = 0;
  rate_ = kFullRate;
}

const TrialSample& TapeExecution::tick(bool may_move) noexcept {
  if (!may_move) {
    ++waiting_;
    rate_ = 0;
    return desired_;
  }
  waiting_ = 0;
  if (isOver()) ++resting_;
  rate_ = std::min(kFullRate, rate_ + 1);
  elapsed_ += rate_;
  desired_ = tape_->at(tapeTime());
  addScaled(offset_, 1.0 - quinticBlend(held() / hold_ticks_), &desired_.q_d);
  return desired_;
}

double TapeExecution::progress() const noexcept {
  return isOver() ? 1.0 : std::max(0.0, tapeTime() / duration_);
}

}  // namespace raven2_trainer::control
