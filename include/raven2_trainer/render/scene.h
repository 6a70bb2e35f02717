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
  /** A mark is not a physical object: no shadow, never translucent, faintly visible through what hides it. */
  bool is_mark{false};
  std::uint32_t first{0};                                          ///< index of the first triangle drawn
  std::uint32_t count{std::numeric_limits<std::uint32_t>::max()};  ///< number of triangles drawn, limited to the mesh's
  /** It does not move: its shadow is kept for the next pictures. A wrong value only costs time. */
  bool is_fixed{false};
  std::uint16_t part{0};  ///< number of a link, as in partNames(); 0: not in a Geometry
};

/** A line of text or a bar drawn over the picture. */
struct Overlay {
  std::vector<std::string> lines;         ///< top left
  std::vector<std::string> brief;         ///< replaces `lines` in pictures so small that these would hide the scene
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
  bool is_black{false};  ///< the picture is black, overlay included
};

/** Results of plans so far. Cheap to copy: many frames share the same answers and reports. */
struct PlanNews {
  std::shared_ptr<const PlanResult> answer;          ///< newest of the planner; null: none yet
  std::shared_ptr<const PlanResult> path;            ///< newest answer that is a path; null: none yet
  std::shared_ptr<const ExecutionReport> execution;  ///< newest; null: none yet

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
  PerArm<Vec3> contact_W{};      ///< [N] sum of the contact forces on each arm in this tick
  bool is_substitute{false};     ///< the view is the real camera's, and it has no picture
  bool is_black{false};          ///< a fault of the video makes the picture black
  bool are_eyes_swapped{false};  ///< a fault of the video swaps the pictures of the two eyes
  /** Of the attempt, if it was scored before the picture is drawn; shown once the attempt is over. */
  training::AttemptVerdict verdict{};
};

}  // namespace raven2_trainer::render
