#pragma once

#include <algorithm>

namespace raven2_trainer::haptics {

/** 0 up to x = 0, 1 from x = 1 on, between them 3 x^2 - 2 x^3: without a jump of value or slope. */
inline double smoothStep(double x) noexcept {
  const double s = std::clamp(x, 0.0, 1.0);
  return s * s * (3.0 - 2.0 * s);
}

}  // namespace raven2_trainer::haptics
