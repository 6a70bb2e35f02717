// Without arguments, prints the cost of a plan in a live picture. It draws frames alternately with and without the
// plan, so that both see the same machine. With a session's directory, prints the cost of each stage of the session's
// video: `render_benchmark DIR [FRAMES]`.
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/render/renderer.h"
#include "raven2_trainer/render/video_writer.h"
#include "raven2_trainer/session/session_log.h"
#include "render/frame_timeline.h"
#include "unit/render/plan_fixture.h"

namespace {

using namespace raven2_trainer;  // NOLINT: a program, not a header

constexpr int kFrames = 300;

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
}

render::Snapshot atHome(const TrainerConfig& config, const model::SceneModel& scene) {
  render::Snapshot snapshot;
  for (ArmState& arm : snapshot.model.arms)
    arm.q = config.arms.geometry.home;
  for (std::size_t i = 0; i < scene.free_bodies.size(); ++i)
    snapshot.model.bodies[i] = toArray(scene.X_WL[static_cast<std::size_t>(scene.free_bodies[i])]);
  return snapshot;
}

double seconds(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

double childSeconds() {
  rusage used{};
  getrusage(RUSAGE_CHILDREN, &used);
  return static_cast<double>(used.ru_utime.tv_sec + used.ru_stime.tv_sec) +
         1e-6 * static_cast<double>(used.ru_utime.tv_usec + used.ru_stime.tv_usec);
}

/** Wall and processor time of one stage, for all frames together. Processor time includes the rasteriser's thread. */
struct Stage {
  std::string name;
  double wall{0.0}, cpu{0.0};

  void add(const std::function<void()>& work) {
    const double wall_begin = seconds(CLOCK_MONOTONIC), cpu_begin = seconds(CLOCK_PROCESS_CPUTIME_ID);
    work();
    wall += seconds(CLOCK_MONOTONIC) - wall_begin;
    cpu += seconds(CLOCK_PROCESS_CPUTIME_ID) - cpu_begin;
  }
  void print(std::size_t frames) const {
    const double per_frame = 1e3 / static_cast<double>(frames);
    std::printf("%-28s %8.2f ms wall %8.2f ms of a processor\n", name.c_str(), wall * per_frame, cpu * per_frame);
  }
};

std::vector<render::Snapshot> readFrames(const TrainerConfig& config, const std::string& log) {
  render::FrameTimeline timeline(config.render.video_fps, 0.0, -1.0);
  session::LogVisitor visitor;
  visitor.tick = [&](const TickRecord& record) { timeline.add(record); };
  visitor.haptic = [&](const HapticRecord& record) { timeline.add(record); };
  visitor.plan = [&](const PlanRecord& record) { timeline.add(record); };
  visitor.execution = [&](const ExecutionRecord& record) { timeline.add(record); };
  return timeline.frames(session::readLog(log, visitor).header.scenarios);
}

/** The stages of Renderer::draw(), in the order in which they end. */
class DrawSplit {
 public:
  void begin() {
    wall_ = seconds(CLOCK_MONOTONIC);
    cpu_ = seconds(CLOCK_PROCESS_CPUTIME_ID);
  }
  void end(const char* name) {
    const double wall = seconds(CLOCK_MONOTONIC), cpu = seconds(CLOCK_PROCESS_CPUTIME_ID);
    auto stage = std::find_if(stages_.begin(), stages_.end(), [&](const Stage& s) { return s.name == name; });
    if (stage == stages_.end()) stage = stages_.insert(stages_.end(), Stage{name});
    stage->wall += wall - wall_;
    stage->cpu += cpu - cpu_;
    begin();
  }
  void print(std::size_t frames) const {
    for (const Stage& stage : stages_)
      stage.print(frames);
  }

 private:
  std::vector<Stage> stages_;
  double wall_{0.0}, cpu_{0.0};
};

/** Prints the cost of each stage of drawing, in order. */
void benchmarkSplit(const std::vector<render::Snapshot>& frames,
                    const model::Camera& camera,
                    const model::Camera* inset,
                    render::SceneBuilder* builder,
                    render::Renderer* renderer) {
  DrawSplit split;
  for (const render::Snapshot& frame : frames) {
    const render::Scene& scene = builder->build(frame);
    renderer->watchStages([&](const char* stage) { split.end(stage); });
    split.begin();
    renderer->draw(scene, camera, inset);
  }
  renderer->watchStages({});
  split.print(frames.size());
}

/** Prints the cost of the live picture: its processor time as a share of one core at 30 Hz. */
void benchmarkLive(const std::vector<render::Snapshot>& frames,
                   const model::Camera& camera,
                   render::SceneBuilder* builder,
                   render::Renderer* renderer) {
  Stage all{"build and draw, all of it"};
  for (const render::Snapshot& frame : frames)
    all.add([&] { renderer->draw(builder->build(frame), camera); });
  all.print(frames.size());
  std::printf("%-28s %8.0f %% of a core at 30 Hz\n", "", 100.0 * 30.0 * all.cpu / static_cast<double>(frames.size()));
}

void benchmarkVideo(const std::string& directory, std::size_t limit) {
  const std::string log = directory + "/session.rlog";
  config::TrainingNames training;
  training.exercise = session::readLogHeader(log).exercise;
  const TrainerConfig config = config::loadTrainerConfig(RAVEN2_TRAINER_SOURCE_DIR "/config/trainer.yaml", training);
  const RenderConfig& video = config.render;
  Stage start{"start: models, context"}, state{"state (log to frames)"}, build{"build"};
  Stage draw{"draw, all of it"}, encode{"encode (hand over)"};
  std::vector<render::Snapshot> frames;
  state.add([&] { frames = readFrames(config, log); });
  const std::size_t in_log = frames.size();
  std::unique_ptr<render::Renderer> renderer;
  std::unique_ptr<render::SceneBuilder> builder;
  start.add([&] {
    renderer = std::make_unique<render::Renderer>(video.video_width, video.video_height);
    builder = std::make_unique<render::SceneBuilder>(model::loadRavenModel(config), model::loadSceneModel(config),
                                                     config.haptics, renderer.get());
    renderer->draw(builder->build(frames.at(0)),
                   model::makeCamera(video.cameras.at(0), video.video_width, video.video_height));
  });
  const auto named = [&](const std::string& name) -> const CameraConfig& {
    return *std::find_if(video.cameras.begin(), video.cameras.end(), [&](const auto& c) { return c.name == name; });
  };
  const model::Camera camera = model::makeCamera(named(video.video_camera), video.video_width, video.video_height);
  const model::Camera inset =
      model::makeCamera(named("endoscope"), video.video_width * 3 / 10, video.video_height * 3 / 10);
  const std::string file =
      (std::filesystem::temp_directory_path() / ("bench_" + std::to_string(getpid()) + ".mp4")).string();
  const double coding_begin = childSeconds(), begin = seconds(CLOCK_MONOTONIC);
  frames.resize(std::min(limit, in_log));
  {
    render::VideoWriter writer(file, video);
    for (const render::Snapshot& frame : frames) {
      const render::Scene* scene = nullptr;
      const std::vector<std::uint8_t>* rgb = nullptr;
      build.add([&] { scene = &builder->build(frame); });
      draw.add([&] { rgb = &renderer->draw(*scene, camera, &inset); });
      encode.add([&] { writer.write(*rgb); });
    }
    encode.add([&] { writer.finish(); });
  }
  const double wall = seconds(CLOCK_MONOTONIC) - begin;
  std::filesystem::remove(file);
  std::printf("%dx%d, %zu of %zu frames\n", video.video_width, video.video_height, frames.size(), in_log);
  start.print(1);
  state.print(in_log);
  for (const Stage* stage : {&build, &draw, &encode})
    stage->print(frames.size());
  const double per_frame = 1e3 / static_cast<double>(frames.size());
  std::printf("%-28s %8s         %8.2f ms of a processor\n", "encode (ffmpeg's process)", "",
              (childSeconds() - coding_begin) * per_frame);
  rusage used{};
  getrusage(RUSAGE_SELF, &used);
  std::printf("all, one process: %.2f ms a frame, %.2f x real time; at most %.0f MiB\n", wall * per_frame,
              static_cast<double>(frames.size()) / video.video_fps / wall,
              static_cast<double>(used.ru_maxrss) / 1024.0);
  std::printf("drawing, each stage waited for; video, overview with inset:\n");
  benchmarkSplit(frames, camera, &inset, builder.get(), renderer.get());
  std::printf("the same as a live picture, endoscope alone:\n");
  const model::Camera live = model::makeCamera(named("endoscope"), video.video_width, video.video_height);
  benchmarkLive(frames, live, builder.get(), renderer.get());
  benchmarkSplit(frames, live, nullptr, builder.get(), renderer.get());
}

}  // namespace

