#pragma once

#include <cstdint>

#include "raven2_trainer/core/types.h"

namespace raven2_trainer::loop {

/** Motion of the hands in one tick. It moves the model, and through the relay the robot. */
struct Increments {
  PerArm<Vec3> dp_I{};                                ///< [m] [@frame I]
  PerArm<Quat> dq_I{{kIdentityQuat, kIdentityQuat}};  ///< [@frame I]
  PerArm<double> dgrasp{};                            ///< [rad] positive closes
  std::uint32_t commands{};                           ///< packets that it is the sum of

  /** It moves nothing. */
  void drop() noexcept {
    dp_I = {};
    dq_I = {{kIdentityQuat, kIdentityQuat}};
    dgrasp = {};
  }
};

}  // namespace raven2_trainer::loop
