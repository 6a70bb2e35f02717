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

/** The camera of this name; null without one. */
const CameraConfig* findCamera(const std::vector<CameraConfig>& cameras, const std::string& name) noexcept;
/** The same. @throw ConfigException listing the known names. */
const CameraConfig& requireCamera(const std::vector<CameraConfig>& cameras, const std::string& name);

/** Where the configuration puts it. */
Camera makeCamera(const CameraConfig& config, int width, int height) noexcept;

/**
 * Place of a camera in a tick (CameraConfig::moves). It depends on that tick's state alone, without smoothing over
 * time, so a frame looks the same after any other frames. Without a camera in the state (older logs), or with numbers
 * that are not finite, it is the configured place.
 * @param[in] X_WB arm bases (RavenModel::X_WB).
 */
Camera cameraAt(const CameraConfig& config,
                const ModelState& state,
                const PerArm<Pose>& X_WB,
                int width,
                int height) noexcept;

}  // namespace raven2_trainer::model
