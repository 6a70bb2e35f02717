#include "raven2_trainer/daemon/render_loop.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <memory>
#include <thread>

#include "raven2_trainer/config/trainer_config.h"
#include "raven2_trainer/loop/frame_states.h"
#include "raven2_trainer/net/clock.h"
#include "raven2_trainer/session/active_fault.h"

namespace raven2_trainer::daemon {

namespace {

constexpr std::int64_t kSecondLatest = 1'000'000'000;  // [ns] ours: between two pictures of the second camera
constexpr auto kUnwatchedNs = static_cast<std::int64_t>(RenderLoop::kUnwatchedPeriod * 1e9);

int scaled(int pixels, double scale) {
  return std::max(1, static_cast<int>(std::lround(pixels * scale)));
}

void drawAtPace(RenderLoop* loop, const std::function<bool(double)>& wait) {
  std::int64_t due = net::monotonicNow();
  for (std::int64_t left = 0; !wait(static_cast<double>(left) * 1e-9);) {
    loop->frame();
    due += static_cast<std::int64_t>(loop->period() * 1e9);
    const std::int64_t now = net::monotonicNow();
    due = std::max(due, now);  // late: drop frames, never time
    left = due - now;
  }
}

}  // namespace

void keepDrawing(const std::function<std::unique_ptr<RenderLoop>()>& make,
                 const std::function<bool(double)>& wait,
                 SharedState* shared) noexcept {
  try {
    drawAtPace(make().get(), wait);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "%s; going on without a live picture\n", e.what());
    LivePicture picture = shared->live_picture.load();
    picture.failed = 1;
    shared->live_picture.store(picture);
  }
}

RenderLoop::Stage::Stage(const TrainerConfig& config,
                         const model::RavenModel& raven,
                         const model::SceneModel& scene,
                         double scale)
    : renderer(scaled(config.render.live_width, scale), scaled(config.render.live_height, scale)),
      builder(raven, scene, render::SceneOptions(config, config.render.live_overlays), &renderer) {}

RenderLoop::RenderLoop(const TrainerConfig& config,
                       const model::RavenModel& raven,
                       const model::SceneModel& scene,
                       const std::vector<std::string>& body_names,
                       SharedState* shared,
                       ImageSink sink,
                       Clock clock)
    : config_(config),
      raven_(raven),
      scene_(scene),
      shared_(*shared),
      sink_(std::move(sink)),
      clock_(std::move(clock)),
      contacts_(body_names),
      cameras_{model::requireCamera(config.render.cameras, config.render.live_camera),
               model::requireCamera(config.render.cameras, config.render.stereo.camera + "_left"),
               model::requireCamera(config.render.cameras, config.render.stereo.camera + "_right"),
               model::requireCamera(config.render.cameras, config.render.live_second)},
      pace_(config.render) {
  stage_.emplace(config_, raven_, scene_, pace_.level().scale);
}

/** After the model's state, whose tick is then no newer than what is known of its plan. */
void RenderLoop::hearOfPlans() {
  const std::uint64_t plan = shared_.last_plan.version();
  if (plan != plan_heard_) plans_.add(std::make_shared<const PlanResult>(shared_.last_plan.load()));
  plan_heard_ = plan;
  const std::uint64_t execution = shared_.last_execution.version();
  if (execution != execution_heard_) plans_.add(std::make_shared<const ExecutionReport>(shared_.last_execution.load()));
  execution_heard_ = execution;
}

/** By the receipt of its newest picture: clocks of other computers are unknown here. */
bool RenderLoop::isCameraSilent() const {
  const auto limit = static_cast<std::int64_t>(config_.render.real_stale_after * 1e9);
  return clock_() - shared_.real_picture_ns.load() > limit;
}

render::Snapshot RenderLoop::newest() {
  const loop::FrameStates states =
      loop::loadFrameStates(shared_, [] { std::this_thread::sleep_for(std::chrono::microseconds(100)); });
  render::Snapshot snapshot;
  snapshot.model = states.model;
  snapshot.robot = states.robot;
  snapshot.haptic = states.haptic;
  snapshot.contact_W = contacts_.sum(states.contacts);
  hearOfPlans();
  snapshot.plans = plans_;
  snapshot.is_substitute = snapshot.model.view != 0 && isCameraSilent();
  const std::uint32_t fault = activeFault(snapshot.model, snapshot.robot);
  if (fault > 0 && fault <= config_.scenarios.size()) snapshot.fault = config_.scenarios[fault - 1].name;
  return snapshot;
}

