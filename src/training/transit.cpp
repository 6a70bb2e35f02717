#include "raven2_trainer/training/transit.h"

#include <algorithm>

#include "raven2_trainer/core/vec3.h"
#include "raven2_trainer/training/motion_metrics.h"

namespace raven2_trainer::training {

namespace {

double distanceToSegment(const Vec3& a, const Vec3& b, const Vec3& point) {
  const Vector3 along = toEigen(b) - toEigen(a), offset = toEigen(point) - toEigen(a);
  const double square = along.squaredNorm();
  const double part = square > 0.0 ? std::clamp(offset.dot(along) / square, 0.0, 1.0) : 0.0;
  return (offset - part * along).norm();
}

void describeDistances(std::vector<double> distances, Economy* economy) {
  if (distances.empty()) return;
  double sum = 0.0;
  for (const double d : distances)
    sum += d;
  economy->off_path = sum / static_cast<double>(distances.size());
  const std::size_t rank = (distances.size() * 95 + 99) / 100 - 1;  // nearest rank
  std::nth_element(distances.begin(), distances.begin() + static_cast<std::ptrdiff_t>(rank), distances.end());
  economy->off_path_p95 = distances[rank];
}

bool isWayOfATip(const Predicate& predicate) {
  switch (predicate.kind) {
    case PredicateKind::kHeld:
    case PredicateKind::kHeldAlone:
    case PredicateKind::kTipNear:
    case PredicateKind::kTipInside:
    case PredicateKind::kTipOutside:
      return predicate.negated == 0 && (predicate.hand == Hand::kGold || predicate.hand == Hand::kGreen);
    default:
      return false;
  }
}

/** The arm that a step waits for, in a track that is about no object; nothing: none, or there is no such step. */
std::optional<Arm> goingArm(const ExerciseTrack& track, std::size_t step) {
  if (track.object != kNobody || step >= track.steps.size()) return std::nullopt;
  const std::vector<Predicate>& until = track.steps[step].until;
  const auto found = std::find_if(until.begin(), until.end(), isWayOfATip);
  if (found == until.end()) return std::nullopt;
  return found->hand == Hand::kGold ? Arm::kGold : Arm::kGreen;
}

}  // namespace

double lengthOf(const std::vector<Vec3>& way) noexcept {
  double length = 0.0;
  for (std::size_t k = 1; k < way.size(); ++k)
    length += distance(way[k], way[k - 1]);
  return length;
}

double distanceTo(const std::vector<Vec3>& way, const Vec3& point) noexcept {
  double least = distance(way.front(), point);
  for (std::size_t k = 1; k < way.size(); ++k)
    least = std::min(least, distanceToSegment(way[k - 1], way[k], point));
  return least;
}

Economy compare(const std::vector<Transit>& transits, const WayPlanner& plan) {
  Economy economy;
  double planned = 0.0, real = 0.0;
  std::vector<double> distances;
  for (const Transit& transit : transits) {
    ++economy.transits;
    const std::vector<Vec3> way = plan ? plan(transit) : std::vector<Vec3>{};
    if (way.empty()) continue;
    ++economy.planned;
    planned += lengthOf(way);
    real += lengthOf(transit.way_W) - transit.skipped;
    for (const Vec3& place : transit.way_W)
      distances.push_back(distanceTo(way, place));
  }
  // A plan that is longer than the path of the hand is not the shortest one.
  if (real > 0.0) economy.ratio = std::min(1.0, planned / real);
  describeDistances(std::move(distances), &economy);
  return economy;
}

TransitCollector::TransitCollector(const PerArm<Pose>& X_WB, const std::vector<ExerciseTrack>& tracks)
    : X_WB_(X_WB), tracks_(tracks), reaching_(tracks.size()) {
  for (std::size_t track = 0; track < tracks_.size(); ++track) {
    if (tracks_[track].after == kNobody) beginStep(track, 0);
  }
}

void TransitCollector::begin(const ExerciseState& exercise) {
  for (const std::uint8_t body : exercise.bodies) {
    if ((body & kHeldByGold) != 0) carry(Arm::kGold);
    if ((body & kHeldByGreen) != 0) carry(Arm::kGreen);
  }
}

void TransitCollector::carry(Arm arm) {
  at(carrying_, arm) = {};
  at(carrying_, arm).arm = arm;
  at(carrying_, arm).is_open = true;
}

void TransitCollector::add(const ModelState& model) {
  const bool is_press = model.pedal != 0 && is_up_;
  const bool follows = model.tick == last_ + 1 && !is_press;
  followTips(model);
  is_up_ = model.pedal == 0;
  last_ = model.tick;
  for (Going& going : carrying_)
    sample(model, follows, &going);
  for (Going& going : reaching_)
    sample(model, follows, &going);
}

/** With the pedal up the tools do not move: the model's return to its robot is no motion of the hand. */
void TransitCollector::followTips(const ModelState& model) {
  if (model.pedal == 0 && last_ >= 0) return;
  for (const Arm arm : kArms)
    at(tip_W_, arm) = toArray(at(X_WB_, arm) * toEigen(at(model.arms, arm).p_BT));
}

/** A gap in time begins a new sample, as a press does; what was gathered before it is too short for one. */
void TransitCollector::sample(const ModelState& model, bool follows, Going* going) const {
  if (!going->is_open) return;
  if (!follows) {
    going->sum_W = {};
    going->ticks = 0;
    going->is_cut = true;
  }
  for (std::size_t i = 0; i < 3; ++i)
    going->sum_W[i] += at(tip_W_, going->arm)[i] / kSampleTicks;
  if (++going->ticks < kSampleTicks) return;
  going->samples.push_back({going->sum_W, {model.arms[0].q, model.arms[1].q}, !going->is_cut});
  going->sum_W = {};
  going->ticks = 0;
  going->is_cut = false;
}

void TransitCollector::add(const ExerciseEvent& event) {
  if (event.kind == ExerciseEventKind::kStepDone) endStep(event.track, event.step);
  if (event.arm != Hand::kGold && event.arm != Hand::kGreen) return;
  const Arm arm = event.arm == Hand::kGold ? Arm::kGold : Arm::kGreen;
  if (event.kind == ExerciseEventKind::kReleased) close(&at(carrying_, arm));
  if (event.kind == ExerciseEventKind::kHeld) carry(arm);
}

void TransitCollector::beginStep(std::size_t track, std::size_t step) {
  const std::optional<Arm> arm = goingArm(tracks_[track], step);
  reaching_[track] = {};
  if (!arm) return;
  reaching_[track].arm = *arm;
  reaching_[track].is_open = true;
}

void TransitCollector::endStep(std::size_t track, std::size_t step) {
  if (track >= tracks_.size()) return;
  close(&reaching_[track]);
  beginStep(track, step + 1);
  if (step + 1 < tracks_[track].steps.size()) return;
  for (std::size_t later = 0; later < tracks_.size(); ++later) {
    if (tracks_[later].after == track) beginStep(later, 0);
  }
}

void TransitCollector::close(Going* going) {
  const Going gone = std::move(*going);
  *going = {};
  if (gone.samples.empty()) return;
  const Vec3 first = gone.samples.front().tip_W, last = gone.samples.back().tip_W;
  const auto is_clear_of = [](const Vec3& place) {
    return [=](const Sample& sample) { return distance(sample.tip_W, place) > kTransitEnd; };
  };
  const auto begin = std::find_if(gone.samples.begin(), gone.samples.end(), is_clear_of(first));
  const auto end = std::find_if(gone.samples.rbegin(), gone.samples.rend(), is_clear_of(last)).base();
  if (end - begin < 2 || distance(begin->tip_W, (end - 1)->tip_W) < kLeastTransit) return;
  Transit transit{gone.arm, at(begin->q, gone.arm), at(begin->q, otherArm(gone.arm)), {}, 0.0};
  for (auto sample = begin; sample != end; ++sample) {
    const bool is_jump = sample != begin && !sample->follows;
    if (is_jump) transit.skipped += distance(transit.way_W.back(), sample->tip_W);
    transit.way_W.push_back(sample->tip_W);
  }
  transits_.push_back(std::move(transit));
}

}  // namespace raven2_trainer::training
