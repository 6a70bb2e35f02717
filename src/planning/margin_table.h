#pragma once

#include <algorithm>
#include <cstddef>
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
    const std::ptrdiff_t node = nodeAt(a, b);
    return node >= 0 ? value_[static_cast<std::size_t>(node)] : -std::numeric_limits<double>::infinity();
  }

  /** A table to be filled as it is asked: see recall(). */
  MarginTable(const Axis& a, const Axis& b);
  void forget() noexcept { std::fill(value_.begin(), value_.end(), kUnknown); }
  /** As at(); `margin` of the node's two positions is called where it has not been since forget(). */
  template <typename Margin>
  double recall(double a, double b, Margin margin) noexcept {
    const std::ptrdiff_t node = nodeAt(a, b);
    if (node < 0) return -std::numeric_limits<double>::infinity();
    double& value = value_[static_cast<std::size_t>(node)];
    if (value == kUnknown) value = valueAt(static_cast<std::size_t>(node), margin);
    return value;
  }

 private:
  static constexpr double kUnknown = std::numeric_limits<double>::max();

  std::ptrdiff_t nodeAt(double a, double b) const noexcept {
    const double x = (a - a_.low) * per_a_, y = (b - b_.low) * per_b_;
    if (!(x >= 0.0 && x <= last_a_ && y >= 0.0 && y <= last_b_)) return -1;
    return static_cast<std::ptrdiff_t>(y + 0.5) * a_.nodes + static_cast<std::ptrdiff_t>(x + 0.5);
  }
  template <typename Margin>
  double valueAt(std::size_t node, Margin margin) const {
    const auto i = static_cast<double>(node % static_cast<std::size_t>(a_.nodes)),
               k = static_cast<double>(node / static_cast<std::size_t>(a_.nodes));
    return margin(a_.low + i * stepOf(a_), b_.low + k * stepOf(b_)) -
           (a_.lever * stepOf(a_) + b_.lever * stepOf(b_)) / 2;
  }
  static double stepOf(const Axis& axis) noexcept {
    return axis.nodes > 1 ? (axis.high - axis.low) / (axis.nodes - 1) : 0.0;
  }

  Axis a_, b_;
  double per_a_{}, last_a_{-1.0}, per_b_{}, last_b_{-1.0};
  std::vector<double> value_;
};

}  // namespace raven2_trainer::planning
