#include "raven2_trainer/runtime/render_loop.h"

#include <memory>

#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/net/clock.h"

namespace raven2_trainer::runtime {

const CameraConfig& findCamera(const RenderConfig& config, const std::string& name) {
  std::string known;
  for (const CameraConfig& camera : config.cameras) {
    if (camera.name == name) return camera;
    known += " " + camera.name;
  }
  throw ConfigException("no camera is called \"" + name + "\"; known:" + known);
}

RenderLoop::RenderLoop(const TrainerConfig& config,
                       const model::RavenModel& raven,
                       const model::SceneModel& scene,
                       SharedState* shared,
                       ImageSink sink)
    : config_(config),
      shared_(*shared),
      sink_(std::move(sink)),
      renderer_(config.render.live_width, config.render.live_height),
      builder_(raven, scene, config.haptics, &renderer_),
      camera_(model::makeCamera(findCamera(config.render, config.render.live_camera),
                                config.render.live_width,
                                config.render.live_height)) {}

/** After the model's state, whose tick is then no newer than what is known of its plan. */
void RenderLoop::hearOfPlans() {
  const std::uint64_t plan = shared_.last_plan.version();
  if (plan != plan_heard_) plans_.add(std::make_shared<const PlanResult>(shared_.last_plan.load()));
  plan_heard_ = plan;
  const std::uint64_t execution = shared_.last_execution.version();
  if (execution != execution_heard_) plans_.add(std::make_shared<const ExecutionReport>(shared_.last_execution.load()));
  execution_heard_ = execution;
}

/** By the receipt of its newest picture: clocks of other computers tell nothing here. */
bool RenderLoop::isCameraSilent() const {
  const auto limit = static_cast<std::int64_t>(config_.render.real_stale_after * 1e9);
  return net::monotonicNow() - shared_.real_picture_ns.load() > limit;
}

void RenderLoop::frame() {
  render::Snapshot snapshot;
  snapshot.model = shared_.model.load();
  snapshot.robot = shared_.robot.load();
  snapshot.haptic = shared_.haptic.load();
  hearOfPlans();
  snapshot.plans = plans_;
  const bool wants_real = snapshot.model.view != 0;
  snapshot.stands_in = wants_real && isCameraSilent();
  const std::uint32_t in_robot = snapshot.robot.active_fault;
  const std::uint32_t fault = in_robot != 0 ? in_robot : snapshot.model.faults.active;
  if (fault > 0 && fault <= config_.scenarios.size()) snapshot.fault = config_.scenarios[fault - 1].name;
  const std::vector<std::uint8_t>& rgb = renderer_.draw(builder_.build(snapshot), camera_);
  shared_.frames.add();
  if (sink_) sink_({rgb, camera_, snapshot.model.tick, !wants_real || snapshot.stands_in});
}

}  // namespace raven2_trainer::runtime
