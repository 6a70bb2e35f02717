#include "raven2_trainer/planning/path_planner.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "planning/free_volume.h"
#include "planning/motion_cost.h"
#include "planning/plan_run.h"
#include "planning/poll.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"

namespace raven2_trainer::planning {
namespace {

/** [m] how far the least distance of a followed path is reported. */
constexpr double kFollowedRange = 0.05;

void reset(PlanProgress* progress) {
  progress->samples.store(0);
  progress->edges.store(0);
  progress->rollouts.store(0);
  progress->best_cost.store(0.0);
}

/** @throw std::invalid_argument. */
void demandFinite(const std::vector<JointArray>& waypoints, const JointArray& other) {
  const auto is_finite = [](const JointArray& q) {
    return std::all_of(q.begin(), q.end(), [](double x) { return std::isfinite(x); });
  };
  if (waypoints.empty()) throw std::invalid_argument("0 waypoints, expected at least one");
  if (!is_finite(other) || !std::all_of(waypoints.begin(), waypoints.end(), is_finite))
    throw std::invalid_argument("joints: not a finite number");
}

bool areSound(const PlanOptions& o) {
  const std::array<double, 4> numbers{o.eta_length, o.eta_acceleration, o.eta_clearance, o.time_limit};
  const bool known = std::count(kPlannerNames.begin(), kPlannerNames.end(), o.planner) > 0;
  return known && std::all_of(numbers.begin(), numbers.end(), [](double x) { return x >= 0.0 && x < 1e9; });
}

/** The rest of the whole time is the search: costs and edge checks. */
void setSearchTime(double whole, PlanStatistics* s) {
  s->search_time = whole - s->goal_time - s->sampling_time - s->neighbour_time - s->improvement_time - s->rollout_time;
}

/** In lockstep the result must not depend on the machine. */
void clearTimes(PlanStatistics* s) {
  s->goal_time = s->sampling_time = s->neighbour_time = s->search_time = s->improvement_time = s->rollout_time = 0.0;
}

PlanResult failure(const PlanRequest& request, const std::atomic<bool>& cancel) {
  PlanResult result;
  result.id = request.id;
  result.arm = request.arm;
  result.status = cancel.load() ? PlanStatus::kCancelled : PlanStatus::kFailed;
  return result;
}

void giveUpIf(const std::atomic<bool>& cancel) {
  if (cancel.load()) throw std::runtime_error("the planner's preparation was given up");
}

}  // namespace

bool takesSamples(const std::string& planner) {
  return planner == "FMTstar" || planner == "FMT";
}

bool reportsSamples(const std::string& planner) {
  return planner == "FMTstar";
}

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

/** Data that is computed once for a scene. */
struct PathPlanner::SceneCache {
  SceneCache(const model::RavenModel& raven,
             const model::SceneModel& scene,
             const SceneObstacles& obstacles,
             const PlannerConfig& config,
             const ModelConfig* model,
             const std::atomic<bool>& cancel)
      : grid(raven, scene, [&cancel] { giveUpIf(cancel); }),
        gold(makeArm(raven, obstacles, config, model, cancel, Arm::kGold)),
        green(makeArm(raven, obstacles, config, model, cancel, Arm::kGreen)) {
    // From now on both keep their addresses.
    for (ArmPlanning* each : {&gold, &green}) {
      if (each->roll_out == nullptr) continue;
      ArmChecks* checks = &each->checks;
      each->roll_out->useClearance([checks](const JointArray& q) { return checks->clearance(q, kFollowedRange); });
    }
  }

  ArmPlanning makeArm(const model::RavenModel& raven,
                      const SceneObstacles& obstacles,
                      const PlannerConfig& config,
                      const ModelConfig* model,
                      const std::atomic<bool>& cancel,
                      Arm arm) const {
    const Poll poll = [&cancel] { giveUpIf(cancel); };
    ArmPlanning planning{ArmChecks(raven, obstacles, grid, arm, config.clearance, config.edge_step, poll), nullptr};
    poll();
    if (model != nullptr) planning.roll_out = std::make_unique<RollOut>(raven, obstacles, *model, arm);
    planning.free_volume = estimateVolume(raven.arms.geometry, config, cancel, &planning.checks);
    return planning;
  }

  /** With the jaws as at home, and the other arm there. An upper bound: the radius grows with it. */
  static double estimateVolume(const ArmGeometry& geometry,
                               const PlannerConfig& config,
                               const std::atomic<bool>& cancel,
                               ArmChecks* checks) {
    constexpr std::uint64_t kVolumeSeed = 1;  // of the scene, not of a plan: the same for all of them
    checks->begin(JointSpace(geometry, kinematics::jawOpening(geometry.home)), geometry.home);
    const auto is_free = [&](const UnitState& unit) {
      giveUpIf(cancel);
      return checks->isFree(unit);
    };
    return estimateFreeVolume(is_free, config.volume_samples, kVolumeSeed, config.volume_confidence).upper;
  }

  const DistanceGrid grid;
  ArmPlanning gold, green;
};

struct PathPlanner::Impl {
  Impl(const model::RavenModel& raven_model,
       const model::SceneModel& scene_model,
       const PlannerConfig& planner_config,
       const ModelConfig* model_config)
      : raven(raven_model),
        scene(scene_model),
        config(planner_config),
        obstacles(scene),
        gold(raven, obstacles, Arm::kGold, config.clearance),
        green(raven, obstacles, Arm::kGreen, config.clearance) {
    if (model_config != nullptr) model = *model_config;
  }

