#include "loop/activity/plan_store.h"

#include <algorithm>
#include <cmath>

#include "loop/plan_cancelled.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"

namespace raven2_trainer::loop {
namespace {

double speed(const Vec3& v) noexcept {
  return toEigen(v).norm();
}

PlanRequest toPlanRequest(const Request& request, const PerArm<JointArray>& now) noexcept {
  PlanRequest plan;
  plan.id = request.id;
  plan.arm = request.arm;
  plan.start = at(now, request.arm);
  plan.other = now[1 - index(request.arm)];
  plan.choose_arm = request.choose_arm;
  plan.goal = request.goal;
  plan.goal_W = request.goal_W;
  plan.goal_q = request.goal_q;
  return plan;
}

}  // namespace

PlanStore::PlanStore(const LoopConfig& config,
                     const model::RavenModel& raven,
                     const model::SceneModel& scene,
                     Answers* answers,
                     SharedState* shared)
    : config_(config.execution),
      geometry_(config.arms.geometry),
      answers_(*answers),
      shared_(*shared),
      execution_(config.execution),
      relay_(config.arms.geometry, {static_cast<double>(config.itp.max_increment_um), config.itp.max_rotation}),
      gauge_(raven, scene) {}

std::uint32_t PlanStore::guidePlan() const noexcept {
  const bool is_kept = state_.status == PlanningStatus::kReady || state_.status == PlanningStatus::kArmed;
  return is_kept ? plan_.id : 0;
}

void PlanStore::choose(Arm arm, const JointArray& q, const JointArray& dq) noexcept {
  forget();
  state_.status = PlanningStatus::kChoosing;
  state_.arm = arm;
  chosen_q_ = q;
  chosen_dq_ = dq;
}

void PlanStore::ask(const Request& request, const PerArm<JointArray>& now) noexcept {
  forget();
  PlanRequest plan = toPlanRequest(request, now);
  plan.serial = ++serial_;
  planCancelled(&shared_, serial_).store(false);
  shared_.plan_requests.tryPush(plan);
  ++plans_under_way_;
  at_request_ = now;
  state_.status = PlanningStatus::kPlanning;
  state_.arm = request.arm;
  state_.plan = request.id;
}

void PlanStore::refuse(std::uint32_t id, Tick tick) noexcept {
  PlanResult refused;
  refused.id = id;
  refused.status = PlanStatus::kCancelled;
  shared_.plan_records.tryPush({tick, refused, /*refused=*/1});
}

bool PlanStore::isAwaited(const PlanResult& result) const noexcept {
  return state_.status == PlanningStatus::kPlanning && result.id == state_.plan;
}

const PlanResult& PlanStore::take(const PlanResult& result, Tick tick) noexcept {
  if (plans_under_way_ > 0) --plans_under_way_;
  newest_ = result;
  if (!isAwaited(result)) {
    newest_.status = PlanStatus::kCancelled;  // the pedal, or a newer request, came first: nobody will follow it
  } else if (result.status == PlanStatus::kSuccess) {
    plan_ = result;
    state_.status = PlanningStatus::kReady;
    state_.arm = result.arm;
  } else {
    forget();
  }
  answers_.give(newest_);
  shared_.plan_records.tryPush({tick, newest_, /*refused=*/0});
  return newest_;
}

void PlanStore::forget() noexcept {
  if (state_.status == PlanningStatus::kPlanning) planCancelled(&shared_, serial_).store(true);
  state_.status = PlanningStatus::kIdle;
  state_.plan = 0;
  state_.on_robot = 0;
  state_.progress = 0.0;
}

PlanningAnswer PlanStore::check(const Request& request, bool robot_joins) const noexcept {
  const bool is_meant = request.plan == 0 || request.plan == state_.plan;
  if (state_.status != PlanningStatus::kReady || !is_meant) return PlanningAnswer::kNoPlan;
  if (request.on_robot == 0) return PlanningAnswer::kAccepted;
  if (!robot_joins) return PlanningAnswer::kNoRobot;
  return plan_.robot_follows != 0 ? PlanningAnswer::kAccepted : PlanningAnswer::kRobotCannotFollow;
}

bool PlanStore::hasMoved(Arm arm, const JointArray& q) noexcept {
  if (!isNear(q, at(at_request_, arm))) return true;
  if (arm != plan_.arm) return !(tipDistance(arm, q, at(at_request_, arm)) <= plan_.clearance);
  return !isNear(q, plan_.waypoints[0]) || !isWayFree(q);  // whatever was noted of the arms
}

/** From there to where the path starts, some millimetres: in steps that no wire is thinner than. */
bool PlanStore::isWayFree(const JointArray& from) noexcept {
  constexpr int kSteps = 8;
  const JointArray& other = at(at_request_, otherArm(plan_.arm));
  for (int i = 0; i < kSteps; ++i) {
    JointArray q = from;
    for (std::size_t j = 0; j < kJointCount; ++j)
      q[j] += (plan_.waypoints[0][j] - from[j]) * i / kSteps;
    if (gauge_.measure(plan_.arm, q, other) <= 0.0) return false;
  }
  return true;
}

double PlanStore::tipDistance(Arm arm, const JointArray& a, const JointArray& b) const noexcept {
  return (kinematics::forward(geometry_, arm, a).p - kinematics::forward(geometry_, arm, b).p).norm();
}

/** Not if anything is not a number. */
bool PlanStore::isNear(const JointArray& q, const JointArray& before) const noexcept {
  const JointArray& tolerance = config_.start_tolerance;
  for (std::size_t j = 0; j < kGrasp1; ++j) {
    if (!(std::abs(q[j] - before[j]) <= tolerance[j])) return false;
  }
  return std::abs(kinematics::jawMidline(q) - kinematics::jawMidline(before)) <= tolerance[kGrasp1];
}

void PlanStore::arm(const Request& request) noexcept {
  state_.status = PlanningStatus::kArmed;
  state_.on_robot = request.on_robot != 0 ? 1 : 0;
  tally_.start(request.id, plan_, request.on_robot != 0);
  armed_ticks_ = 0;
  under_way_ = true;
}

bool PlanStore::waitForPedal() noexcept {
  return static_cast<double>(++armed_ticks_) * kTickSeconds <= config_.pedal_timeout;
}

void PlanStore::begin(const JointArray& from, Tick tick) noexcept {
  state_.status = PlanningStatus::kExecuting;
  execution_.start(plan_, from);
  tally_.begin(tick);
}

const control::JointTarget& PlanStore::advance(bool may_move) noexcept {
  const control::JointTarget& target = execution_.tick(may_move);
  state_.progress = execution_.progress();
  return target;
}

ExecutionEnd PlanStore::supervise(const ModelState& model, const RobotState& robot) noexcept {
  const ArmState& arm = at(model.arms, plan_.arm);
  const RobotArmState& real = at(robot.arms, plan_.arm);
  const Vec3 path_B = toArray(kinematics::forward(geometry_, plan_.arm, execution_.desired()).p);
  const Vec3 goal_B = toArray(kinematics::forward(geometry_, plan_.arm, execution_.goal()).p);
  const Arm other = otherArm(plan_.arm);
  const double near = gauge_.measure(plan_.arm, arm.q, at(model.arms, other).q);
  const double real_near = state_.on_robot != 0 ? gauge_.measure(plan_.arm, real.q, at(robot.arms, other).q) : 0.0;
  tally_.add({path_B, goal_B, arm.p_BT, real.p_BT, arm.contacts, near, real_near});
  if (!(tally_.deviation() <= config_.deviation_limit)) return ExecutionEnd::kOffPath;
  if (execution_.waited() > config_.robot_timeout) return ExecutionEnd::kRobotLost;
  if (!execution_.isOver()) return ExecutionEnd::kNone;
  const double fastest = std::max(speed(arm.v_BT), state_.on_robot != 0 ? speed(real.v_BT) : 0.0);
  if (tally_.distanceToGoal() <= config_.settle_tolerance && fastest <= config_.settle_speed)
    return ExecutionEnd::kFinished;
  return execution_.rested() > config_.settle_time ? ExecutionEnd::kNotSettled : ExecutionEnd::kNone;
}

void PlanStore::end(ExecutionEnd end, Tick tick) noexcept {
  if (!under_way_) return;
  under_way_ = false;
  const ExecutionReport report = tally_.finish(end, tick, state_.progress);
  answers_.give(report);
  shared_.execution_records.tryPush({tick, report});
  state_.progress = 0.0;
  const bool robot_moved = state_.on_robot != 0 && report.started >= 0;
  state_.on_robot = 0;
  state_.status = PlanningStatus::kReady;
  if (robot_moved) forget();  // it is no longer where the plan starts
}

}  // namespace raven2_trainer::loop
