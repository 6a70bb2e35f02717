#include "planning/distance_grid.h"

#include <limits>
#include <utility>

#include "planning/standing_solids.h"

namespace raven2_trainer::planning {
namespace {

constexpr double kSmall = 0.3;    // [m] a scene body no larger than this is what the fine lattice is for
constexpr double kMargin = 0.01;  // [m] of the fine lattice about them: the radius and clearance of a tool's shaft
constexpr double kNothing = 1e3;  // [m] returned without an obstacle

double nearestOf(const std::vector<const Solid*>& solids, const Vector3& p) {
  double nearest = kNothing;
  for (const Solid* solid : solids)
    nearest = std::min(nearest, signedDistance(*solid, p));
  return nearest;
}

}  // namespace

DistanceGrid::DistanceGrid(const model::RavenModel& raven, const model::SceneModel& scene, const Poll& poll)
    : DistanceGrid(raven, scene, Resolution{}, poll) {}

DistanceGrid::DistanceGrid(const model::RavenModel& raven,
                           const model::SceneModel& scene,
                           const Resolution& resolution,
                           const Poll& poll) {
  StandingSolids standing = standingSolids(raven, scene);
  obstacles_ = std::move(standing.solids);
  scene_count_ = standing.scene_count;
  Box small;
  for (std::size_t i = 0; i < obstacles_.size(); ++i) {
    const Box box = boxAround(obstacles_[i]);
    all_ = {all_.low.cwiseMin(box.low), all_.high.cwiseMax(box.high)};
    if (i >= scene_count_ || (box.high - box.low).maxCoeff() > kSmall) continue;
    small = {small.low.cwiseMin(box.low), small.high.cwiseMax(box.high)};
  }
  const auto grown = [](const Box& box, double by) { return Box{box.low.array() - by, box.high.array() + by}; };
  if (small.low.x() <= small.high.x()) fine_ = makeLevel(grown(small, kMargin), resolution.fine);
  if (!obstacles_.empty()) coarse_ = makeLevel(grown(all_, resolution.coarse), resolution.coarse);
  EverySoOften node(poll);
  fill(&fine_, &node);
  fill(&coarse_, &node);
}

DistanceGrid::Box DistanceGrid::boxAround(const Solid& solid) {
  if (!solid.round) {
    const Vector3 reach = solid.X_WS.R.cwiseAbs() * solid.half;
    return {solid.X_WS.p - reach, solid.X_WS.p + reach};
  }
  return {solid.axis.a.cwiseMin(solid.axis.b).array() - solid.radius,
          solid.axis.a.cwiseMax(solid.axis.b).array() + solid.radius};
}

DistanceGrid::Level DistanceGrid::makeLevel(const Box& box, double cell) {
  const Vector3 size = box.high - box.low;
  const auto nodes = [&size](double edge) {
    const Vector3 count = (size / edge).array().ceil() + 2.0;
    return count.prod();
  };
  Level level;
  level.cell = cell;
  while (nodes(level.cell) > kMaxNodes)
    level.cell *= 1.05;
  level.inverse = 1.0 / level.cell;
  level.half_diagonal = std::sqrt(3.0) / 2 * level.cell;
  level.origin = box.low;
  for (int k = 0; k < 3; ++k) {
    level.count[static_cast<std::size_t>(k)] = static_cast<std::ptrdiff_t>(std::ceil(size[k] / level.cell)) + 2;
    level.last[k] = static_cast<double>(level.count[static_cast<std::size_t>(k)] - 1) - 1e-6;
  }
  level.value.resize(static_cast<std::size_t>(level.count[0] * level.count[1] * level.count[2]));
  return level;
}

void DistanceGrid::fill(Level* level, EverySoOften* poll) const {
  if (level->value.empty()) return;
  std::vector<const Solid*> every;
  for (const Solid& solid : obstacles_)
    every.push_back(&solid);
  std::ptrdiff_t edge = 1;
  while (edge < *std::max_element(level->count.begin(), level->count.end()))
    edge *= 2;
  fillBlock(level, {0, 0, 0}, edge, every, poll);
}

/** Nodes first .. first + edge - 1 of each axis. An obstacle is left out where, seen from the middle of the block,
 *  another is nearer by more than the block's diameter: nowhere within can it be the nearest. */
void DistanceGrid::fillBlock(Level* level,
                             const std::array<std::ptrdiff_t, 3>& first,
                             std::ptrdiff_t edge,
                             const std::vector<const Solid*>& near,
                             EverySoOften* poll) const {
  if (first[0] >= level->count[0] || first[1] >= level->count[1] || first[2] >= level->count[2]) return;
  const Vector3 corner(static_cast<double>(first[0]), static_cast<double>(first[1]), static_cast<double>(first[2]));
  const Vector3 middle = level->origin + level->cell * (corner.array() + 0.5 * static_cast<double>(edge - 1)).matrix();
  const double radius = std::sqrt(3.0) / 2 * static_cast<double>(edge - 1) * level->cell;
  if (edge == 1) {
    float& value = level->value[static_cast<std::size_t>(level->at(first[0], first[1], first[2]))];
    value = static_cast<float>(nearestOf(near, middle) - kRounding);
    (*poll)();
    return;
  }
  std::vector<double> distances(near.size());
  std::transform(near.begin(), near.end(), distances.begin(),
                 [&middle](const Solid* solid) { return signedDistance(*solid, middle); });
  const double nearest = *std::min_element(distances.begin(), distances.end());
  std::vector<const Solid*> kept;
  for (std::size_t i = 0; i < near.size(); ++i)
    if (distances[i] <= nearest + 2 * radius) kept.push_back(near[i]);
  const std::ptrdiff_t half = edge / 2;
  for (std::ptrdiff_t child = 0; child < 8; ++child)
    fillBlock(level,
              {first[0] + (child & 1) * half, first[1] + (child >> 1 & 1) * half, first[2] + (child >> 2) * half}, half,
              kept, poll);
}

double DistanceGrid::cellAt(const Vector3& p) const noexcept {
  const Level* level = levelAt(p);
  return level != nullptr ? level->cell : 0.0;
}

DistanceBounds DistanceGrid::beyond(const Vector3& p) const noexcept {
  if (obstacles_.empty()) return {kNothing, std::numeric_limits<double>::infinity()};
  return {(p - p.cwiseMax(all_.low).cwiseMin(all_.high)).norm(), std::numeric_limits<double>::infinity()};
}

}  // namespace raven2_trainer::planning
