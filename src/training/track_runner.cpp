#include "training/track_runner.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "raven2_trainer/core/ticks.h"

namespace raven2_trainer::training {
namespace {

/** Bits of the arms that a step's object is to be held by; 0 if it does not say. */
std::uint8_t armsOf(const ExerciseStep& step, std::uint8_t object) {
  std::uint8_t arms = 0;
  for (const Predicate& p : step.until) {
    const bool is_hold = p.kind == PredicateKind::kHeld || p.kind == PredicateKind::kHeldAlone;
    if (!is_hold || p.negated != 0 || p.object != object) continue;
    arms = static_cast<std::uint8_t>(arms | (p.hand == Hand::kGold ? 1U : p.hand == Hand::kGreen ? 2U : 3U));
  }
  return arms;
}

}  // namespace

TrackRunner::TrackRunner(const ExerciseTrack& track, const SceneSenses& senses)
    : senses_(senses), object_(track.object), after_(track.after) {
  std::uint8_t arms = 0;
  for (const ExerciseStep& step : track.steps) {
    Step s;
    s.until = step.until;
    s.dwell = std::max<std::int64_t>(toTicks(step.dwell), 1);
    arms = static_cast<std::uint8_t>(arms | armsOf(step, track.object));
    s.arms = arms == 0 ? kBothArms : arms;
    for (const Predicate& p : step.until) {
      if (p.kind != PredicateKind::kAlong) continue;
      s.wire = p.place;
      s.led = p.object;
    }
    steps_.push_back(s);
  }
}

void TrackRunner::restart() noexcept {
  done_ = 0;
  along_ = 0.0;
  fresh_ = true;
  had_turn_ = false;
  forget();
}

void TrackRunner::forget() noexcept {
  held_ticks_ = 0;
  early_ticks_ = 0;
  early_armed_ = false;
}

bool TrackRunner::holds(const Step& step, double along) const noexcept {
  return std::all_of(step.until.begin(), step.until.end(), [&](const Predicate& p) { return senses_.holds(p, along); });
}

/** An object that leaves the wire and comes back elsewhere is not followed until it is where it left. */
void TrackRunner::follow() noexcept {
  const Step& step = steps_[done_];
  if (step.wire == kNobody) return;
  const double now = senses_.threaded(step.led, step.wire);
  if (fresh_) last_along_ = std::max(now, 0.0);
  fresh_ = false;
  if (now < 0.0 || std::abs(now - last_along_) > kLeap) return;
  last_along_ = now;
  const double length = senses_.wireLength(step.wire);
  if (length > 0.0) along_ = std::max(along_, std::min(now / length, 1.0));
}

bool TrackRunner::advance() noexcept {
  if (isDone()) return false;
  follow();
  const Step& step = steps_[done_];
  held_ticks_ = holds(step, along_) ? held_ticks_ + 1 : 0;
  if (held_ticks_ < step.dwell) return false;
  ++done_;
  held_ticks_ = 0;
  along_ = 0.0;
  fresh_ = true;
  early_ticks_ = 0;
  early_armed_ = false;
  return true;
}

bool TrackRunner::isOutOfOrder(bool its_turn) noexcept {
  if (isDone() || (its_turn && done_ + 1U == steps_.size())) return false;
  const Step& early = its_turn ? steps_.back() : steps_.front();
  if (its_turn != had_turn_) {  // what was seen so far is about another step
    early_armed_ = false;
    early_ticks_ = 0;
  }
  had_turn_ = its_turn;
  if (early.wire != kNobody) return false;  // leading along a wire is another step
  if (!holds(early, 0.0)) {
    early_armed_ = true;
    early_ticks_ = 0;
    return false;
  }
  // what the running step asks for too may well look like the last one for a while
  if (!early_armed_ || (its_turn && holds(steps_[done_], along_))) return false;
  if (++early_ticks_ < early.dwell) return false;
  early_armed_ = false;
  return true;
}

bool TrackRunner::isLetGoWell(std::uint8_t object) const noexcept {
  const std::size_t first = done_ > 0 ? done_ - 1U : 0U, end = std::min<std::size_t>(done_ + 1U, steps_.size());
  for (std::size_t i = first; i < end; ++i) {
    const std::vector<Predicate>& until = steps_[i].until;
    const bool is_wanted = std::any_of(until.begin(), until.end(), [&](const Predicate& p) {
      return p.kind == PredicateKind::kUntouched && p.negated == 0 && p.object == object;
    });
    const bool is_there = std::all_of(until.begin(), until.end(), [&](const Predicate& p) {
      const bool is_past = p.kind == PredicateKind::kAlong && i < done_;
      return is_past || p.kind == PredicateKind::kResting || senses_.holds(p, along_);  // it may still rock
    });
    if (is_wanted && is_there) return true;
  }
  return false;
}

double TrackRunner::targetDistance() const noexcept {
  if (isDone()) return std::numeric_limits<double>::infinity();
  double least = std::numeric_limits<double>::infinity();
  for (const Predicate& p : steps_[done_].until)
    least = std::min(least, senses_.distanceTo(p));
  if (std::isfinite(least) || object_ == kNobody) return least;
  const Vector3& middle = senses_.object(object_).p;
  return std::min((senses_.tools()[0].p - middle).norm(), (senses_.tools()[1].p - middle).norm());
}

}  // namespace raven2_trainer::training
