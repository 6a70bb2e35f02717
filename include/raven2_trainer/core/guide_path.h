#pragma once

#include <array>
#include <cstdint>
#include <type_traits>

#include "raven2_trainer/core/types.h"

namespace raven2_trainer {

constexpr std::size_t kMaxPathPoints = 256;

/** Path of one arm's tool tip along a plan, as a polyline. */
struct GuidePath {
  std::uint32_t plan{};  ///< PlanResult::id; 0: no plan
  Arm arm{Arm::kGold};
  std::uint32_t count{};                        ///< points in use
  std::array<Vec3, kMaxPathPoints> points_B{};  ///< [m] [@frame B] of `arm`
};
static_assert(std::is_trivially_copyable<GuidePath>::value, "crosses threads word by word");

}  // namespace raven2_trainer
