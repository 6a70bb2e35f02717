#pragma once

#include <cstdint>
#include <limits>

#include "raven2_trainer/console/master.h"
#include "raven2_trainer/core/state_cell.h"

namespace raven2_trainer::ros_bridge {

/** The newest force of the console, until it is too old. */
class FreshForce {
 public:
  explicit FreshForce(const StateCell<DeviceForce>& cell) noexcept : cell_(cell) {}

  /** The newest; without its force once the console has been silent too long. @param[in] time [s] of a clock. */
  DeviceForce take(double time) noexcept {
    const std::uint64_t version = cell_.version();
    if (version != version_) updated_ = time;
    version_ = version;
    DeviceForce out = cell_.load();
    if (time - updated_ > kLifetime) out.force = {};
    return out;
  }

 private:
  static constexpr double kLifetime = 0.05;  // [s] as at the console (sources.md 2.2)
  const StateCell<DeviceForce>& cell_;
  std::uint64_t version_{0};
  double updated_{-std::numeric_limits<double>::infinity()};
};

}  // namespace raven2_trainer::ros_bridge
