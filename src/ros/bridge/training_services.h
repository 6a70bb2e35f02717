#pragma once

#include <ros/callback_queue.h>
#include <ros/node_handle.h>
#include <ros/spinner.h>
#include <std_srvs/SetBool.h>
#include <std_srvs/Trigger.h>

#include <string>
#include <vector>

#include "raven2_trainer/BeginReplay.h"
#include "raven2_trainer/RepeatTrial.h"
#include "ros/bridge/replay_task.h"
#include "ros/planning/planning_client.h"

namespace raven2_trainer::ros_bridge {

/**
 * What operators ask of the modes (doc/modes.md) and of the exercise. Each call waits for the loop's answer, on a queue
 * and its own thread; emergency_stop, which waits behind nobody, is on the node's.
 */
class TrainingServices {
 public:
  /**
   * @param[in] client must outlive this.
   * @param[in] may_command without it only what makes things safer is offered: emergency_stop.
   * @param[in] replay must outlive this. A caller makes the daemon read a directory of the caller's choice: so it is
   * nullptr, and not
   * offered, where other computers can call.
   */
  TrainingServices(ros::NodeHandle* node, PlanningClient* client, ReplayTask* replay, bool may_command);
  ~TrainingServices() { stop(); }
  TrainingServices(const TrainingServices&) = delete;
  TrainingServices& operator=(const TrainingServices&) = delete;

  /** Ends their thread. Before, end all waiting calls (PlanningClient::stop). */
  void stop() { spinner_.stop(); }

  /** Resolved names of what is offered. */
  std::vector<std::string> names() const;

 private:
  void offer(const std::string& service, const Request& request);
  void offerSwitch(const std::string& service, RequestKind kind);
  bool beginReplay(BeginReplay::Request& message, BeginReplay::Response& response);
  bool repeatTrial(RepeatTrial::Request& message, RepeatTrial::Response& response);
  bool emergencyStop(std_srvs::Trigger::Request& message, std_srvs::Trigger::Response& response);

  PlanningClient& client_;
  ReplayTask* const replay_;
  ros::CallbackQueue queue_;
  ros::NodeHandle node_;
  ros::AsyncSpinner spinner_;
  std::vector<ros::ServiceServer> servers_;
};

}  // namespace raven2_trainer::ros_bridge
