#pragma once

#include <array>
#include <string>
#include <vector>

#include "raven2_trainer/core/state.h"
#include "raven2_trainer/model/raven_model.h"

namespace raven2_trainer::render {

/** One thing to draw. */
struct Drawable {
  int mesh{-1};                   ///< handle from Renderer::addMesh
  Pose X_WM;                      ///< mesh in W
  std::array<float, 4> colour{};  ///< r g b a
};

/** A line of text or a bar drawn over the picture. */
struct Overlay {
  std::vector<std::string> lines;         ///< top left
  std::array<double, kArmCount> force{};  ///< [N] bars
  double max_force{1.0};                  ///< [N] full bar
  std::string banner;                     ///< hazard; empty = none
};

/** All that a picture needs; knows nothing of physics. */
struct Scene {
  std::vector<Drawable> drawables;
  Overlay overlay;
};

/** What is drawn, taken from the shared state or from a log. */
struct Snapshot {
  ModelState model{};
  RobotState robot{};
  HapticState haptic{};
  std::string fault;  ///< name, or empty
};

}  // namespace raven2_trainer::render
