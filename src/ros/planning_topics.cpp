#include "ros/planning_topics.h"

namespace raven2_trainer::ros_bridge {
namespace {

constexpr Tick kProgressPeriod = 100;  // [1 ms] enough for a bar that moves
constexpr std::uint32_t kQueue = 10;
constexpr bool kLatched = true;

/** Does something move or get worked out, so that there is progress? */
bool isUnderWay(PlanningStatus status) {
  return status != PlanningStatus::kIdle && status != PlanningStatus::kReady;
}

}  // namespace

PlanningTopics::PlanningTopics(ros::NodeHandle* node,
                               const TrainerConfig& config,
                               const model::RavenModel& raven,
                               const SharedState& shared)
    : config_(config),
      raven_(raven),
      shared_(shared),
      trajectory_(node->advertise<trajectory_msgs::JointTrajectory>("plan/trajectory", kQueue, kLatched)),
      tip_path_(node->advertise<nav_msgs::Path>("plan/tip_path", kQueue, kLatched)),
      progress_(node->advertise<PlanningProgress>("plan/progress", kQueue, kLatched)),
      execution_(node->advertise<PlanExecution>("plan/execution", kQueue, kLatched)) {}

void PlanningTopics::publish(const ModelState& model, const ros::Time& stamp) {
  publishPlan(stamp);
  publishProgress(model, stamp);
  publishExecution(stamp);
}

void PlanningTopics::publishPlan(const ros::Time& stamp) {
  const std::uint64_t version = shared_.last_plan.version();
  if (version == plans_seen_) return;
  plans_seen_ = version;
  const PlanResult plan = shared_.last_plan.load();
  if (plan.status != PlanStatus::kSuccess) return;
  trajectory_.publish(trajectory(plan, config_.arms.geometry.d4));  // stamp 0: to be begun when it arrives
  tip_path_.publish(tipPath(plan, config_.arms.geometry, at(raven_.X_WB, plan.arm), stamp));
}

void PlanningTopics::publishExecution(const ros::Time& stamp) {
  const std::uint64_t version = shared_.last_execution.version();
  if (version == executions_seen_) return;
  executions_seen_ = version;
  execution_.publish(planExecution(shared_.last_execution.load(), stamp));
}

void PlanningTopics::publishProgress(const ModelState& model, const ros::Time& stamp) {
  const bool is_new = clock_.look(model);
  const bool is_due = isUnderWay(model.planning.status) && model.tick - published_ >= kProgressPeriod;
  if (!is_new && !is_due) return;
  published_ = model.tick;
  progress_.publish(planningProgress(model.planning, clock_.elapsed(), stamp));
}

}  // namespace raven2_trainer::ros_bridge
