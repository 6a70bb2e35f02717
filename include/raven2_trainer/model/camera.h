#pragma once

#include <string>
#include <vector>

#include "raven2_trainer/core/camera_config.h"
#include "raven2_trainer/core/state.h"
#include "raven2_trainer/kinematics/eigen.h"

namespace raven2_trainer::model {

/** Pin-hole camera of a given image size. No drawing here: the renderer, camera_info and the metrics share it. */
struct Camera {
  Pose X_WC;              ///< optical frame C (z forward, x right, y down) in W
  int width{}, height{};  ///< [px]
  double fx{}, fy{};      ///< [px]
  double cx{}, cy{};      ///< [px] centre of the image: (width - 1) / 2, (height - 1) / 2

  /** Pixel of a point in W; false if it lies behind the camera. Pixel centres have integer coordinates. */
  bool project(const Vector3& p_W, double* u, double* v) const noexcept;
};

/** The camera of this name; null if there is none. */
const CameraConfig* findCamera(const std::vector<CameraConfig>& cameras, const std::string& name) noexcept;
/** The same. @throw ConfigException listing the known names. */
const CameraConfig& requireCamera(const std::vector<CameraConfig>& cameras, const std::string& name);

/** Where the configuration puts it. */
Camera makeCamera(const CameraConfig& config, int width, int height) noexcept;

/**
 * Where a camera stands in a tick (CameraConfig::moves): a function of that tick's state alone, not smoothed over time,
 * so that a frame looks the same whichever frames were drawn before it. Where the state does not tell (older logs), or
 * what it tells is not finite, that is where the configuration puts it.
 * @param[in] X_WB arm bases (RavenModel::X_WB).
 */
Camera cameraAt(const CameraConfig& config,
                const ModelState& state,
                const PerArm<Pose>& X_WB,
                int width,
                int height) noexcept;

}  // namespace raven2_trainer::model
