#pragma once

#include <cstdint>

#include "ros/bridge/topic_source.h"
#include "ros/node/outlet.h"
#include "ros/planning/planning_messages.h"

namespace raven2_trainer::ros_bridge {

/**
 * plan/trajectory and plan/tip_path of the newest plan that succeeded, plan/execution of the newest execution, and
 * plan/progress. All latched: who comes later gets the newest.
 */
class PlanningTopics {
 public:
  PlanningTopics(const TopicMaker& topics, const TopicSource& source);

  /** Publishes what is new. To be called every runtime.ros_period; one thread. @param[in] model of this cycle. */
  void publish(const ModelState& model, const ros::Time& stamp);

  /** The ticks start again: a published path is forgotten. The newest execution stays until the next. */
  void startOver();

 private:
  void publishPlan(const ros::Time& stamp);
  void publishPath(const PlanResult& plan, const ros::Time& stamp);
  void publishExecution(const ros::Time& stamp);
  void publishProgress(const ModelState& model, const ros::Time& stamp);

  TopicSource source_;
  Outlet<trajectory_msgs::JointTrajectory> trajectory_;
  Outlet<nav_msgs::Path> tip_path_;
  Outlet<PlanningProgress> progress_;
  Outlet<PlanExecution> execution_;
  std::uint64_t plans_seen_{0}, executions_seen_{0};  ///< versions of the cells
  bool has_published_path_{false};
  StatusClock clock_;
  Tick published_{-1};  ///< [1 ms] of the model, of the newest plan/progress; -1 none
};

}  // namespace raven2_trainer::ros_bridge
