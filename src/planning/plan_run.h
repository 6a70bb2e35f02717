#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <vector>

#include "planning/arm_checks.h"
#include "planning/arm_choice.h"
#include "planning/path_search.h"
#include "planning/roll_out.h"
#include "raven2_trainer/planning/path_planner.h"
#include "raven2_trainer/planning/planner_config.h"

namespace raven2_trainer::planning {

/** Data of one arm in one scene, kept from plan to plan. */
struct ArmPlanning {
  ArmChecks checks;
  std::unique_ptr<RollOut> roll_out;  ///< nullptr: paths are not followed
  double free_volume{1.0};            ///< [-] of the unit cube, upper bound
};

/** Inputs of one plan. */
struct PlanSetting {
  const model::RavenModel& raven;
  const PlannerConfig& config;
  PerArm<ArmPlanning*> arms;
  const PlanRequest& request;
  const PlanOptions& options;
  std::uint64_t seed{};
  bool lockstep{};
  std::function<bool()> is_cancelled;
  std::function<bool()> is_late;  ///< the time limit
  PlanProgress* progress{};
};

/** One plan: choice of arm and goal, search, improvement, roll-out. Used once. */
class PlanRun {
 public:
  explicit PlanRun(const PlanSetting& setting);

  /** Status and path; samples and time are left to the caller. */
  PlanResult run();
  const PlanStatistics& statistics() const { return statistics_; }

 private:
  using Clock = std::chrono::steady_clock;

  bool isOver() const { return set_.is_cancelled() || set_.is_late(); }
  ArmPlanning& planningOf(Arm arm) const { return *at(set_.arms, arm); }
  const JointArray& startOf(Arm arm) const;
  const JointArray& otherOf(Arm arm) const;

  bool isWithinLimits(Arm arm) const;
  ArmProspect prospect(Arm arm);
  GoalChoice goalOf(Arm arm, const JointSpace& space, const UnitState& start);
  PlanStatus choose();
  void search(PlanResult* result);
  SearchOrder order();
  std::shared_ptr<const MotionCost> makeCost(double eta_clearance) const;
  PathVerdict judge(const std::vector<UnitState>& path);
  std::vector<UnitState> improve(const std::vector<UnitState>& path);
  RollOutReport follow(const std::vector<UnitState>& path);
  void keep(const std::vector<UnitState>& path, const RollOutReport& report);
  void fill(PlanResult* result) const;
  std::vector<JointArray> waypointsOf(const std::vector<UnitState>& path) const;
  std::vector<double> arrivalOf(const std::vector<JointArray>& waypoints) const;
  double plainCost(const std::vector<UnitState>& path) const;
  void record(const SearchOutcome& outcome);

  const PlanSetting set_;
  Arm arm_;
  JointSpace space_;
  UnitState start_{}, goal_{};
  std::shared_ptr<const MotionCost> cost_;
  std::vector<UnitState> kept_;  // the path to be returned
  RollOutReport report_;         // of it
  PlanStatistics statistics_;
};

}  // namespace raven2_trainer::planning
