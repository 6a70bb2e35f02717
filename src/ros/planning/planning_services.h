#pragma once

#include <ros/callback_queue.h>
#include <ros/node_handle.h>
#include <ros/spinner.h>

#include <string>
#include <vector>

#include "raven2_trainer/CancelPlan.h"
#include "raven2_trainer/ExecutePlan.h"
#include "raven2_trainer/PlanPath.h"
#include "raven2_trainer/PlanningMode.h"
#include "raven2_trainer/kinematics/arms_config.h"
#include "ros/planning/planning_client.h"

namespace raven2_trainer::ros_bridge {

/**
 * plan, planning_mode, execute_plan and cancel_plan. plan, and planning_mode for a recorded goal, wait for a plan: they
 * have a queue and a thread. The other two have another thread, so that a plan can be cancelled
 * while a client waits for it.
 */
class PlanningServices {
 public:
  /**
   * @param[in] time_limit [s] that planning may take. @param[in] client must outlive this.
   * @param[in] may_command without it only what makes things safer is offered: cancel_plan.
   */
  PlanningServices(const ros::NodeHandle& node,
                   const ArmGeometry& geometry,
                   double time_limit,
                   PlanningClient* client,
                   bool may_command);

  /** Makes calls that wait return, and ends the threads. */
  void stop();

  /** Resolved names of what is offered. */
  std::vector<std::string> names() const;

 private:
  bool plan(PlanPath::Request& message, PlanPath::Response& response);
  bool planningMode(PlanningMode::Request& message, PlanningMode::Response& response);
  bool executePlan(ExecutePlan::Request& message, ExecutePlan::Response& response);
  bool cancelPlan(CancelPlan::Request& message, CancelPlan::Response& response);

  void recordGoal(PlanningMode::Response* response);

  const double d4_;        ///< [m]
  const double patience_;  ///< [s] for a plan
  PlanningClient& client_;
  ros::CallbackQueue plan_queue_, order_queue_;
  ros::NodeHandle plan_node_, order_node_;
  ros::AsyncSpinner plan_spinner_, order_spinner_;
  ros::ServiceServer plan_, planning_mode_, execute_plan_, cancel_plan_;
};

}  // namespace raven2_trainer::ros_bridge
