#include "raven2_trainer/runtime/planner_worker.h"

#include <exception>

#include "raven2_trainer/control/tip_path.h"

namespace raven2_trainer::runtime {

PlannerWorker::PlannerWorker(const TrainerConfig& config,
                             const model::RavenModel& raven,
                             const model::SceneModel& scene,
                             SharedState* shared)
    : planner_(raven, scene, config.planner, config.model), arms_(config.arms), shared_(*shared), seed_(config.seed) {}

void PlannerWorker::prepare() noexcept {
  try {
    planner_.prepare();
  } catch (const std::exception&) {
  }
}

bool PlannerWorker::serve() {
  PlanRequest request;
  if (!shared_.plan_requests.tryPop(&request)) return false;
  const PlanResult result = planner_.plan(request, seed_, /*lockstep=*/false, cancel_);
  publishPath(result);
  shared_.plan_results.tryPush(result);
  return true;
}

PlanResult PlannerWorker::planNow(const PlanRequest& request) {
  const PlanResult result = planner_.plan(request, seed_, /*lockstep=*/true, cancel_);
  publishPath(result);
  return result;
}

/** Before the plan itself: whoever learns of the plan finds its path. */
void PlannerWorker::publishPath(const PlanResult& result) {
  if (result.status == PlanStatus::kSuccess) shared_.guide_path.store(control::tipPath(arms_.geometry, result));
}

}  // namespace raven2_trainer::runtime
