#include "planning/path_improvement.h"

#include <algorithm>
#include <cmath>

#include "raven2_trainer/core/random.h"

namespace raven2_trainer::planning {
namespace {

/** Stream of the generator: another one than the samples'. */
constexpr std::uint64_t kStream = 77;

// A step of success grows by e^0.4, one of failure shrinks by e^-0.1: as large as it may be where one in five helps
// (Rechenberg's rule of evolution strategies).
const double kGrowth = std::exp(0.4), kShrinking = std::exp(-0.1);
constexpr double kFirstStep = 0.1, kLastStep = 0.001;

/** The room between `sum` and `limit`, and so much more that rounding cannot bring the sum of both below it. */
double room(double limit, double sum) {
  constexpr double kRounding = 1e-12;  // [-] of the limit; three roundings are 3.3e-16
  return limit - sum + kRounding * limit;
}

class Improvement {
 public:
  Improvement(std::vector<UnitState> path, const ImprovementTask& task)
      : path_(std::move(path)), task_(task), random_(task.seed, kStream) {
    for (std::size_t i = 1; i < path_.size(); ++i)
      costs_.push_back(cost(path_[i - 1], path_[i]));
    steps_.assign(path_.size(), kFirstStep);
  }

  std::vector<UnitState> run() {
    for (std::size_t i = path_.size() - 1; i-- > 1;)
      leaveOut(i);
    for (std::uint32_t attempt = 0; attempt < task_.attempts && path_.size() > 2 && !task_.stop(); ++attempt) {
      const std::size_t i = 1 + random_.next() % (path_.size() - 2);
      if (attempt % 4 == 0 && leaveOut(i)) continue;
      const bool better = moveTo(i, attempt % 4 == 1 ? towardLine(i) : nearby(i));
      steps_[i] = std::max(kLastStep, std::min(1.0, steps_[i] * (better ? kGrowth : kShrinking)));
    }
    return path_;
  }

 private:
  double cost(const UnitState& a, const UnitState& b) const {
    return task_.cost->plain(a, b) + task_.cost->clearanceTerm(a, b);
  }

  /** Of two edges in a row, from a by way of b to c: true if they cost less than `limit` and are free. The expensive
   * part is
   * computed last: costs without clearance take a quarter of a microsecond, checks some, the clearance term most. It
   * is added up only as far as it decides. */
  bool isBetter(const UnitState& a,
                const UnitState& b,
                const UnitState& c,
                double limit,
                double* first,
                double* second) {
    *first = task_.cost->plain(a, b);
    *second = task_.cost->plain(b, c);
    if (*first + *second >= limit || !task_.is_edge_free(a, b) || !task_.is_edge_free(b, c)) return false;
    *first += task_.cost->clearanceTerm(a, b, room(limit, *first + *second));
    if (*first + *second >= limit) return false;
    *second += task_.cost->clearanceTerm(b, c, room(limit, *first + *second));
    return *first + *second < limit;
  }

  bool leaveOut(std::size_t i) {
    const UnitState &a = path_[i - 1], &b = path_[i + 1];
    const double limit = costs_[i - 1] + costs_[i];
    double direct = task_.cost->plain(a, b);
    if (direct >= limit || !task_.is_edge_free(a, b)) return false;
    direct += task_.cost->clearanceTerm(a, b, room(limit, direct));
    if (direct >= limit) return false;
    const auto at = static_cast<std::ptrdiff_t>(i);
    path_.erase(path_.begin() + at);
    steps_.erase(steps_.begin() + at);
    costs_.erase(costs_.begin() + at);
    costs_[i - 1] = direct;
    return true;
  }

  bool moveTo(std::size_t i, const UnitState& point) {
    // By less than rounding could bring back: no going round in circles.
    const double limit = (costs_[i - 1] + costs_[i]) * (1.0 - 1e-9);
    double before = 0.0, after = 0.0;
    if (!isBetter(path_[i - 1], point, path_[i + 1], limit, &before, &after)) return false;
    path_[i] = point;
    costs_[i - 1] = before;
    costs_[i] = after;
    return true;
  }

  /** Part of the way to the nearest point of the line between the neighbours. */
  UnitState towardLine(std::size_t i) {
    const UnitState &a = path_[i - 1], &b = path_[i + 1];
    double along = 0.0, squared = 0.0;
    for (std::size_t k = 0; k < kPlanDimension; ++k) {
      along += (path_[i][k] - a[k]) * (b[k] - a[k]);
      squared += (b[k] - a[k]) * (b[k] - a[k]);
    }
    const double s = squared > 0.0 ? std::clamp(along / squared, 0.0, 1.0) : 0.0;
    return interpolate(path_[i], interpolate(a, b, s), random_.uniform(0.0, 1.0));
  }

  UnitState nearby(std::size_t i) {
    UnitState point = path_[i];
    for (double& x : point)
      x = std::clamp(x + steps_[i] * random_.normal(), 0.0, 1.0);
    return point;
  }

  std::vector<UnitState> path_;
  std::vector<double> costs_;  // of the edges
  std::vector<double> steps_;  // [-] of each waypoint, in the cube
  const ImprovementTask& task_;
  Random random_;
};

}  // namespace

std::vector<UnitState> improvePath(std::vector<UnitState> path, const ImprovementTask& task) {
  if (task.attempts == 0 || path.size() < 3) return path;
  return Improvement(std::move(path), task).run();
}

}  // namespace raven2_trainer::planning
