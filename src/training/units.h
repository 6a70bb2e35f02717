#pragma once

#include <limits>

// Units of what people read. SI inside.

namespace raven2_trainer::training {

constexpr double kMillimetres = 1e3;  ///< in a metre
constexpr double kMicrometres = 1e6;  ///< in a metre
constexpr double kInfinity = std::numeric_limits<double>::infinity();

}  // namespace raven2_trainer::training
