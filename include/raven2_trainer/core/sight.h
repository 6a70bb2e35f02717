#pragma once

#include <array>
#include <cstdint>
#include <type_traits>

#include "raven2_trainer/core/exercise.h"
#include "raven2_trainer/core/scene_roles.h"
#include "raven2_trainer/core/state.h"

namespace raven2_trainer {

/** State of the virtual scene, 30 times a second: for simulated surgeons, in place of an image. */
struct Sight {
  std::uint32_t sequence{};
  Tick tick{};  ///< [1 ms] of the model
  Mode mode{};
  RunLevel runlevel{};
  std::uint8_t linked{};
  ExerciseStatus exercise{};  ///< of the newest attempt
  std::uint16_t broken{};     ///< bit i: breakable i is off its foot
  std::uint8_t ghost{};       ///< bit i: the tip of the robot's arm i is visibly off the model's (haptics/perception.h)
  std::uint32_t step{};       ///< ExerciseState::step
  PerArm<RigidPose> tool_W{};
  PerArm<double> opening{};  ///< [rad] of the jaws
  std::array<RigidPose, kMaxSceneBodies> bodies_W{};
  CameraState camera{};
};
static_assert(std::is_trivially_copyable<Sight>::value, "travels in a packet");

}  // namespace raven2_trainer
