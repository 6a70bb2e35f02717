#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "raven2_trainer/model/camera.h"
#include "raven2_trainer/render/render_config.h"
#include "raven2_trainer/render/renderer.h"
#include "render/primitives.h"

namespace raven2_trainer::render {

constexpr int kWidth = 320;
constexpr int kHeight = 240;

/** A camera on the surgeon's side that looks from above at the middle of the base plate, oblique to all axes. */
inline model::Camera testCamera(int width = kWidth, int height = kHeight) {
  CameraConfig config;
  config.eye_W = {-0.9, 0.2, 0.6};
  config.target_W = {0.02, 0.01, 0.05};
  config.up_W = {0.0, 0.0, 1.0};
  config.vertical_fov = 0.8;
  return model::makeCamera(config, width, height);
}

inline Drawable drawable(int mesh, const Vector3& p_W, std::array<float, 4> colour = {1.0F, 1.0F, 1.0F, 1.0F}) {
  Drawable d;
  d.mesh = mesh;
  d.X_WM.p = p_W;
  d.colour = colour;
  return d;
}

/** Pixels in which two pictures differ. */
struct Difference {
  int count{0};
  double u{0.0}, v{0.0};  ///< [px] their centroid
  double reach{0.0};      ///< [px] farthest of them from the centroid
};

inline Difference difference(const std::vector<std::uint8_t>& a, const std::vector<std::uint8_t>& b, int width) {
  std::vector<std::pair<int, int>> changed;
  for (std::size_t i = 0; i < a.size(); i += 3) {
    if (a[i] == b[i] && a[i + 1] == b[i + 1] && a[i + 2] == b[i + 2]) continue;
    changed.emplace_back(static_cast<int>(i / 3) % width, static_cast<int>(i / 3) / width);
  }
  Difference d;
  d.count = static_cast<int>(changed.size());
  for (const auto& [x, y] : changed) {
    d.u += static_cast<double>(x) / d.count;
    d.v += static_cast<double>(y) / d.count;
  }
  for (const auto& [x, y] : changed)
    d.reach = std::max(d.reach, std::hypot(x - d.u, y - d.v));
  return d;
}

}  // namespace raven2_trainer::render
