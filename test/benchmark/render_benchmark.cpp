// What a plan costs in a live picture: frames with and without it in turn, so that both see the same machine.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/render/renderer.h"
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

}  // namespace

int main() {
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
