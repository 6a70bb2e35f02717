#pragma once

#include <functional>
#include <limits>
#include <vector>

namespace raven2_trainer::planning {

/**
 * Lower bound of a distance that depends on two joints only: exact at the nodes of a lattice, lowered by as much as
 * half a step of each joint can change it. Real-time safe but for the constructor.
 */
class MarginTable {
 public:
  struct Axis {
    double low{}, high{};  // [rad, m]
    int nodes{1};          // 1: the distance does not depend on this joint
    double lever{};        // [m/rad, m/m] most that the distance changes with it
  };

  MarginTable() = default;  // knows nothing
  MarginTable(const Axis& a, const Axis& b, const std::function<double(double, double)>& margin);

  /** [m] Minus infinity beyond the axes' ends. */
  double at(double a, double b) const noexcept {
    const double x = (a - low_a_) * per_a_, y = (b - low_b_) * per_b_;
    if (!(x >= 0.0 && x <= last_a_ && y >= 0.0 && y <= last_b_)) return -std::numeric_limits<double>::infinity();
    return value_[static_cast<std::size_t>(y + 0.5) * nodes_a_ + static_cast<std::size_t>(x + 0.5)];
  }

 private:
  double low_a_{}, per_a_{}, last_a_{-1.0}, low_b_{}, per_b_{}, last_b_{-1.0};
  std::size_t nodes_a_{};
  std::vector<double> value_;
};

}  // namespace raven2_trainer::planning
