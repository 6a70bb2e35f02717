#pragma once

#include <ros/node_handle.h>
#include <std_srvs/Trigger.h>

#include <atomic>
#include <cstdint>

#include "raven2_trainer/PlanPath.h"
#include "raven2_trainer/StartHazard.h"
#include "raven2_trainer/runtime/simulator.h"

namespace raven2_trainer::ros_bridge {

/** start_hazard, stop_hazard, plan, engage, disengage: each only posts a request; one spinner thread calls them all,
 *  because the rings have one producer. */
class Services {
 public:
  Services(ros::NodeHandle* node, runtime::Simulator* simulator);

  /** Makes a waiting plan() return. */
  void stop() noexcept { stop_.store(true); }

 private:
  bool startHazard(StartHazard::Request& request, StartHazard::Response& response);
  bool stopHazard(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);
  bool plan(PlanPath::Request& request, PlanPath::Response& response);
  bool engage(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);
  bool disengage(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);

  bool post(RequestKind kind, std_srvs::Trigger::Response* response);
  bool awaitPlan(std::uint32_t id, PlanResult* result) const;

  runtime::Simulator& simulator_;
  std::uint32_t next_id_;
  std::atomic<bool> stop_{false};
  ros::ServiceServer start_hazard_, stop_hazard_, plan_, engage_, disengage_;
};

}  // namespace raven2_trainer::ros_bridge
