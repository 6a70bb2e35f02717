#include "raven2_trainer/loop/planner_worker.h"

#include <exception>

#include "loop/plan_cancelled.h"
#include "raven2_trainer/control/tip_path.h"

namespace raven2_trainer::loop {

PlannerWorker::PlannerWorker(const LoopConfig& config,
                             const model::RavenModel& raven,
                             const model::SceneModel& scene,
                             SharedState* shared)
    : planner_(raven, scene, config.planner, config.model),
      arms_(config.arms),
      limits_{static_cast<double>(config.itp.max_increment_um), config.itp.max_rotation},
      laws_{control::ArmController(config.model, Arm::kGold), control::ArmController(config.model, Arm::kGreen)},
      shared_(*shared),
      seed_(config.library.seed) {}

/** The end is noted first: a request that physics clears a flag for afterwards is not begun. */
void PlannerWorker::cancel() noexcept {
  ended_.store(true);
  for (std::atomic<bool>& flag : shared_.plan_cancelled)
    flag.store(true);
}

PlanCounts PlannerWorker::counts() const noexcept {
  const planning::PlanProgress& progress = planner_.progress();
  return {progress.samples.load(), progress.edges.load(), progress.rollouts.load(), progress.best_cost.load()};
}

PlanResult PlannerWorker::plan(const PlanRequest& request, bool lockstep) {
  const std::atomic<bool>& cancelled = ended_.load() ? ended_ : planCancelled(&shared_, request.serial);
  PlanResult result = planner_.plan(request, seed_, lockstep, cancelled);
  result.robot_follows = control::robotFollows(arms_.geometry, limits_, at(laws_, result.arm), result) ? 1 : 0;
  publishPath(result);
  return result;
}

void PlannerWorker::prepare() noexcept {
  try {
    planner_.prepare(ended_);
  } catch (const std::exception&) {
  }
}

bool PlannerWorker::serve() {
  PlanRequest request;
  if (!shared_.plan_requests.tryPop(&request)) return false;
  shared_.plan_results.tryPush(plan(request, /*lockstep=*/false));
  return true;
}

PlanResult PlannerWorker::planNow(const PlanRequest& request) {
  return plan(request, /*lockstep=*/true);
}

/** Before the plan itself, so that a reader of the plan finds its path. */
void PlannerWorker::publishPath(const PlanResult& result) {
  if (result.status == PlanStatus::kSuccess) shared_.guide_path.store(control::tipPath(arms_.geometry, result));
}

}  // namespace raven2_trainer::loop
