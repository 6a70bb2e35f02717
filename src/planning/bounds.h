#pragma once

#include <cstdint>
#include <cstring>

#include "planning/segment.h"

namespace raven2_trainer::planning {

/** Four floats, of which compilers make one SSE register. */
using Quad = float __attribute__((vector_size(16)));

/** A box along the axes of W around a shape, in single precision but rounded outwards: for a first look. */
struct Bounds {
  Quad low{}, high{};  // x, y, z, 0

  /** [m] More than rounding a coordinate below 16 m to single precision moves it. */
  static constexpr double kOutwards = 1e-6;

  static Bounds around(const Segment& axis, double radius) noexcept {
    const double by = radius + kOutwards;
    const auto low = [&](int k) { return static_cast<float>((axis.a[k] < axis.b[k] ? axis.a[k] : axis.b[k]) - by); };
    const auto high = [&](int k) { return static_cast<float>((axis.a[k] < axis.b[k] ? axis.b[k] : axis.a[k]) + by); };
    return {Quad{low(0), low(1), low(2), 0.0f}, Quad{high(0), high(1), high(2), 0.0f}};
  }

  void add(const Bounds& other) noexcept {
    low = low < other.low ? low : other.low;
    high = high > other.high ? high : other.high;
  }
};

/** True only if the shapes within are farther apart than `by` [m], which is not negative. */
inline bool apart(const Bounds& a, const Bounds& b, double by) noexcept {
  const auto gap = static_cast<float>(by);
  const auto beyond = (a.low - b.high > gap) | (b.low - a.high > gap);
  static_assert(sizeof beyond == 2 * sizeof(std::uint64_t));
  std::uint64_t lanes[2];
  std::memcpy(lanes, &beyond, sizeof lanes);
  return (lanes[0] | lanes[1]) != 0;
}

}  // namespace raven2_trainer::planning
