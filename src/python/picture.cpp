#include "python/picture.h"

#include <unistd.h>

#include <atomic>
#include <list>
#include <memory>

#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/model/camera.h"
#include "raven2_trainer/render/picture_line.h"
#include "raven2_trainer/render/renderer.h"

namespace raven2_trainer::python {
namespace {

constexpr std::size_t kMostStages = 8;  ///< on a thread; some 30 MB each

struct Stage {
  Stage(const Simulation& simulation, int width, int height)
      : number(simulation.number()),
        renderer(width, height),
        builder(simulation.raven(),
                simulation.scene(),
                render::SceneOptions(simulation.config(), OverlaySet()),
                &renderer) {}

  std::uint64_t number;
  render::Renderer renderer;
  render::SceneBuilder builder;
};

/** Of one thread. In a process that was forked they stay: to destroy them the drawing library would wait for its
 * threads. */
class Stages {
 public:
  Stages() = default;
  ~Stages() {
    if (getpid() != process_) static_cast<void>(list_.release());
  }
  Stages(const Stages&) = delete;
  Stages& operator=(const Stages&) = delete;
  std::list<Stage>* operator->() const noexcept { return list_.get(); }

 private:
  const pid_t process_{getpid()};
  std::unique_ptr<std::list<Stage>> list_{std::make_unique<std::list<Stage>>()};
};

/** The drawing library's threads are not in a process that was forked: it would wait for them for ever. */
void demandFirstProcess() {
  static std::atomic<pid_t> first{0};
  pid_t drawn_by = 0;
  if (first.compare_exchange_strong(drawn_by, getpid()) || drawn_by == getpid()) return;
  throw RenderException(
      "the process that this one was forked from has drawn pictures: start processes that draw with spawn");
}

/** That of this simulation and size on this thread; the one that waited longest makes room. */
Stage& stageFor(const Simulation& simulation, int width, int height) {
  static thread_local const Stages stages;
  for (auto it = stages->begin(); it != stages->end(); ++it) {
    if (it->number != simulation.number() || it->renderer.width() != width || it->renderer.height() != height) continue;
    stages->splice(stages->begin(), *stages.operator->(), it);
    return stages->front();
  }
  if (stages->size() >= kMostStages) stages->pop_back();
  return stages->emplace_front(simulation, width, height);
}

/** draw(renderer, scene, camera) of the state that the surgeon sees. */
template <typename Draw>
auto withScene(Simulation& simulation, const std::string& camera, int width, int height, Draw draw) {
  const CameraConfig& config = model::requireCamera(simulation.config().render.cameras, camera);
  demandFirstProcess();
  Stage& stage = stageFor(simulation, width, height);
  const std::lock_guard<std::recursive_mutex> lock(simulation.mutex());
  const render::Snapshot snapshot = simulation.passPicture();
  const render::Scene& scene = stage.builder.build(snapshot);
  return draw(&stage.renderer, scene, render::cameraSeeing(snapshot, config, simulation.raven().X_WB, width, height));
}

}  // namespace

std::vector<std::uint8_t> drawPicture(Simulation& simulation, const std::string& camera, int width, int height) {
  return withScene(simulation, camera, width, height,
                   [](render::Renderer* renderer, const render::Scene& scene, const model::Camera& seen) -> std::vector<std::uint8_t> {
                     return renderer->draw(scene, seen);
                   });
}

render::Geometry measurePicture(Simulation& simulation, const std::string& camera, int width, int height) {
  return withScene(simulation, camera, width, height,
                   [](render::Renderer* renderer, const render::Scene& scene, const model::Camera& seen) {
                     return renderer->measure(scene, seen);
                   });
}

}  // namespace raven2_trainer::python
