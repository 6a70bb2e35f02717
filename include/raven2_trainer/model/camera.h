#pragma once

#include "raven2_trainer/core/config.h"
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

Camera makeCamera(const CameraConfig& config, int width, int height) noexcept;

}  // namespace raven2_trainer::model