int main(int argc, char** argv) {
  if (argc > 1) {
    benchmarkVideo(argv[1], argc > 2 ? std::strtoul(argv[2], nullptr, 10) : 300);
    return 0;
  }
  const TrainerConfig config = config::loadTrainerConfig(RAVEN2_TRAINER_SOURCE_DIR "/config/trainer.yaml");
  const model::RavenModel raven = model::loadRavenModel(config);
  const model::SceneModel scene = model::loadSceneModel(config);
  const int width = config.render.live_width, height = config.render.live_height;
  render::Renderer renderer(width, height);
  render::SceneBuilder builder(raven, scene, config.haptics, &renderer);
  for (const CameraConfig& named : config.render.cameras) {
    const model::Camera camera = model::makeCamera(named, width, height);
    const render::Snapshot without = atHome(config, scene);
    render::Snapshot with = without;
    render::setPlan(render::makePlan(config.arms.geometry, Arm::kGold), PlanningStatus::kExecuting, &with);
    with.model.mode = Mode::kExecuting;
    with.model.arms[0].q_d = with.plans.path->waypoints[1];
    std::vector<double> times[2];
    for (int i = 0; i < 2 * kFrames; ++i) {
      const auto begin = std::chrono::steady_clock::now();
      renderer.draw(builder.build(i % 2 == 0 ? without : with), camera);
      const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - begin;
      times[i % 2].push_back(took.count());
    }
    const double plain = median(times[0]), planned = median(times[1]);
    std::printf("%-12s %dx%d  without %6.2f ms  with a plan %6.2f ms  ratio %.3f\n", named.name.c_str(), width, height,
                plain, planned, planned / plain);
  }
}
