#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "raven2_trainer/core/types.h"

namespace raven2_trainer {

/** Whether a camera stays where it is, and if not, what takes it along. */
enum class CameraMoves : std::uint8_t {
  kNever,
  kClutch,     ///< ModelState::camera: the masters move it while its pedal is held
  kGoldTool,   ///< looks at the model's gold tool tip, from the side that eye and target give
  kGreenTool,  ///< the same, green
};
constexpr std::array<const char*, 4> kCameraMovesNames{"never", "clutch", "gold_tool", "green_tool"};

/** A camera: pose and lens, no drawing. */
struct CameraConfig {
  std::string name;
  Vec3 eye_W{};           ///< [m]
  Vec3 target_W{};        ///< [m] looked at
  Vec3 up_W{};            ///< [-]
  double vertical_fov{};  ///< [rad]
  CameraMoves moves{CameraMoves::kNever};
  double aside{};  ///< [m] to the right of its place by eye and target, in the same direction of view: an eye of a pair
};

}  // namespace raven2_trainer
