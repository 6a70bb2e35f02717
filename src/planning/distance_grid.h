#pragma once

#include <array>
#include <cmath>
#include <vector>

#include "planning/poll.h"
#include "planning/solid.h"
#include "raven2_trainer/model/raven_model.h"

namespace raven2_trainer::planning {

/** Bounds of the distance of a point to the nearest obstacle [m]; negative inside. */
struct DistanceBounds {
  double lower, upper;
};

/**
 * Distance to all fixed things, see StandingSolids. Exact distances are kept at the nodes of two nested
 * lattices: a fine one about the small things of the scene, among which a tool works, and a coarse one about
 * everything. Beyond, only the distance to the box around everything is known.
 *
 * Between nodes `tight()` interpolates. Let V be a node of the cell drawn with the weights of the interpolation: its
 * mean is the point x, and sigma^2 = E|V - x|^2 = h^2 sum u(1 - u). For the obstacle's point P nearest to x,
 * E f(V) <= E|V - P| <= sqrt(f(x)^2 + sigma^2), so an interpolated T bounds f(x) from below by sqrt(T^2 - sigma^2).
 * With
 * cells of 3 mm, under 0.6 mm is lost at 6 mm from an obstacle. Distances rise by no more than 1 m a metre, hence
 * |T - f| <= sigma, and the lower bound is never more than 2 sigma <= sqrt(3) h below the distance.
 *
 * Constant once made; any number of threads may share it. Queries are real-time safe; the point must be finite.
 */
class DistanceGrid {
 public:
  struct Resolution {
    double fine{0.003}, coarse{0.016};  // [m] made larger where a lattice would have more than kMaxNodes
  };
  static constexpr double kMaxNodes = 1.5e6;  // a lattice; 6 MB
  static constexpr double kRounding = 2e-6;   // [m] more than a distance below 16 m loses as a float

  /** @param[in] poll called every kPieces nodes.
   *  @throw ModelException for a mesh: obstacles are boxes, capsules and spheres; what `poll` throws. */
  DistanceGrid(const model::RavenModel& raven,
               const model::SceneModel& scene,
               const Resolution& resolution,
               const Poll& poll = {});
  DistanceGrid(const model::RavenModel& raven, const model::SceneModel& scene, const Poll& poll = {});

  /** From the nearest node alone: one read. */
  DistanceBounds quick(const Vector3& p) const noexcept {
    const Level* level = levelAt(p);
    return level != nullptr ? level->nearest(p) : beyond(p);
  }
  /** From the eight nodes around. */
  DistanceBounds tight(const Vector3& p) const noexcept {
    const Level* level = levelAt(p);
    return level != nullptr ? level->interpolated(p) : beyond(p);
  }
  /** quick(), or tight() where the lower bound of that is below `below` [m]. */
  DistanceBounds at(const Vector3& p, double below) const noexcept {
    const Level* level = levelAt(p);
    if (level == nullptr) return beyond(p);
    const DistanceBounds bounds = level->nearest(p);
    return bounds.lower < below ? level->interpolated(p) : bounds;
  }
  double lowerBound(const Vector3& p) const noexcept { return tight(p).lower; }

  /** Edge of the cells at a point [m]; 0 beyond both lattices. */
  double cellAt(const Vector3& p) const noexcept;

  /** The solids of the grid, for exact answers: StandingSolids. */
  const std::vector<Solid>& obstacles() const noexcept { return obstacles_; }
  std::size_t sceneCount() const noexcept { return scene_count_; }
  std::size_t nodeCount() const noexcept { return fine_.value.size() + coarse_.value.size(); }

 private:
  struct Box {
    Vector3 low{Vector3::Constant(1e9)}, high{Vector3::Constant(-1e9)};
  };
  struct Level {
    Vector3 origin{Vector3::Zero()}, last{Vector3::Constant(-1.0)};  // last: highest index a point may have
    double cell{1.0}, inverse{1.0}, half_diagonal{};
    std::array<std::ptrdiff_t, 3> count{};
    std::vector<float> value;  // x runs fastest

    bool contains(const Vector3& p) const noexcept;
    DistanceBounds nearest(const Vector3& p) const noexcept;
    DistanceBounds interpolated(const Vector3& p) const noexcept;
    std::ptrdiff_t at(std::ptrdiff_t i, std::ptrdiff_t j, std::ptrdiff_t k) const noexcept {
      return (k * count[1] + j) * count[0] + i;
    }
  };

  static Box boxAround(const Solid& solid);
  static Level makeLevel(const Box& box, double cell);
  void fill(Level* level, EverySoOften* poll) const;
  void fillBlock(Level* level,
                 const std::array<std::ptrdiff_t, 3>& first,
                 std::ptrdiff_t edge,
                 const std::vector<const Solid*>& near,
                 EverySoOften* poll) const;

  const Level* levelAt(const Vector3& p) const noexcept {
    if (fine_.contains(p)) return &fine_;
    return coarse_.contains(p) ? &coarse_ : nullptr;
  }
  DistanceBounds beyond(const Vector3& p) const noexcept;

  std::vector<Solid> obstacles_;
  std::size_t scene_count_{};
  Box all_;
  Level fine_, coarse_;
};

inline bool DistanceGrid::Level::contains(const Vector3& p) const noexcept {
  const double x = (p[0] - origin[0]) * inverse, y = (p[1] - origin[1]) * inverse, z = (p[2] - origin[2]) * inverse;
  return x >= 0.0 && x < last[0] && y >= 0.0 && y < last[1] && z >= 0.0 && z < last[2];
}

inline DistanceBounds DistanceGrid::Level::nearest(const Vector3& p) const noexcept {
  const auto node = [&](int k) { return static_cast<std::ptrdiff_t>((p[k] - origin[k]) * inverse + 0.5); };
  const double v = value[static_cast<std::size_t>(at(node(0), node(1), node(2)))];
  return {v - half_diagonal, v + half_diagonal + 2 * kRounding};
}

inline DistanceBounds DistanceGrid::Level::interpolated(const Vector3& p) const noexcept {
  const Vector3 u = (p - origin) * inverse;
  const auto i = static_cast<std::ptrdiff_t>(u[0]), j = static_cast<std::ptrdiff_t>(u[1]),
             k = static_cast<std::ptrdiff_t>(u[2]);
  const double x = u[0] - static_cast<double>(i), y = u[1] - static_cast<double>(j), z = u[2] - static_cast<double>(k);
  const float* v = value.data() + at(i, j, k);
  const float* w = v + count[0] * count[1];
  const std::ptrdiff_t row = count[0];
  const auto mix = [](double a, double b, double t) { return a + t * (b - a); };
  const double low = mix(mix(v[0], v[1], x), mix(v[row], v[row + 1], x), y);
  const double high = mix(mix(w[0], w[1], x), mix(w[row], w[row + 1], x), y);
  const double value_here = mix(low, high, z);
  const double variance = cell * cell * (x * (1 - x) + y * (1 - y) + z * (1 - z)), sigma = std::sqrt(variance);
  const double lower = value_here > sigma ? std::sqrt(value_here * value_here - variance) : value_here - sigma;
  return {lower, value_here + sigma + 2 * kRounding};
}

}  // namespace raven2_trainer::planning
