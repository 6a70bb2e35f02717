#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "raven2_trainer/core/config.h"
#include "raven2_trainer/core/shared_state.h"
#include "raven2_trainer/model/camera.h"
#include "raven2_trainer/render/renderer.h"

namespace raven2_trainer::runtime {

/** A live picture, valid during the call that hands it out. */
struct LiveImage {
  const std::vector<std::uint8_t>& rgb;  ///< top row first
  const model::Camera& camera;
  Tick tick;     ///< of the model state drawn
  bool is_view;  ///< what was asked for (ModelState::view), or stands in for the real camera, which is silent
};
using ImageSink = std::function<void(const LiveImage&)>;

/** Body of the render thread. Its OpenGL context lives and dies on that thread: construct it there. */
class RenderLoop {
 public:
  /** @throw RenderException. */
  RenderLoop(const TrainerConfig& config,
             const model::RavenModel& raven,
             const model::SceneModel& scene,
             SharedState* shared,
             ImageSink sink);
  /** Draws the newest states and hands the picture out. */
  void frame();

 private:
  void hearOfPlans();
  bool isCameraSilent() const;

  const TrainerConfig& config_;
  SharedState& shared_;
  ImageSink sink_;
  render::Renderer renderer_;
  render::SceneBuilder builder_;
  model::Camera camera_;
  render::PlanNews plans_;
  std::uint64_t plan_heard_{0}, execution_heard_{0};  // versions of their cells
};

/** Camera of the configuration by name. @throw ConfigException listing the known names. */
const CameraConfig& findCamera(const RenderConfig& config, const std::string& name);

}  // namespace raven2_trainer::runtime
