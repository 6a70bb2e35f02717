#pragma once

#include <ros/callback_queue.h>
#include <ros/node_handle.h>
#include <ros/spinner.h>
#include <std_srvs/SetBool.h>
#include <std_srvs/Trigger.h>

#include <atomic>
#include <cstdint>
#include <mutex>

#include "raven2_trainer/PlanPath.h"
#include "raven2_trainer/StartHazard.h"
#include "raven2_trainer/runtime/simulator.h"

namespace raven2_trainer::ros_bridge {

/**
 * start_hazard, stop_hazard, plan, engage, disengage, {gold,green}/set_collisions: each only posts a request. plan,
 * which waits for its answer, has a queue and a thread of its own, so that nothing else ever waits behind it.
 */
class Services {
 public:
  /** @param[in] may_command without it only what makes things safer is offered: stop_hazard and disengage. */
  Services(ros::NodeHandle* node, runtime::Simulator* simulator, bool may_command);

  /** Makes a waiting plan() return and ends its thread. */
  void stop();

  /** Resolved names of what is offered. */
  std::vector<std::string> names() const;

 private:
  void offerCommands(ros::NodeHandle* node);
  void refuseInjection(std::uint32_t id) const;
  bool startHazard(StartHazard::Request& request, StartHazard::Response& response);
  bool stopHazard(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);
  bool plan(PlanPath::Request& request, PlanPath::Response& response);
  bool engage(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);
  bool disengage(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);

  bool setCollisions(Arm arm, const std_srvs::SetBool::Request& request, std_srvs::SetBool::Response* response);
  bool post(RequestKind kind, std_srvs::Trigger::Response* response);
  bool push(const Request& request);
  bool awaitPlan(std::uint32_t id, PlanResult* result) const;

  runtime::Simulator& simulator_;
  std::uint32_t next_id_;
  std::atomic<bool> stop_{false};
  std::mutex push_mutex_;  ///< the ring of requests has one producer at a time
  ros::NodeHandle plan_node_;
  ros::CallbackQueue plan_queue_;
  ros::AsyncSpinner plan_spinner_;
  ros::ServiceServer start_hazard_, stop_hazard_, plan_, engage_, disengage_;
  PerArm<ros::ServiceServer> set_collisions_;
};

}  // namespace raven2_trainer::ros_bridge
