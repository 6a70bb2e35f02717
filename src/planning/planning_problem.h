#pragma once

#include <ompl/base/OptimizationObjective.h>
#include <ompl/base/ProblemDefinition.h>
#include <ompl/base/SpaceInformation.h>

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <vector>

#include "planning/joint_space.h"
#include "planning/motion_cost.h"

// One problem as OMPL sees it: any of its planners can be put to it.

namespace raven2_trainer::planning {

/** A planner's questions to the robot; nothing here knows arms or shapes. */
struct PlanningTask {
  UnitState start{}, goal{};
  std::function<bool(const UnitState&)> is_free;
  std::function<bool(const UnitState&, const UnitState&)> is_edge_free;
  std::shared_ptr<const MotionCost> cost;
  std::function<bool()> stop;  ///< polled; true gives up
  std::uint64_t seed{};
};

/** Counts of the questions to the robot. */
struct PlanningCounts {
  std::uint64_t draws{}, state_checks{}, edge_checks{}, cost_evaluations{}, clearance_integrals{};
};

UnitState fromOmpl(const ompl::base::State* state);
void toOmpl(const UnitState& unit, ompl::base::State* state);

/** Thrown by the objective when `stop` says so: between two polls OMPL's FMT computes millions of costs.
 */
struct Stopped {};

/** The cost of an edge as an objective: additive, because the arm rests at every waypoint. */
class MotionObjective : public ompl::base::OptimizationObjective {
 public:
  /** @param[in] serial held while the task is asked: PRM* asks from two threads. */
  MotionObjective(const ompl::base::SpaceInformationPtr& si,
                  const PlanningTask& task,
                  PlanningCounts* counts,
                  std::mutex* serial);

  ompl::base::Cost stateCost(const ompl::base::State* state) const override;
  ompl::base::Cost motionCost(const ompl::base::State* a, const ompl::base::State* b) const override;
  /** eta1 x length: never more than the cost of any path between the two, edges in between allowed. */
  ompl::base::Cost motionCostHeuristic(const ompl::base::State* a, const ompl::base::State* b) const override;

  const MotionCost& cost() const { return *task_.cost; }
  PlanningCounts& counts() const { return *counts_; }  ///< but draws
  void throwWhenStopped() { throws_ = true; }

 private:
  const PlanningTask& task_;
  PlanningCounts* counts_;
  std::mutex* serial_;
  bool throws_{false};
};

/**
 * The unit cube with samples from core/random.h (OMPL's generator is seeded for the whole process), validity of
 * states and of straight edges by the task, and the cost. `task` must outlive it.
 */
class PlanningProblem {
 public:
  explicit PlanningProblem(const PlanningTask& task);
  PlanningProblem(const PlanningProblem&) = delete;
  PlanningProblem& operator=(const PlanningProblem&) = delete;
  ~PlanningProblem();

  const ompl::base::SpaceInformationPtr& space() const { return space_; }
  const ompl::base::ProblemDefinitionPtr& definition() const { return definition_; }
  /** Samples drawn; may be asked while a planner runs, which PRM* does from its second thread. */
  std::uint64_t draws() const { return draws_.load(std::memory_order_relaxed); }
  /** Once no planner runs any longer. */
  PlanningCounts counts() const;

  /** An edge on which the dynamics failed: not free from now on. */
  void block(const UnitState& a, const UnitState& b);

  /** Lets the cost function throw Stopped. Not where a planner has its own threads. */
  void throwWhenStopped() { objective_->throwWhenStopped(); }

 private:
  class EdgeValidator;

  std::atomic<std::uint64_t> draws_{0};
  PlanningCounts counts_;  ///< but draws
  std::mutex serial_;
  std::shared_ptr<EdgeValidator> validator_;
  std::shared_ptr<MotionObjective> objective_;
  ompl::base::SpaceInformationPtr space_;
  ompl::base::ProblemDefinitionPtr definition_;
};

/** True if the straight edge is free: both ends and points at most `step` apart, coarse to fine. */
bool isEdgeFree(const UnitState& a,
                const UnitState& b,
                double step,
                const std::function<bool(const UnitState&)>& is_valid);

/** The solution of a definition, empty without one. */
std::vector<UnitState> readPath(const ompl::base::ProblemDefinition& definition);

}  // namespace raven2_trainer::planning
