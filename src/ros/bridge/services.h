#pragma once

#include <ros/node_handle.h>
#include <std_srvs/SetBool.h>
#include <std_srvs/Trigger.h>

#include <cstdint>
#include <string>
#include <vector>

#include "raven2_trainer/StartHazard.h"
#include "raven2_trainer/daemon/simulator.h"
#include "ros/planning/planning_client.h"

namespace raven2_trainer::ros_bridge {

/** start_hazard, inject_hazard, stop_hazard, engage, disengage, pause, {gold,green}/set_collisions: each only posts a
 *  request, but pause, which waits for its answer, at most half a second. The loop refuses a pause where nothing would
 *  be paused. */
class Services {
 public:
  /**
   * @param[in] simulator, client must outlive this.
   * @param[in] may_command without it only what makes things safer is offered: stop_hazard, disengage and pause.
   */
  Services(ros::NodeHandle* node, daemon::Simulator* simulator, PlanningClient* client, bool may_command);

  /** Resolved names of what is offered. */
  std::vector<std::string> names() const;

 private:
  void offerCommands(ros::NodeHandle* node);
  bool startHazard(StartHazard::Request& request, StartHazard::Response& response);
  bool injectHazard(StartHazard::Request& request, StartHazard::Response& response);
  bool arm(FaultOrder order, const StartHazard::Request& request, StartHazard::Response* answer);
  bool stopHazard(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);
  bool engage(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);
  bool disengage(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);

  bool pause(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);
  bool setCollisions(Arm arm, const std_srvs::SetBool::Request& request, std_srvs::SetBool::Response* response);
  bool post(RequestKind kind, std_srvs::Trigger::Response* response);

  daemon::Simulator& simulator_;
  PlanningClient& client_;
  ros::ServiceServer start_hazard_, inject_hazard_, stop_hazard_, engage_, disengage_, pause_;
  PerArm<ros::ServiceServer> set_collisions_;
};

}  // namespace raven2_trainer::ros_bridge