  SceneCache& prepared(const std::atomic<bool>& cancel) {
    const ModelConfig* dynamics = model ? &*model : nullptr;
    if (!cache) cache = std::make_unique<SceneCache>(raven, scene, obstacles, config, dynamics, cancel);
    return *cache;
  }
  SceneCache* tryToPrepare(const std::atomic<bool>& cancel) noexcept {
    try {
      return &prepared(cancel);
    } catch (const std::exception&) {
      return nullptr;
    }
  }
  ArmCollision& bareJudge(Arm arm) {
    std::unique_ptr<ArmCollision>& judge = at(bare, arm);
    if (judge == nullptr) judge = std::make_unique<ArmCollision>(raven, obstacles, arm, 0.0);
    return *judge;
  }
  ArmCollision& judge(Arm arm) { return arm == Arm::kGold ? gold : green; }
  PlanResult run(const PlanSetting& setting, const std::atomic<bool>& cancel, PlanStatistics* statistics);

  const model::RavenModel& raven;
  const model::SceneModel scene;
  const PlannerConfig config;
  std::optional<ModelConfig> model;
  SceneObstacles obstacles;
  ArmCollision gold, green;                      // with the clearance
  PerArm<std::unique_ptr<ArmCollision>> bare{};  // without; made when first needed
  std::unique_ptr<SceneCache> cache;
  PlanProgress progress;
};

PlanResult PathPlanner::Impl::run(const PlanSetting& setting,
                                  const std::atomic<bool>& cancel,
                                  PlanStatistics* statistics) {
  try {
    PlanRun run(setting);
    const PlanResult result = run.run();
    *statistics = run.statistics();
    return result;
  } catch (const std::exception&) {
    // OMPL, FCL or the heap gave up: the caller gets no path, and nothing incomplete.
    return failure(setting.request, cancel);
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
  const bool repeats = !lockstep || options.planner != "PRMstar";  // it searches in its own thread
  SceneCache* cache = repeats && areSound(options) ? impl_->tryToPrepare(cancel) : nullptr;
  if (cache == nullptr) return failure(request, cancel);
  const Clock::time_point begin = Clock::now();
  reset(&impl_->progress);
  const PlanSetting setting{impl_->raven,
                            impl_->config,
                            {&cache->gold, &cache->green},
                            request,
                            options,
                            seed,
                            lockstep,
                            [&cancel] { return cancel.load(); },
                            [&] { return !lockstep && secondsSince(begin) > options.time_limit; },
                            &impl_->progress};
  PlanStatistics counted;
  PlanResult result = impl_->run(setting, cancel, &counted);
  result.samples = counted.samples;
  if (!lockstep) result.planning_time = secondsSince(begin);
  setSearchTime(result.planning_time, &counted);
  if (lockstep) clearTimes(&counted);
  if (statistics != nullptr) *statistics = counted;
  return result;
}

void PathPlanner::prepare(const std::atomic<bool>& cancel) {
  impl_->prepared(cancel);
}

void PathPlanner::prepare() {
  prepare(std::atomic<bool>{false});
}

const PlanProgress& PathPlanner::progress() const noexcept {
  return impl_->progress;
}

bool PathPlanner::inCollision(Arm arm, const JointArray& q, const JointArray& other) const {
  ArmCollision& judge = impl_->judge(arm);
  judge.placeOther(other);
  return judge.touches(q);
}

double PathPlanner::clearance(Arm arm, const JointArray& q, const JointArray& other, double cap) const {
  ArmCollision& judge = impl_->bareJudge(arm);
  judge.placeOther(other);
  return judge.distance(q, cap);
}

FollowedPath PathPlanner::rollOut(Arm arm,
                                  const std::vector<JointArray>& waypoints,
                                  const JointArray& other,
                                  const std::atomic<bool>& cancel) {
  demandFinite(waypoints, other);
  if (!impl_->model) throw std::runtime_error("this planner has no simulated arm");
  SceneCache& cache = impl_->prepared(cancel);
  ArmPlanning& planning = arm == Arm::kGold ? cache.gold : cache.green;
  planning.checks.begin(JointSpace(impl_->raven.arms.geometry, kinematics::jawOpening(waypoints.front())), other);
  FollowedPath path;
  path.arrival = {0.0};
  for (std::size_t i = 1; i < waypoints.size(); ++i)
    path.arrival.push_back(path.arrival.back() + edgeDuration(impl_->config, waypoints[i - 1], waypoints[i]));
  const RollOutReport report =
      planning.roll_out->follow(waypoints, path.arrival, other, [&cancel] { return cancel.load(); });
  if (report.stopped) throw std::runtime_error("cancelled");
  if (report.broken) throw std::runtime_error("ODE's solver gave up");
  path.free = report.free;
  path.failed_edge = report.failed_edge;
  path.clearance = report.clearance;
  path.tracking_error = report.tracking_error;
  path.duration = report.duration;
  return path;
}

double PathPlanner::edgeCost(Arm arm, const JointArray& a, const JointArray& b) const {
  const PlannerConfig& c = impl_->config;
  const JointSpace space(impl_->raven.arms.geometry, kinematics::jawOpening(a));
  const MotionCost cost(impl_->raven.arms.geometry, arm, space, c, {c.eta_length, c.eta_acceleration, 0.0, 1.0}, {});
  return cost.plain(space.toUnit(a), space.toUnit(b));
}

}  // namespace raven2_trainer::planning
