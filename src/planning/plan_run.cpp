#include "planning/plan_run.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "planning/path_improvement.h"
#include "planning/poll.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"

namespace raven2_trainer::planning {
namespace {

/** [-] how far outside its limits a start may be and still count: the arm settles a little beyond a limit. */
constexpr double kStartSlack = 0.003;

/** Adds the time that it lives to a sum. */
class Stopwatch {
 public:
  explicit Stopwatch(double* sum) : sum_(sum), begin_(Clock::now()) {}
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;
  ~Stopwatch() { *sum_ += std::chrono::duration<double>(Clock::now() - begin_).count(); }

 private:
  double* sum_;
  Clock::time_point begin_;
};

UnitState clampToCube(UnitState unit) {
  for (double& x : unit)
    x = std::clamp(x, 0.0, 1.0);
  return unit;
}

bool isFinite(const JointArray& q) {
  return std::all_of(q.begin(), q.end(), [](double x) { return std::isfinite(x); });
}

void count(std::atomic<std::uint32_t>* counter) {
  counter->fetch_add(1, std::memory_order_relaxed);
}

}  // namespace

PlanRun::PlanRun(const PlanSetting& setting)
    : set_(setting),
      arm_(setting.request.arm),
      space_(setting.raven.arms.geometry, kinematics::jawOpening(setting.request.start)) {}

const JointArray& PlanRun::startOf(Arm arm) const {
  return arm == set_.request.arm ? set_.request.start : set_.request.other;
}

const JointArray& PlanRun::otherOf(Arm arm) const {
  return arm == set_.request.arm ? set_.request.other : set_.request.start;
}

PlanResult PlanRun::run() {
  PlanResult result;
  result.id = set_.request.id;
  result.status = choose();
  result.arm = arm_;
  if (result.status == PlanStatus::kSuccess) search(&result);
  if (set_.is_cancelled()) result.status = PlanStatus::kCancelled;
  if (result.status == PlanStatus::kSuccess) fill(&result);
  return result;
}

bool PlanRun::isWithinLimits(Arm arm) const {
  const JointSpace space(set_.raven.arms.geometry, kinematics::jawOpening(startOf(arm)));
  return space.contains(space.toUnit(startOf(arm)), kStartSlack);
}

/** The arm asked for, or the better of both; with it start_, goal_, space_ and what may touch. */
PlanStatus PlanRun::choose() {
  const Stopwatch watch(&statistics_.goal_time);
  if (!isFinite(set_.request.start) || !isFinite(set_.request.other)) return PlanStatus::kInvalidStart;
  PerArm<ArmProspect> prospects;
  for (const Arm arm : kArms) {
    if (arm == arm_ || set_.request.choose_arm != 0) at(prospects, arm) = prospect(arm);
  }
  if (set_.request.choose_arm != 0) arm_ = chooseArm(arm_, prospects);
  if (!isWithinLimits(arm_)) return PlanStatus::kInvalidStart;
  const ArmProspect chosen = at(prospects, arm_);
  if (set_.is_late() && chosen.goal.status != PlanStatus::kSuccess) return PlanStatus::kTimeLimit;
  if (!chosen.may_start) return PlanStatus::kStartInCollision;
  space_ = JointSpace(set_.raven.arms.geometry, kinematics::jawOpening(startOf(arm_)));
  start_ = clampToCube(space_.toUnit(startOf(arm_)));
  goal_ = chosen.goal.goal;
  return chosen.goal.status;
}

ArmProspect PlanRun::prospect(Arm arm) {
  const JointSpace space(set_.raven.arms.geometry, kinematics::jawOpening(startOf(arm)));
  const UnitState start = space.toUnit(startOf(arm));
  planningOf(arm).checks.begin(space, otherOf(arm));
  ArmProspect found;
  found.may_start = space.contains(start, kStartSlack) && planningOf(arm).checks.allowEnd(clampToCube(start));
  if (found.may_start) found.goal = goalOf(arm, space, start);
  if (found.goal.status == PlanStatus::kSuccess) found.distance = distance(start, found.goal.goal);
  return found;
}

GoalChoice PlanRun::goalOf(Arm arm, const JointSpace& space, const UnitState& start) {
  ArmChecks& checks = planningOf(arm).checks;
  const PlanRequest& request = set_.request;
  if (request.goal == GoalKind::kJoints) {
    JointArray q = request.goal_q;
    kinematics::setJaws(kinematics::jawMidline(q), kinematics::jawOpening(startOf(arm)), &q);
    const UnitState goal = space.toUnit(q);
    if (!isFinite(q) || !space.contains(goal, kStartSlack)) return {PlanStatus::kGoalUnreachable, {}};
    if (!checks.allowEnd(clampToCube(goal))) return {PlanStatus::kGoalInCollision, {}};
    return {PlanStatus::kSuccess, clampToCube(goal)};
  }
  const Vec3& goal_W = request.goal == GoalKind::kTip ? request.goal_W : set_.config.goal_W;
  const Vector3 goal_B = at(set_.raven.X_WB, arm).inverse() * toEigen(goal_W);
  return findGoal(
      set_.raven.arms.geometry, arm, space, space.toJoints(start), goal_B,
      [&](const UnitState& unit) { return checks.isFree(unit); }, [this] { return isOver(); });
}

std::shared_ptr<const MotionCost> PlanRun::makeCost(double eta_clearance) const {
  const PlanOptions& o = set_.options;
  const CostWeights weights{o.eta_length, o.eta_acceleration, eta_clearance, set_.config.clearance_range};
  return std::make_shared<MotionCost>(set_.raven.arms.geometry, arm_, space_, set_.config, weights,
                                      planningOf(arm_).checks.clearanceFunction());
}

SearchOrder PlanRun::order() {
  const PlanOptions& o = set_.options;
  ArmPlanning& own = planningOf(arm_);
  SearchOrder order;
  order.task.start = start_;
  order.task.goal = goal_;
  order.task.is_free = [&own](const UnitState& unit) {
    return own.checks.isFree(unit) || own.checks.isAllowedEnd(unit);
  };
  order.task.is_edge_free = [this, &own](const UnitState& a, const UnitState& b) {
    count(&set_.progress->edges);
    return own.checks.isEdgeFree(a, b);
  };
  order.task.cost = cost_;
  order.task.stop = [this] { return isOver(); };
  order.task.seed = set_.seed;
  order.planner = o.planner;
  order.settings = {o.samples, o.max_samples, set_.config.max_rollouts, set_.config.radius_multiplier, own.free_volume};
  order.stops_on_draws = set_.lockstep;
  order.until_stopped = o.until_time_limit && !set_.lockstep;
  order.judge = [this](const std::vector<UnitState>& path) { return judge(path); };
  order.on_sample = [this] { count(&set_.progress->samples); };
  return order;
}

void PlanRun::search(PlanResult* result) {
  cost_ = makeCost(set_.options.eta_clearance);
  const SearchOutcome outcome = searchPath(order());
  record(outcome);
  // A path longer than a PlanResult holds counts as none: an arm cannot follow a path that it cannot be sent.
  const bool too_long = kept_.size() > kMaxWaypoints;
  result->status = outcome.status == PlanStatus::kSuccess && too_long ? PlanStatus::kNoPath : outcome.status;
}

/** The improved path if the arm can follow it, else the path itself if it can follow that. */
PathVerdict PlanRun::judge(const std::vector<UnitState>& path) {
  statistics_.plain_cost = plainCost(path);
  set_.progress->best_cost.store(statistics_.plain_cost);
  const std::vector<UnitState> improved = improve(path);
  const RollOutReport report = follow(improved);
  if (report.free) {
    keep(improved, report);
    return {};
  }
  const RollOutReport plain = improved == path || report.stopped ? report : follow(path);
  if (plain.free) keep(path, plain);
  return {plain.free, plain.failed_edge};
}

std::vector<UnitState> PlanRun::improve(const std::vector<UnitState>& path) {
  if (set_.options.planner != "FMTstar") return path;  // the others' are shown as they are
  const Stopwatch watch(&statistics_.improvement_time);
  ImprovementTask task;
  task.cost = cost_.get();
  task.is_edge_free = [this](const UnitState& a, const UnitState& b) {
    return planningOf(arm_).checks.isEdgeFree(a, b);
  };
  task.stop = [this] { return isOver(); };
  task.attempts = set_.options.improve_attempts;
  task.seed = set_.seed;
  return improvePath(path, task);
}

RollOutReport PlanRun::follow(const std::vector<UnitState>& path) {
  RollOutReport report;
  report.free = true;
  if (planningOf(arm_).roll_out == nullptr) return report;
  const Stopwatch watch(&statistics_.rollout_time);
  ++statistics_.rollouts;
  count(&set_.progress->rollouts);
  const std::vector<JointArray> waypoints = waypointsOf(path);
  // An anytime planner's path is there only when the time is up: it is followed, too.
  const bool timeless = set_.options.until_time_limit;
  report = planningOf(arm_).roll_out->follow(waypoints, arrivalOf(waypoints), otherOf(arm_),
                                             [&] { return timeless ? set_.is_cancelled() : isOver(); });
  if (report.broken) throw std::runtime_error("the world of the roll-out gave up");  // it says nothing of the path
  if (report.free && report.tracking_error > set_.config.max_tracking_error) {
    report.free = false;
    report.failed_edge = report.tracking_edge;
  }
  if (!report.free && !report.stopped) ++statistics_.failed_rollouts;
  return report;
}

void PlanRun::keep(const std::vector<UnitState>& path, const RollOutReport& report) {
  kept_ = path;
  report_ = report;
  statistics_.improved_cost = plainCost(path);
  for (std::size_t i = 1; i < path.size(); ++i)
    statistics_.clearance_cost += cost_->clearanceTerm(path[i - 1], path[i]);
  set_.progress->best_cost.store(statistics_.improved_cost);
}

std::vector<JointArray> PlanRun::waypointsOf(const std::vector<UnitState>& path) const {
  std::vector<JointArray> waypoints;
  for (const UnitState& unit : path)
    waypoints.push_back(space_.toJoints(unit));
  waypoints.front() = startOf(arm_);  // its place, even a little beyond a limit
  return waypoints;
}

std::vector<double> PlanRun::arrivalOf(const std::vector<JointArray>& waypoints) const {
  std::vector<double> arrival{0.0};
  for (std::size_t i = 1; i < waypoints.size(); ++i)
    arrival.push_back(arrival.back() + edgeDuration(set_.config, waypoints[i - 1], waypoints[i]));
  return arrival;
}

double PlanRun::plainCost(const std::vector<UnitState>& path) const {
  double sum = 0.0;
  for (std::size_t i = 1; i < path.size(); ++i)
    sum += cost_->plain(i == 1 ? space_.toUnit(startOf(arm_)) : path[i - 1], path[i]);
  return sum;
}

void PlanRun::fill(PlanResult* result) const {
  const std::vector<JointArray> waypoints = waypointsOf(kept_);
  const std::vector<double> arrival = arrivalOf(waypoints);
  result->waypoint_count = static_cast<std::uint32_t>(waypoints.size());
  std::copy(waypoints.begin(), waypoints.end(), result->waypoints.begin());
  std::copy(arrival.begin(), arrival.end(), result->arrival.begin());
  result->cost = plainCost(kept_);
  result->clearance = report_.clearance;
  result->tracking_error = report_.tracking_error;
}

void PlanRun::record(const SearchOutcome& outcome) {
  PlanStatistics& s = statistics_;
  s.samples = outcome.fmt.samples;
  s.draws = outcome.counts.draws;
  s.state_checks = outcome.counts.state_checks;
  s.edge_checks = outcome.counts.edge_checks;
  s.cost_evaluations = outcome.counts.cost_evaluations;
  s.clearance_integrals = outcome.counts.clearance_integrals;
  s.rounds = outcome.fmt.rounds;
  s.sampling_time = outcome.fmt.sampling_time;
  s.neighbour_time = outcome.fmt.neighbour_time;
}

}  // namespace raven2_trainer::planning
