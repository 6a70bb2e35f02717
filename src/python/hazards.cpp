// Hazards of a simulation for a program.

#include <algorithm>
#include <mutex>
#include <stdexcept>
#include <string>

#include "python/simulation.h"
#include "raven2_trainer/config/load_config.h"

namespace raven2_trainer::python {

void demandRobotFor(const TrainerConfig& config, const std::string& hazard, bool has_robot) {
  const std::uint32_t id = config::faultId(config, hazard);
  if (has_robot || id == 0) return;
  const std::vector<Fault>& rows = config.scenarios[id - 1].faults;
  const bool acts = std::any_of(rows.begin(), rows.end(), [](const Fault& row) {
    return row.host == FaultHost::kMaster || row.host == FaultHost::kConsole;
  });
  if (!acts)
    throw std::invalid_argument("hazard " + hazard +
                                " acts on the robot, and robot is \"none\": take robot=\"virtual\"");
}

void Simulation::inject(const std::string& hazard) {
  const std::lock_guard<std::recursive_mutex> lock(mutex_);
  demandOpen();
  FaultRequest request;
  request.order = FaultOrder::kArmAtOnce;
  request.fault_id = config::faultId(config_, hazard);
  if (request.fault_id == 0) throw std::invalid_argument("inject: \"none\" is no hazard; clear_hazards() ends all");
  demandRobotFor(config_, hazard, has_robot_);
  const std::size_t rows = config_.scenarios[request.fault_id - 1].faults.size();
  const FaultPlan armed = stack_->shared()->faults.load();
  const auto end = armed.faults.begin() + (asked_.all_cleared ? 0 : armed.count);
  const auto others = static_cast<std::size_t>(
      std::count_if(armed.faults.begin(), end, [&](const Fault& row) { return row.id != request.fault_id; }));
  if (others + asked_.rows + rows > kMaxFaults)
    throw std::runtime_error("inject: " + std::to_string(others + asked_.rows) + " of " + std::to_string(kMaxFaults) +
                             " rows of hazards are armed, also of those that have ended, and " + hazard + " has " +
                             std::to_string(rows) + ": call clear_hazards() first");
  ask(request);
  asked_.rows += rows;
}

void Simulation::ask(const FaultRequest& request) {
  if (!stack_->shared()->fault_requests.tryPush(request))
    throw std::runtime_error("too many requests about hazards in one tick: step first");
}

void Simulation::clearHazards() {
  const std::lock_guard<std::recursive_mutex> lock(mutex_);
  demandOpen();
  FaultRequest request;
  request.order = FaultOrder::kClear;
  ask(request);
  asked_ = {0, true};
}

}  // namespace raven2_trainer::python
