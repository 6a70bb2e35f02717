#pragma once

#include "raven2_trainer/core/camera_config.h"
#include "raven2_trainer/core/state.h"

namespace raven2_trainer::control {

/**
 * The camera that both hands move, as if they held it: to the right and upward around what it looks at, forward nearer
 * to it. It goes on looking at the same place, upright. Pure; real-time safe.
 */
class CameraOrbit {
 public:
  /** @param[in] start its first place: eye and target apart, and not above each other. */
  explicit CameraOrbit(const CameraConfig& start) noexcept;

  /** Mean of what the hands moved in a tick [m] [@frame I: forward, right, down]. */
  void move(const Vec3& mean_I) noexcept;

  CameraState state() const noexcept;

 private:
  Vec3 target_W_;
  double distance_, azimuth_, elevation_;  ///< [m], [rad] of the eye, from x towards y, and above the horizon
};

}  // namespace raven2_trainer::control
