#include "raven2_trainer/runtime/planner_worker.h"

namespace raven2_trainer::runtime {

PlannerWorker::PlannerWorker(const TrainerConfig& config,
                             const model::RavenModel& raven,
                             const model::SceneModel& scene,
                             SharedState* shared)
    : planner_(raven, scene, config.planner), shared_(*shared), seed_(config.seed) {}

bool PlannerWorker::serve() {
  PlanRequest request;
  if (!shared_.plan_requests.tryPop(&request)) return false;
  shared_.plan_results.tryPush(planner_.plan(request, seed_, /*lockstep=*/false, cancel_));
  return true;
}

PlanResult PlannerWorker::planNow(const PlanRequest& request) {
  return planner_.plan(request, seed_, /*lockstep=*/true, cancel_);
}

}  // namespace raven2_trainer::runtime
