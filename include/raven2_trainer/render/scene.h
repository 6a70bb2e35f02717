#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "raven2_trainer/core/command.h"
#include "raven2_trainer/core/state.h"
#include "raven2_trainer/model/raven_model.h"
#include "raven2_trainer/training/session_score.h"

namespace raven2_trainer::render {

/** One thing to draw. */
struct Drawable {
  int mesh{-1};                   ///< handle from Renderer::addMesh
  Pose X_WM;                      ///< mesh in W
  std::array<float, 4> colour{};  ///< r g b a
  /** A mark is no thing: it throws no shadow, is never translucent, and shows faintly through what hides it. */
  bool is_mark{false};
  std::uint32_t first{0};                                          ///< of the mesh's triangles, the first drawn
  std::uint32_t count{std::numeric_limits<std::uint32_t>::max()};  ///< and how many from there on, as far as they go
  bool is_fixed{false};  ///< it stays where it is: its shadow is kept for the next pictures. Wrong, it costs time only
  std::uint16_t part{0};  ///< number of a link, as in partNames(); 0: not in a Geometry
};

/** A line of text or a bar drawn over the picture. */
struct Overlay {
  std::vector<std::string> lines;         ///< top left
  std::vector<std::string> brief;         ///< in their place where a picture is so small that they would hide the scene
  std::vector<std::string> warnings;      ///< below them, in amber
  bool has_bars{false};                   ///< below both
  std::array<double, kArmCount> force{};  ///< [N] of the bars
  double max_force{1.0};                  ///< [N] full bar
  std::string banner;                     ///< hazard; empty = none
};

/** All that a picture needs; knows nothing of physics. */
struct Scene {
  std::vector<Drawable> drawables;
  Overlay overlay;
  bool is_black{false};  ///< nothing of it is seen, the overlay neither
};

/** Results of plans so far. Cheap to copy: many frames share the same answers and reports. */
struct PlanNews {
  std::shared_ptr<const PlanResult> answer;          ///< newest of the planner; null none
  std::shared_ptr<const PlanResult> path;            ///< newest answer that is a path; null none
  std::shared_ptr<const ExecutionReport> execution;  ///< newest; null none

  void add(std::shared_ptr<const PlanResult> newest) {
    answer = std::move(newest);
    if (answer->status == PlanStatus::kSuccess) path = answer;
  }
  void add(std::shared_ptr<const ExecutionReport> newest) { execution = std::move(newest); }
};

/** Contents of a picture, from the shared state or from a log. */
struct Snapshot {
  ModelState model{};
  RobotState robot{};
  HapticState haptic{};
  std::string fault;  ///< name, or empty
  PlanNews plans;
  PerArm<Vec3> contact_W{};      ///< [N] what touches each arm presses it with, all contacts of the tick together
  bool is_substitute{false};     ///< the view is the real camera's, and it has no picture
  bool is_black{false};          ///< a fault of the video leaves nothing to be seen
  bool are_eyes_swapped{false};  ///< and another shows each eye of a pair what the other should see
  /** Of the attempt, where it was scored before the picture was drawn; shown once it is over. */
  training::AttemptVerdict verdict{};
};

}  // namespace raven2_trainer::render
