#pragma once

namespace raven2_trainer::physics {

constexpr double kGravity = 9.81;  ///< [m/s2] along -z of W; the value of raven2.md 6.2

}  // namespace raven2_trainer::physics
