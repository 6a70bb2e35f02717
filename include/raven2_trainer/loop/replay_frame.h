#pragma once

#include <array>
#include <cstdint>
#include <type_traits>

#include "raven2_trainer/core/scene_roles.h"
#include "raven2_trainer/core/types.h"

namespace raven2_trainer {

/** The shown part of one tick of a recorded session. */
struct ReplayFrame {
  std::uint32_t replay{};                             ///< Request::plan of its replay; 0: any replay
  std::uint8_t is_last{};                             ///< 1: the recording has ended, the rest is invalid
  PerArm<JointArray> q{};                             ///< [rad; m] of the model's arms
  std::array<RigidPose, kMaxSceneBodies> bodies_W{};  ///< as ModelState::bodies
};
static_assert(std::is_trivially_copyable<ReplayFrame>::value, "travels in a ring");

constexpr std::size_t kReplayFrames = 1024;  ///< capacity of the ring: a second

}  // namespace raven2_trainer
