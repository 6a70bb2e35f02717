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
                       const std::vector<std::string>& body_names,
                       SharedState* shared,
                       ImageSink sink)
    : config_(config),
      X_WB_(raven.X_WB),
      shared_(*shared),
      sink_(std::move(sink)),
      renderer_(config.render.live_width, config.render.live_height),
      builder_(raven, scene, render::SceneOptions(config, config.render.live_overlays), &renderer_),
      contacts_(body_names),
      cameras_{findCamera(config.render, config.render.live_camera),
               findCamera(config.render, config.render.stereo.camera + "_left"),
               findCamera(config.render, config.render.stereo.camera + "_right")} {}

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

/** Model and contacts of one tick; without contacts if none of theirs can be had. */
void RenderLoop::takeModel(render::Snapshot* snapshot) const {
  constexpr int kTries = 4;  // physics stores one right behind the other, every millisecond
  for (int i = 0; i < kTries; ++i) {
    snapshot->model = shared_.model.load();
    const ContactList contacts = shared_.contacts.load();
    if (contacts.tick != snapshot->model.tick) continue;
    snapshot->contact_W = contacts_.sum(contacts);
    return;
  }
}

render::Snapshot RenderLoop::newest() {
  render::Snapshot snapshot;
  takeModel(&snapshot);
  snapshot.robot = shared_.robot.load();
  snapshot.haptic = shared_.haptic.load();
  hearOfPlans();
  snapshot.plans = plans_;
  snapshot.stands_in = snapshot.model.view != 0 && isCameraSilent();
  const std::uint32_t in_robot = snapshot.robot.active_fault;
  const std::uint32_t fault = in_robot != 0 ? in_robot : snapshot.model.faults.active;
  if (fault > 0 && fault <= config_.scenarios.size()) snapshot.fault = config_.scenarios[fault - 1].name;
  return snapshot;
}

/** The camera that is told stays the right one if the eyes are changed over: that is the fault. */
void RenderLoop::draw(const render::Scene& scene, const render::Snapshot& snapshot, Eye eye) {
  const CameraConfig& config = cameras_[static_cast<std::size_t>(eye)];
  const int width = renderer_.width(), height = renderer_.height();
  const auto& rgb = renderer_.draw(scene, render::cameraSeeing(snapshot, config, X_WB_, width, height));
  const model::Camera camera = model::cameraAt(config, snapshot.model, X_WB_, width, height);
  const bool is_view = snapshot.model.view == 0 || snapshot.stands_in;
  if (sink_) sink_({rgb, camera, snapshot.model.tick, is_view, eye, snapshot.model.time_ns});
}

void RenderLoop::frame() {
  const render::Snapshot& snapshot = line_.pass(newest());
  const render::Scene& scene = builder_.build(snapshot);
  draw(scene, snapshot, Eye::kMiddle);
  shared_.frames.add();
  if (shared_.stereo_watched.load() == 0) return;
  for (const Eye eye : {Eye::kLeft, Eye::kRight})
    draw(scene, snapshot, eye);
}

}  // namespace raven2_trainer::runtime