/** If the eyes are exchanged, the published camera stays the right one: that is the fault. */
void RenderLoop::draw(const render::Scene& scene, const render::Snapshot& snapshot, Viewpoint viewpoint, bool is_view) {
  const CameraConfig& config = cameras_[static_cast<std::size_t>(viewpoint)];
  render::Renderer& renderer = stage_->renderer;
  const int width = renderer.width(), height = renderer.height();
  const auto& rgb = renderer.draw(scene, render::cameraSeeing(snapshot, config, raven_.X_WB, width, height));
  const model::Camera camera = model::cameraAt(config, snapshot.model, raven_.X_WB, width, height);
  if (sink_) sink_({rgb, camera, snapshot.model.tick, is_view, viewpoint, snapshot.model.time_ns});
}

void RenderLoop::drawAll(const render::Snapshot& seen, bool is_view, const WatchedPictures& wanted) {
  const render::Scene& scene = stage_->builder.build(seen);
  draw(scene, seen, Viewpoint::kLive, is_view);
  shared_.frames.add();
  if (wanted.stereo != 0) {
    draw(scene, seen, Viewpoint::kLeftEye, is_view);
    draw(scene, seen, Viewpoint::kRightEye, is_view);
  }
  if (wanted.second != 0) draw(scene, seen, Viewpoint::kSecond, is_view);
}

/** Where two pictures may take longer than the period, the second one would make the live one late: then seldom. */
bool RenderLoop::isSecondDue(std::int64_t now) const noexcept {
  const bool has_time = 2.0 * busy_ <= pace_.period();
  return (has_time && live_.frames % kSecondEvery == 0) || now - second_ns_ >= kSecondLatest;
}

/** Chooses the view by the present state, however old the picture may be: no camera's delay decides that. */
void RenderLoop::frame() {
  if (!stage_) stage_.emplace(config_, raven_, scene_, pace_.level().scale);
  const std::int64_t begin = clock_();
  const render::Snapshot now = newest();
  const render::Snapshot& seen = line_.pass(now);
  WatchedPictures wanted = shared_.pictures_watched.load();
  live_.watched = wanted.any() ? 1 : 0;
  const bool is_due = live_.watched != 0 || live_.frames == 0 || begin - drawn_ns_ >= kUnwatchedNs;
  if (!is_due) return stage_->builder.follow(seen);
  drawn_ns_ = begin;
  if (std::abs(now.model.tick - now.haptic.tick) > 1) ++live_.parted;
  if (wanted.second != 0) wanted.second = isSecondDue(begin) ? 1 : 0;
  if (wanted.second != 0) second_ns_ = begin;
  drawAll(seen, now.model.view == 0 || now.is_substitute, wanted);
  adapt(static_cast<double>(clock_() - begin) * 1e-9, live_.watched != 0 && !seen.is_black && wanted.second == 0);
}

/** The picture and both eyes' must fit into the period; the second camera's must not make them smaller. The time of one
 * picture a second says nothing about thirty, and that of a black one nothing about those that follow it. */
void RenderLoop::adapt(double busy, bool is_measure) {
  const double scale = pace_.level().scale;
  if (is_measure) busy_ = busy;
  reportPace(is_measure && pace_.add(busy));
  if (pace_.level().scale != scale) stage_.reset();  // one context at a time
}

void RenderLoop::reportPace(bool has_changed) {
  live_.fps = pace_.level().fps;
  live_.width = scaled(config_.render.live_width, pace_.level().scale);
  live_.height = scaled(config_.render.live_height, pace_.level().scale);
  live_.level = pace_.lowered();
  ++live_.frames;
  if (has_changed) {
    ++live_.changes;
    std::fprintf(stderr, "live picture: %d Hz, %d x %d%s\n", live_.fps, live_.width, live_.height,
                 live_.level > 0 ? "; it takes longer than configured" : "");
  }
  shared_.live_picture.store(live_);
}

}  // namespace raven2_trainer::daemon
