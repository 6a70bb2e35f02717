#include "raven2_trainer/planning/path_planner.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "planning/arm_collision.h"
#include "planning/fmt_search.h"
#include "planning/goal_search.h"
#include "planning/motion_cost.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"

namespace raven2_trainer::planning {
namespace {

using Clock = std::chrono::steady_clock;

/** [-] how far outside its limits a start may be and still count: the arm settles a little beyond a limit. */
constexpr double kStartSlack = 0.003;

double secondsSince(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

UnitState clampToCube(UnitState unit) {
  for (double& x : unit)
    x = std::clamp(x, 0.0, 1.0);
  return unit;
}

bool isFinite(const JointArray& q) {
  return std::all_of(q.begin(), q.end(), [](double x) { return std::isfinite(x); });
}

}  // namespace

struct PathPlanner::Impl {
  Impl(const model::RavenModel& raven_model, const model::SceneModel& scene_model, const PlannerConfig& planner_config)
      : raven(raven_model),
        config(planner_config),
        obstacles(scene_model),
        gold(raven, obstacles, Arm::kGold, config.clearance),
        green(raven, obstacles, Arm::kGreen, config.clearance) {}

  const ArmGeometry& geometry() const { return raven.arms.geometry; }
  ArmCollision& collision(Arm arm) { return arm == Arm::kGold ? gold : green; }

  void solve(const PlanRequest& request, std::uint64_t seed, const std::function<bool()>& stop, PlanResult* result);
  void fill(const PlanRequest& request, const JointSpace& space, const std::vector<UnitState>& path, PlanResult* out);

  const model::RavenModel& raven;
  const PlannerConfig config;
  SceneObstacles obstacles;
  ArmCollision gold, green;
};

void PathPlanner::Impl::solve(const PlanRequest& request,
                              std::uint64_t seed,
                              const std::function<bool()>& stop,
                              PlanResult* result) {
  const JointSpace space(geometry(), kinematics::jawOpening(request.start));
  ArmCollision& bodies = collision(request.arm);
  bodies.placeOther(request.other);
  const auto is_free = [&](const UnitState& unit) { return !bodies.touches(space.toJoints(unit)); };

  const UnitState start = space.toUnit(request.start);
  result->status = PlanStatus::kStartInCollision;  // or outside the limits, or not a number: no place to start from
  if (!isFinite(request.other) || !space.contains(start, kStartSlack) || !is_free(clampToCube(start))) return;

  const Vec3& goal_W = request.goal == GoalKind::kTip ? request.goal_W : config.goal_W;
  const Vector3 goal_B = at(raven.X_WB, request.arm).inverse() * toEigen(goal_W);
  const GoalChoice choice = findGoal(geometry(), request.arm, space, request.start, goal_B, is_free, stop);
  result->status = choice.status;
  if (choice.status != PlanStatus::kSuccess) return;

  const auto cost = [&](const UnitState& a, const UnitState& b) {
    return planning::edgeCost(geometry(), config, space, request.arm, a, b);
  };
  const std::vector<UnitState> path = searchFmt({clampToCube(start), choice.goal, is_free, cost, stop, config.samples,
                                                 config.radius_multiplier, config.edge_step, seed});
  // A path longer than a PlanResult holds counts as none: what the arm may not be told, it cannot follow.
  result->status = path.empty() || path.size() > kMaxWaypoints ? PlanStatus::kNoPath : PlanStatus::kSuccess;
  if (result->status == PlanStatus::kSuccess) fill(request, space, path, result);
}

void PathPlanner::Impl::fill(const PlanRequest& request,
                             const JointSpace& space,
                             const std::vector<UnitState>& path,
                             PlanResult* out) {
  out->waypoint_count = static_cast<std::uint32_t>(path.size());
  out->waypoints[0] = request.start;
  for (std::size_t i = 1; i < path.size(); ++i) {
    out->waypoints[i] = space.toJoints(path[i]);
    out->arrival[i] = out->arrival[i - 1] + edgeDuration(config, out->waypoints[i - 1], out->waypoints[i]);
    out->cost +=
        planning::edgeCost(geometry(), config, space, request.arm, space.toUnit(out->waypoints[i - 1]), path[i]);
  }
}

PathPlanner::PathPlanner(const model::RavenModel& raven, const model::SceneModel& scene, const PlannerConfig& config)
    : impl_(std::make_unique<Impl>(raven, scene, config)) {}

PathPlanner::~PathPlanner() = default;

PlanResult PathPlanner::plan(const PlanRequest& request,
                             std::uint64_t seed,
                             bool lockstep,
                             const std::atomic<bool>& cancel) {
  const Clock::time_point begin = lockstep ? Clock::time_point{} : Clock::now();
  const auto stop = [&] { return cancel.load() || (!lockstep && secondsSince(begin) > impl_->config.time_limit); };
  PlanResult result;
  result.id = request.id;
  result.arm = request.arm;
  result.samples = impl_->config.samples;
  try {
    impl_->solve(request, seed, stop, &result);
  } catch (const std::exception&) {
    // OMPL, FCL or the heap gave up: for who asked, there is no path. Nothing half-made is returned.
    result.status = PlanStatus::kNoPath;
    result.waypoint_count = 0;
  }
  if (cancel.load()) {
    result.status = PlanStatus::kCancelled;
    result.waypoint_count = 0;
  }
  if (!lockstep) result.planning_time = secondsSince(begin);
  return result;
}

bool PathPlanner::inCollision(Arm arm, const JointArray& q, const JointArray& other) const {
  ArmCollision& bodies = impl_->collision(arm);
  bodies.placeOther(other);
  return bodies.touches(q);
}

double PathPlanner::edgeCost(Arm arm, const JointArray& a, const JointArray& b) const {
  const JointSpace space(impl_->geometry(), kinematics::jawOpening(a));
  return planning::edgeCost(impl_->geometry(), impl_->config, space, arm, space.toUnit(a), space.toUnit(b));
}

}  // namespace raven2_trainer::planning
