#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "raven2_trainer/core/config.h"
#include "raven2_trainer/core/shared_state.h"
#include "raven2_trainer/model/camera.h"
#include "raven2_trainer/render/renderer.h"
#include "raven2_trainer/runtime/live_pace.h"

namespace raven2_trainer::runtime {

/** A live picture, valid during the call that hands it out. */
struct LiveImage {
  const std::vector<std::uint8_t>& rgb;  ///< top row first
  const model::Camera& camera;
  Tick tick;             ///< of the model and haptic states drawn
  std::int64_t time_ns;  ///< [ns] CLOCK_MONOTONIC of that tick (ModelState::time_ns)
  bool is_view;          ///< what was asked for (ModelState::view), or stands in for the real camera, which is silent
};
using ImageSink = std::function<void(const LiveImage&)>;

/** Body of the render thread. Its OpenGL context lives and dies on that thread: construct it there. */
class RenderLoop {
 public:
  /** All but the sink must outlive it. @throw RenderException. */
  RenderLoop(const TrainerConfig& config,
             const model::RavenModel& raven,
             const model::SceneModel& scene,
             SharedState* shared,
             ImageSink sink);
  /** Draws the newest states and hands the picture out. Where frames take too long, the next ones are fewer or smaller
   *  (LivePace); that is said on stderr, and in SharedState::live_picture. */
  void frame();
  /** [s] from the beginning of a frame to that of the next. */
  double period() const noexcept { return pace_.period(); }

 private:
  /** What draws pictures of one size. */
  struct Stage {
    Stage(const TrainerConfig& config, const model::RavenModel& raven, const model::SceneModel& scene, double scale);
    render::Renderer renderer;
    render::SceneBuilder builder;
    model::Camera camera;
  };

  void draw();
  void adapt(double busy);
  void hearOfPlans();
  bool isCameraSilent() const;

  const TrainerConfig& config_;
  const model::RavenModel& raven_;
  const model::SceneModel& scene_;
  SharedState& shared_;
  ImageSink sink_;
  LivePace pace_;
  std::optional<Stage> stage_;  // for pace_'s level; none: to be made for the next frame
  LivePicture told_;
  render::PlanNews plans_;
  std::uint64_t plan_heard_{0}, execution_heard_{0};  // versions of their cells
};

/** Camera of the configuration by name. @throw ConfigException listing the known names. */
const CameraConfig& findCamera(const RenderConfig& config, const std::string& name);

}  // namespace raven2_trainer::runtime
