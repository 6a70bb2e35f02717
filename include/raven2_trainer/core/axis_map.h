#pragma once

#include <array>

#include "raven2_trainer/core/types.h"

namespace raven2_trainer {

/** Signed permutation. Rows: forward, right, down of the ITP axes I; columns: x, y, z of a device or console. */
using AxisMap = std::array<Vec3, 3>;

/** @return [-] 1, or -1 if the map mirrors. */
constexpr double determinant(const AxisMap& m) noexcept {
  return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
         m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

}  // namespace raven2_trainer
