#include "render/tip_trails.h"

#include <algorithm>

#include "raven2_trainer/core/ticks.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"

namespace raven2_trainer::render {

namespace {

/** [1 ms] Over a longer gap between frames nobody knows how the tip went. Frames at 4 Hz still are within it. */
constexpr Tick kLongestGap = 250;
constexpr Tick kLastTick = Tick{1} << 60;  // damaged logs hold any number; keeps the sums below from overflowing

Tick ticksOf(double seconds) {
  return std::max<Tick>(1, toTicks(seconds));
}

}  // namespace

TipTrails::TipTrails(const ArmGeometry& geometry, const PerArm<Pose>& X_WB, const TrailConfig& config)
    : geometry_(geometry), X_WB_(X_WB), step_(ticksOf(config.step)), duration_(ticksOf(config.duration)) {}

TipTrails::Past TipTrails::stateOf(const Snapshot& snapshot, Arm arm) const {
  const ArmState& state = at(snapshot.model.arms, arm);
  const Pose& X_WB = at(X_WB_, arm);
  Past now;
  now.tip_W = X_WB * toEigen(state.p_BT);
  const Mode mode = snapshot.model.mode;
  if (traitsOf(mode).hands) now.wanted.by = Trail::kUser;
  if (traitsOf(mode).follows_plan && snapshot.model.planning.arm == arm) now.wanted.by = Trail::kPlan;
  now.wanted.p_W = now.tip_W;
  if (now.wanted.by != Trail::kTrack) now.wanted.p_W = X_WB * kinematics::forward(geometry_, arm, state.q_d).p;
  return now;
}

void TipTrails::leave(Tick tick, Trail trail, const Vector3& p_W) {
  if (p_W.allFinite()) marks_.push_back({tick, trail, p_W});
}

/** At every multiple of the step after `first`, up to `last`. */
void TipTrails::markBetween(const Past& past, const Past& now, Tick first, Tick last) {
  for (Tick tick = (first / step_ + 1) * step_; tick <= last; tick += step_) {
    const double share = static_cast<double>(tick - first) / static_cast<double>(last - first);
    leave(tick, Trail::kTrack, past.tip_W + share * (now.tip_W - past.tip_W));
    if (now.wanted.by == Trail::kTrack || now.wanted.by != past.wanted.by) continue;
    leave(tick, now.wanted.by, past.wanted.p_W + share * (now.wanted.p_W - past.wanted.p_W));
  }
}

void TipTrails::follow(const Snapshot& snapshot) {
  const Tick tick = snapshot.model.tick;
  if (tick == last_ || tick < 0 || tick > kLastTick) return;
  if (tick < last_) marks_.clear();
  const bool goes_on = last_ >= 0 && tick > last_ && tick - last_ <= kLongestGap;
  for (const Arm arm : kArms) {
    const Past now = stateOf(snapshot, arm);
    if (goes_on) markBetween(at(past_, arm), now, last_, tick);
    at(past_, arm) = now;
  }
  last_ = tick;
  const auto is_old = [&](const Mark& mark) { return mark.tick <= tick - duration_; };
  marks_.erase(std::remove_if(marks_.begin(), marks_.end(), is_old), marks_.end());  // the arms' marks alternate
}

std::vector<Vector3> TipTrails::marks(Trail trail) const {
  std::vector<Vector3> points;
  for (const Mark& mark : marks_) {
    if (mark.trail == trail) points.push_back(mark.p_W);
  }
  return points;
}

}  // namespace raven2_trainer::render
