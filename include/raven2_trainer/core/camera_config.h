#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "raven2_trainer/core/types.h"

namespace raven2_trainer {

/** Motion of a camera. */
enum class CameraMoves : std::uint8_t {
  kNever,
  kClutch,     ///< the masters, while the camera pedal is held: ModelState::camera
  kGoldTool,   ///< follows the model's gold tool tip; view direction and distance stay
  kGreenTool,  ///< the same for the green tool tip
};
constexpr std::array<const char*, 4> kCameraMovesNames{"never", "clutch", "gold_tool", "green_tool"};

/** A camera: pose and lens, no drawing. */
struct CameraConfig {
  std::string name;
  Vec3 eye_W{};           ///< [m]
  Vec3 target_W{};        ///< [m] point in the image's centre
  Vec3 up_W{};            ///< [-]
  double vertical_fov{};  ///< [rad]
  CameraMoves moves{CameraMoves::kNever};
  double aside{};  ///< [m] shift to the right with the same view direction, for one eye of a stereo pair
};

}  // namespace raven2_trainer
