#pragma once

#include <cmath>

#include "raven2_trainer/core/types.h"

// Lengths of plain vectors, for modules that use no Eigen. Real-time safe.

namespace raven2_trainer {

inline double norm(const Vec3& v) noexcept {
  return std::hypot(v[0], v[1], v[2]);
}

inline double distance(const Vec3& a, const Vec3& b) noexcept {
  return norm({a[0] - b[0], a[1] - b[1], a[2] - b[2]});
}

}  // namespace raven2_trainer
