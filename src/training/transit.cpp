#include "raven2_trainer/training/transit.h"

#include <algorithm>
#include <cmath>

namespace raven2_trainer::training {

namespace {

constexpr std::int32_t kSampleTicks = 10;  // [1 ms] as in motion_metrics.h

double distance(const Vec3& a, const Vec3& b) {
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

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
    real += lengthOf(transit.way_W);
    for (const Vec3& place : transit.way_W)
      distances.push_back(distanceTo(way, place));
  }
  // A plan that is longer than the way that was found by hand is not the shortest one.
  if (real > 0.0) economy.ratio = std::min(1.0, planned / real);
  describeDistances(std::move(distances), &economy);
  return economy;
}

void TransitCollector::add(const ModelState& model) {
  for (const Arm arm : kArms) {
    Carrying& carrying = at(carrying_, arm);
    if (!carrying.holds) continue;
    const Vec3 tip_W = toArray(at(X_WB_, arm) * toEigen(at(model.arms, arm).p_BT));
    for (std::size_t i = 0; i < 3; ++i)
      carrying.sum_W[i] += tip_W[i] / kSampleTicks;
    if (++carrying.ticks < kSampleTicks) continue;
    carrying.samples.push_back({carrying.sum_W, {model.arms[0].q, model.arms[1].q}});
    carrying.sum_W = {};
    carrying.ticks = 0;
  }
}

void TransitCollector::add(const ExerciseEvent& event) {
  if (event.arm != Hand::kGold && event.arm != Hand::kGreen) return;
  const Arm arm = event.arm == Hand::kGold ? Arm::kGold : Arm::kGreen;
  if (event.kind == ExerciseEventKind::kReleased) close(arm);
  if (event.kind != ExerciseEventKind::kHeld) return;
  at(carrying_, arm) = {};
  at(carrying_, arm).holds = true;
}

void TransitCollector::close(Arm arm) {
  Carrying carrying = std::move(at(carrying_, arm));
  at(carrying_, arm) = {};
  if (carrying.samples.empty()) return;
  const Vec3 taken = carrying.samples.front().tip_W, left = carrying.samples.back().tip_W;
  const auto is_clear_of = [](const Vec3& place) {
    return [=](const Sample& sample) { return distance(sample.tip_W, place) > kTransitEnd; };
  };
  const auto begin = std::find_if(carrying.samples.begin(), carrying.samples.end(), is_clear_of(taken));
  const auto end = std::find_if(carrying.samples.rbegin(), carrying.samples.rend(), is_clear_of(left)).base();
  if (end - begin < 2 || distance(begin->tip_W, (end - 1)->tip_W) < kLeastTransit) return;
  Transit transit{arm, at(begin->q, arm), at(begin->q, otherArm(arm)), {}};
  for (auto sample = begin; sample != end; ++sample)
    transit.way_W.push_back(sample->tip_W);
  transits_.push_back(std::move(transit));
}

}  // namespace raven2_trainer::training
