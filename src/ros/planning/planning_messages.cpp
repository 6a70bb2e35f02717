#include "ros/planning/planning_messages.h"

#include <algorithm>
#include <cmath>

#include "raven2_trainer/core/vec3.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"
#include "raven2_trainer/kinematics/joint_conventions.h"
#include "ros/node/name_of.h"

namespace raven2_trainer::ros_bridge {
namespace {

constexpr int kPosesPerSegment = 20;  // of a straight line in joint space: a smooth line in a viewer

template <typename Numbers>
bool areFinite(const Numbers& numbers) {
  return std::all_of(numbers.begin(), numbers.end(), [](double x) { return std::isfinite(x); });
}

ReadRequest refused(ErrorCode code, const std::string& why) {
  return {code, why, {}};
}

ReadRequest accepted(const Request& request) {
  return {ErrorCode::kSuccess, "", request};
}

ReadRequest withJoints(const WantedPlan& wanted, double d4, Request request) {
  if (request.choose_arm != 0) return refused(ErrorCode::kInvalidGroupName, "joints need an arm: gold, green");
  if (wanted.joints.size() != kJointCount)
    return refused(ErrorCode::kInvalidGoalConstraints, std::to_string(wanted.joints.size()) + " joints; wanted: 7");
  JointArray urdf{};
  std::copy(wanted.joints.begin(), wanted.joints.end(), urdf.begin());
  if (!areFinite(urdf)) return refused(ErrorCode::kInvalidGoalConstraints, "a joint of the goal is not finite");
  request.goal = GoalKind::kJoints;
  request.goal_q = kinematics::fromUrdf(request.arm, d4, urdf);
  return accepted(request);
}

ReadRequest withTip(const WantedPlan& wanted, Request request) {
  if (!areFinite(wanted.goal_W)) return refused(ErrorCode::kInvalidGoalConstraints, "the goal is not finite");
  request.goal = GoalKind::kTip;
  request.goal_W = wanted.goal_W;
  return accepted(request);
}

JointArray between(const JointArray& a, const JointArray& b, double share) {
  JointArray q{};
  for (std::size_t j = 0; j < kJointCount; ++j)
    q[j] = a[j] + share * (b[j] - a[j]);
  return q;
}

geometry_msgs::PoseStamped poseStamped(const Pose& X_WT, const std_msgs::Header& header) {
  const RigidPose pose = toArray(X_WT);
  geometry_msgs::PoseStamped message;
  message.header = header;
  message.pose.position.x = pose.p[0];
  message.pose.position.y = pose.p[1];
  message.pose.position.z = pose.p[2];
  message.pose.orientation.x = pose.q[0];
  message.pose.orientation.y = pose.q[1];
  message.pose.orientation.z = pose.q[2];
  message.pose.orientation.w = pose.q[3];
  return message;
}

}  // namespace

bool readArm(const std::string& text, Arm* arm) {
  for (const Arm known : kArms) {
    if (text != name(known)) continue;
    *arm = known;
    return true;
  }
  return false;
}

ReadRequest planRequest(const WantedPlan& wanted, double d4) {
  Request request;
  request.kind = RequestKind::kPlan;
  request.choose_arm = wanted.arm.empty() ? 1 : 0;
  if (request.choose_arm == 0 && !readArm(wanted.arm, &request.arm))
    return refused(ErrorCode::kInvalidGroupName, "unknown arm; known: gold, green");
  if (wanted.default_goal) return accepted(request);
  return wanted.joints.empty() ? withTip(wanted, request) : withJoints(wanted, d4, request);
}

trajectory_msgs::JointTrajectory trajectory(const PlanResult& plan, double d4) {
  trajectory_msgs::JointTrajectory message;
  const auto& names = kinematics::urdfJointNames(plan.arm);
  message.joint_names.assign(names.begin(), names.end());
  for (std::uint32_t i = 0; i < plan.waypoint_count; ++i) {
    const JointArray position = kinematics::toUrdf(plan.arm, d4, plan.waypoints[i]);
    trajectory_msgs::JointTrajectoryPoint point;
    point.positions.assign(position.begin(), position.end());
    point.velocities.assign(kJointCount, 0.0);  // rest to rest
    point.accelerations.assign(kJointCount, 0.0);
    point.time_from_start = ros::Duration(plan.arrival[i]);
    message.points.push_back(point);
  }
  return message;
}

nav_msgs::Path tipPath(const PlanResult& plan, const ArmGeometry& geometry, const Pose& X_WB, const ros::Time& stamp) {
  nav_msgs::Path path;
  path.header.stamp = stamp;
  path.header.frame_id = "world";
  const auto add = [&](const JointArray& q) {
    path.poses.push_back(poseStamped(X_WB * kinematics::forward(geometry, plan.arm, q), path.header));
  };
  if (plan.waypoint_count > 0) add(plan.waypoints[0]);
  for (std::uint32_t i = 1; i < plan.waypoint_count; ++i) {
    for (int k = 1; k <= kPosesPerSegment; ++k)
      add(between(plan.waypoints[i - 1], plan.waypoints[i], static_cast<double>(k) / kPosesPerSegment));
  }
  return path;
}

const PlanResult* newestPath(const std::vector<PlanResult>& answers) noexcept {
  const auto is_path = [](const PlanResult& answer) { return answer.status == PlanStatus::kSuccess; };
  const auto found = std::find_if(answers.rbegin(), answers.rend(), is_path);
  return found == answers.rend() ? nullptr : &*found;
}

bool StatusClock::look(const ModelState& model) {
  const PlanningState& state = model.planning;
  const bool is_new = !has_looked_ || state.status != status_ || state.plan != plan_;
  if (is_new) since_ = model.tick;
  has_looked_ = true;
  status_ = state.status;
  plan_ = state.plan;
  now_ = model.tick;
  return is_new;
}

PlanningProgress planningProgress(const PlanningState& state,
                                  const PlanCounts& counts,
                                  double elapsed,
                                  const ros::Time& stamp) {
  PlanningProgress message;
  message.header.stamp = stamp;
  message.status = nameOf(kPlanningStatusNames, state.status);
  message.arm = nameOf(kArmNames, state.arm);
  message.plan = state.plan;
  message.on_robot = state.on_robot != 0;
  message.progress = state.progress;
  message.elapsed = elapsed;
  message.samples = counts.samples;
  message.edges = counts.edges;
  message.rollouts = counts.rollouts;
  message.best_cost = counts.best_cost;
  return message;
}

PlanExecution planExecution(const ExecutionReport& report, const ros::Time& stamp) {
  PlanExecution message;
  message.header.stamp = stamp;
  message.execution = report.id;
  message.plan = report.plan;
  message.arm = nameOf(kArmNames, report.arm);
  message.on_robot = report.on_robot != 0;
  message.end = nameOf(kExecutionEndNames, report.end);
  message.error_code = number(errorCode(report.end));
  message.started = report.started;
  message.ended = report.ended;
  message.path_time = report.path_time;
  message.progress = report.progress;
  message.planned_clearance = report.planned_clearance;
  message.model_error_mean = report.model.mean;
  message.model_error_largest = report.model.largest;
  message.model_error_at_end = report.model.at_end;
  message.robot_error_mean = report.robot.mean;
  message.robot_error_largest = report.robot.largest;
  message.robot_error_at_end = report.robot.at_end;
  message.model_clearance = report.model_clearance;
  message.robot_clearance = report.robot_clearance;
  message.contact_ticks = report.contact_ticks;
  message.contact_points = report.contact_points;
  return message;
}

MoveArmResult moveArmResult(const MoveArmTask::Outcome& outcome, const ros::Time& stamp) {
  MoveArmResult result;
  result.error_code = number(outcome.code);
  result.status = outcome.status;
  result.plan = outcome.plan.id;
  if (outcome.plan.id != 0) result.arm = name(outcome.plan.arm);
  result.cost = outcome.plan.cost;
  result.planning_time = outcome.plan.planning_time;
  result.report = planExecution(outcome.report, stamp);
  return result;
}

TipErrors tipErrors(const ModelState& model, const RobotState& robot, const ArmGeometry& geometry) {
  const PlanningState& planning = model.planning;
  if (planning.status != PlanningStatus::kExecuting) return {};
  const ArmState& arm = at(model.arms, planning.arm);
  const Vec3 wanted_B = toArray(kinematics::forward(geometry, planning.arm, arm.q_d).p);
  TipErrors errors;
  errors.model = distance(arm.p_BT, wanted_B);
  if (planning.on_robot != 0) errors.robot = distance(at(robot.arms, planning.arm).p_BT, wanted_B);
  return errors;
}

}  // namespace raven2_trainer::ros_bridge
