#pragma once

#include <algorithm>
#include <cmath>

#include "raven2_trainer/core/types.h"

namespace raven2_trainer::physics {

inline bool isFinite(const JointArray& values) noexcept {
  return std::all_of(values.begin(), values.end(), [](double value) { return std::isfinite(value); });
}

}  // namespace raven2_trainer::physics
