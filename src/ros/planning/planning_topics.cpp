#include "ros/planning/planning_topics.h"

#include "ros/node/topic.h"

namespace raven2_trainer::ros_bridge {
namespace {

constexpr Tick kProgressPeriod = 100;  // [1 ms] enough for a bar that moves

/** Does something move or get worked out, so that there is progress? */
bool isUnderWay(PlanningStatus status) {
  return status != PlanningStatus::kIdle && status != PlanningStatus::kReady;
}

}  // namespace

PlanningTopics::PlanningTopics(const TopicMaker& topics, const TopicSource& source)
    : source_(source),
      trajectory_(topics.advertise<trajectory_msgs::JointTrajectory>("plan/trajectory", kQueue, kLatched)),
      tip_path_(topics.advertise<nav_msgs::Path>("plan/tip_path", kQueue, kLatched)),
      progress_(topics.advertise<PlanningProgress>("plan/progress", kQueue, kLatched)),
      execution_(topics.advertise<PlanExecution>("plan/execution", kQueue, kLatched)) {}

void PlanningTopics::publish(const ModelState& model, const ros::Time& stamp) {
  publishPlan(stamp);
  publishProgress(model, stamp);
  publishExecution(stamp);
}

void PlanningTopics::startOver() {
  clock_ = {};
  published_ = -1;
  if (has_published_path_) publishPath(PlanResult{}, ros::Time());  // without points; who comes now gets this, too
  has_published_path_ = false;
}

void PlanningTopics::publishPlan(const ros::Time& stamp) {
  const SharedState& shared = source_.shared;
  const std::uint64_t version = shared.last_plan.version();
  if (version == plans_seen_) return;
  plans_seen_ = version;
  const PlanResult plan = shared.last_plan.load();
  if (plan.status != PlanStatus::kSuccess) return;
  publishPath(plan, stamp);
  has_published_path_ = true;
}

void PlanningTopics::publishPath(const PlanResult& plan, const ros::Time& stamp) {
  trajectory_.publish(trajectory(plan, source_.geometry.d4));  // stamp 0: to be begun when it arrives
  tip_path_.publish(tipPath(plan, source_.geometry, at(source_.raven.X_WB, plan.arm), stamp));
}

void PlanningTopics::publishExecution(const ros::Time& stamp) {
  const SharedState& shared = source_.shared;
  const std::uint64_t version = shared.last_execution.version();
  if (version == executions_seen_) return;
  executions_seen_ = version;
  execution_.publish(planExecution(shared.last_execution.load(), stamp));
}

void PlanningTopics::publishProgress(const ModelState& model, const ros::Time& stamp) {
  const bool is_new = clock_.look(model);
  const bool is_due = isUnderWay(model.planning.status) && model.tick - published_ >= kProgressPeriod;
  if (!is_new && !is_due) return;
  published_ = model.tick;
  progress_.publish(planningProgress(model.planning, source_.plan_counts(), clock_.elapsed(), stamp));
}

}  // namespace raven2_trainer::ros_bridge
