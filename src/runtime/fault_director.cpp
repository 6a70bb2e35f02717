#include "raven2_trainer/runtime/fault_director.h"

#include "raven2_trainer/config/load_config.h"

namespace raven2_trainer::runtime {

FaultDirector::FaultDirector(const TrainerConfig& config, SharedState* shared)
    : config_(config), shared_(*shared), plan_(config::planFor(config, config::faultId(config, config.hazard), 1)) {
  shared_.faults.store(plan_);
}

void FaultDirector::tick() {
  FaultRequest request;
  while (shared_.fault_requests.tryPop(&request))
    apply(request);
}

void FaultDirector::apply(const FaultRequest& request) {
  FaultPlan next = plan_;
  next.count = 0;
  for (std::size_t i = 0; i < plan_.count; ++i) {
    const bool cleared = request.fault_id == 0 || plan_.faults[i].id == request.fault_id;
    if (!cleared) next.faults[next.count++] = plan_.faults[i];
  }
  const FaultPlan added = config::planFor(config_, request.fault_id, 0);
  const bool fits = next.count + added.count <= kMaxFaults;  // a scenario is armed whole or not at all
  for (std::size_t i = 0; request.start != 0 && fits && i < added.count; ++i)
    next.faults[next.count++] = added.faults[i];
  ++next.generation;
  plan_ = next;
  shared_.faults.store(plan_);
}

}  // namespace raven2_trainer::runtime
