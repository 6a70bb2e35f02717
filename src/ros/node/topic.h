#pragma once

#include <cstdint>

// How this package's topics are published.

namespace raven2_trainer::ros_bridge {

constexpr std::uint32_t kQueue = 10;        ///< [messages] 20 ms of a slow subscriber at 500 Hz
constexpr std::uint32_t kPictureQueue = 2;  ///< [messages]
constexpr bool kLatched = true;
constexpr double kDiagnosticsPeriod = 1.0;  ///< [s] custom of /diagnostics

}  // namespace raven2_trainer::ros_bridge
