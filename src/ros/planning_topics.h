#pragma once

#include <ros/node_handle.h>
#include <ros/publisher.h>

#include <cstdint>

#include "raven2_trainer/core/config.h"
#include "raven2_trainer/core/shared_state.h"
#include "raven2_trainer/model/raven_model.h"
#include "ros/planning_messages.h"

namespace raven2_trainer::ros_bridge {

/**
 * plan/trajectory and plan/tip_path of the newest plan that succeeded, plan/execution of the newest execution, and
 * plan/progress. All latched: who comes later gets the newest.
 */
class PlanningTopics {
 public:
  /** What is pointed to or referred to must outlive this. */
  PlanningTopics(ros::NodeHandle* node,
                 const TrainerConfig& config,
                 const model::RavenModel& raven,
                 const SharedState& shared);

  /** Publishes what is new. To be called every runtime.ros_period; one thread. @param[in] model of this cycle. */
  void publish(const ModelState& model, const ros::Time& stamp);

 private:
  void publishPlan(const ros::Time& stamp);
  void publishExecution(const ros::Time& stamp);
  void publishProgress(const ModelState& model, const ros::Time& stamp);

  const TrainerConfig& config_;
  const model::RavenModel& raven_;
  const SharedState& shared_;
  ros::Publisher trajectory_, tip_path_, progress_, execution_;
  std::uint64_t plans_seen_{0}, executions_seen_{0};  ///< versions of the cells
  StatusClock clock_;
  Tick published_{-1};  ///< [1 ms] of the model, of the newest plan/progress; -1 none
};

}  // namespace raven2_trainer::ros_bridge
