#pragma once

#include <atomic>

#include "raven2_trainer/control/path_relay.h"
#include "raven2_trainer/loop/loop_config.h"
#include "raven2_trainer/loop/plan_counts.h"
#include "raven2_trainer/loop/shared_state.h"
#include "raven2_trainer/planning/path_planner.h"

namespace raven2_trainer::loop {

/** Body of the planner thread. It allocates and has no time bound: never on a real-time thread. */
class PlannerWorker {
 public:
  PlannerWorker(const LoopConfig& config,
                const model::RavenModel& raven,
                const model::SceneModel& scene,
                SharedState* shared);

  /** Computes the scene's data before the first plan, in some tenths of a second. The first plan reports errors. */
  void prepare() noexcept;

  /** Serves one waiting request. @return true if there was one. */
  bool serve();
  /** For shutdown: cancels the running plan within 100 ms, and all later ones. Any thread. A flag in
   *  SharedState::plan_cancelled cancels a single plan as fast. */
  void cancel() noexcept;
  /** Any thread. */
  PlanCounts counts() const noexcept;

  /** Lockstep: plans at once; the caller delivers the result a fixed number of ticks later. */
  PlanResult planNow(const PlanRequest& request);

 private:
  PlanResult plan(const PlanRequest& request, bool lockstep);
  void publishPath(const PlanResult& result);

  planning::PathPlanner planner_;
  const ArmsConfig arms_;
  const control::IncrementLimits limits_;  ///< of a packet to the robot
  const PerArm<control::ArmController> laws_;
  SharedState& shared_;
  std::uint64_t seed_;
  std::atomic<bool> ended_{false};
};

}  // namespace raven2_trainer::loop
