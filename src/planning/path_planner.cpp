#include "raven2_trainer/planning/path_planner.h"

#include <algorithm>
#include <chrono>

#include "planning/plan_run.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"

namespace raven2_trainer::planning {
namespace {

using Clock = std::chrono::steady_clock;

double secondsSince(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

void reset(PlanProgress* progress) {
  progress->samples.store(0);
  progress->edges.store(0);
  progress->rollouts.store(0);
  progress->best_cost.store(0.0);
}

bool isKnown(const std::string& planner) {
  return std::count(kPlannerNames.begin(), kPlannerNames.end(), planner) > 0;
}

/** What is left of the whole is the search's own: costs and edge checks. */
void setSearchTime(double whole, PlanStatistics* s) {
  s->search_time = whole - s->goal_time - s->sampling_time - s->neighbour_time - s->improvement_time - s->rollout_time;
}

/** In lockstep nothing may tell one machine from another. */
void clearTimes(PlanStatistics* s) {
  s->goal_time = s->sampling_time = s->neighbour_time = s->search_time = s->improvement_time = s->rollout_time = 0.0;
}

}  // namespace

PlanOptions defaultOptions(const PlannerConfig& config) {
  PlanOptions options;
  options.planner = config.planner;
  options.samples = config.samples;
  options.max_samples = config.max_samples;
  options.improve_attempts = config.improve_attempts;
  options.eta_length = config.eta_length;
  options.eta_acceleration = config.eta_acceleration;
  options.eta_clearance = config.eta_clearance;
  options.time_limit = config.time_limit;
  return options;
}

struct PathPlanner::Impl {
  Impl(const model::RavenModel& raven_model,
       const model::SceneModel& scene_model,
       const PlannerConfig& planner_config,
       const ModelConfig* model)
      : raven(raven_model),
        config(planner_config),
        obstacles(scene_model),
        gold(makeDesk(Arm::kGold, model)),
        green(makeDesk(Arm::kGreen, model)) {}

  ArmDesk makeDesk(Arm arm, const ModelConfig* model) {
    ArmDesk desk{ArmChecks(raven, obstacles, arm, config.clearance, config.edge_step), nullptr};
    if (model != nullptr) desk.roll_out = std::make_unique<RollOut>(raven, obstacles, *model, arm);
    return desk;
  }

  ArmDesk& desk(Arm arm) { return arm == Arm::kGold ? gold : green; }
  PlanResult run(const PlanSetting& setting, PlanStatistics* statistics);

  const model::RavenModel& raven;
  const PlannerConfig config;
  SceneObstacles obstacles;
  ArmDesk gold, green;
  PlanProgress progress;
};

PlanResult PathPlanner::Impl::run(const PlanSetting& setting, PlanStatistics* statistics) {
  PlanResult failed;
  failed.arm = setting.request.arm;
  failed.status = PlanStatus::kFailed;
  if (!isKnown(setting.options.planner)) return failed;
  try {
    PlanRun run(setting);
    const PlanResult result = run.run();
    *statistics = run.statistics();
    return result;
  } catch (const std::exception&) {
    // OMPL, FCL or the heap gave up: for who asked, there is no path. Nothing half-made is returned.
    return failed;
  }
}

PathPlanner::PathPlanner(const model::RavenModel& raven, const model::SceneModel& scene, const PlannerConfig& config)
    : impl_(std::make_unique<Impl>(raven, scene, config, nullptr)) {}

PathPlanner::PathPlanner(const model::RavenModel& raven,
                         const model::SceneModel& scene,
                         const PlannerConfig& config,
                         const ModelConfig& model)
    : impl_(std::make_unique<Impl>(raven, scene, config, &model)) {}

PathPlanner::~PathPlanner() = default;

PlanResult PathPlanner::plan(const PlanRequest& request,
                             std::uint64_t seed,
                             bool lockstep,
                             const std::atomic<bool>& cancel) {
  return plan(request, seed, lockstep, cancel, defaultOptions(impl_->config));
}

PlanResult PathPlanner::plan(const PlanRequest& request,
                             std::uint64_t seed,
                             bool lockstep,
                             const std::atomic<bool>& cancel,
                             const PlanOptions& options,
                             PlanStatistics* statistics) {
  const Clock::time_point begin = Clock::now();
  reset(&impl_->progress);
  const PlanSetting setting{impl_->raven,
                            impl_->config,
                            {&impl_->gold, &impl_->green},
                            request,
                            options,
                            seed,
                            lockstep,
                            [&cancel] { return cancel.load(); },
                            [&] { return !lockstep && secondsSince(begin) > options.time_limit; },
                            &impl_->progress};
  PlanStatistics counted;
  PlanResult result = impl_->run(setting, &counted);
  result.id = request.id;
  result.samples = counted.samples;
  if (!lockstep) result.planning_time = secondsSince(begin);
  setSearchTime(result.planning_time, &counted);
  if (lockstep) clearTimes(&counted);
  if (statistics != nullptr) *statistics = counted;
  return result;
}

const PlanProgress& PathPlanner::progress() const noexcept {
  return impl_->progress;
}

bool PathPlanner::inCollision(Arm arm, const JointArray& q, const JointArray& other) const {
  return impl_->desk(arm).checks.isNear(q, other);
}

double PathPlanner::edgeCost(Arm arm, const JointArray& a, const JointArray& b) const {
  const PlannerConfig& c = impl_->config;
  const JointSpace space(impl_->raven.arms.geometry, kinematics::jawOpening(a));
  const MotionCost cost(impl_->raven.arms.geometry, arm, space, c, {c.eta_length, c.eta_acceleration, 0.0, 1.0}, {});
  return cost.plain(space.toUnit(a), space.toUnit(b));
}

}  // namespace raven2_trainer::planning
