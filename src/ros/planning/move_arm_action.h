#pragma once

#include <actionlib/server/simple_action_server.h>
#include <ros/node_handle.h>

#include "raven2_trainer/MoveArmAction.h"
#include "raven2_trainer/daemon/simulator.h"
#include "raven2_trainer/kinematics/arms_config.h"
#include "ros/node/periodic_thread.h"
#include "ros/planning/move_arm_task.h"
#include "ros/planning/planning_client.h"
#include "ros/planning/planning_messages.h"

namespace raven2_trainer::ros_bridge {

/**
 * Action `move_arm`: plans and executes. One goal at a time; a newer one cancels the older. A thread checks it
 * 50 times a second, and sends the client its progress 10 times a second.
 */
class MoveArmServer {
 public:
  /** `geometry`, `simulator`, `client` must outlive this. */
  MoveArmServer(const ros::NodeHandle& node,
                const ArmGeometry& geometry,
                const daemon::Simulator& simulator,
                PlanningClient* client);

  /** Ends the thread; a goal under way is aborted. After PlanningClient::stop(), or it waits for answers. */
  void stop();

 private:
  void look();
  void begin();
  void end();
  void publishFeedback();

  const ArmGeometry& geometry_;
  const daemon::Simulator& simulator_;
  MoveArmTask task_;
  StatusClock clock_;
  int looks_{0};
  actionlib::SimpleActionServer<MoveArmAction> server_;
  PeriodicThread thread_;
};

}  // namespace raven2_trainer::ros_bridge
