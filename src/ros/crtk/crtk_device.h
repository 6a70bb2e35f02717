#pragma once

#include <diagnostic_msgs/DiagnosticStatus.h>
#include <ros/callback_queue.h>
#include <ros/node_handle.h>
#include <ros/spinner.h>

#include <memory>

#include "ros/bridge/topic_source.h"
#include "ros/crtk/crtk_arm.h"
#include "ros/crtk/crtk_inbox.h"
#include "ros/crtk/crtk_kinematics.h"
#include "ros/crtk/crtk_listener.h"
#include "ros/crtk/crtk_stamp.h"
#include "ros/crtk/crtk_state_topic.h"
#include "ros/crtk/crtk_voice.h"
#include "ros/node/periodic_thread.h"

namespace raven2_trainer::ros_bridge {

/** Status of the CRTK clients; WARN in FAULT, ERROR where counters do not add up. */
diagnostic_msgs::DiagnosticStatus crtkStatus(const ServoState& servo, const CrtkCounts& heard);

/**
 * The arms as devices of the Collaborative Robotics Toolkit (doc/crtk.md). One thread receives commands, another one
 * publishes states every CrtkConfig::period.
 */
class CrtkDevice {
 public:
  /** @param[in] source, shared (the source's) outlive this. @param[in] may_command CrtkListener. */
  CrtkDevice(const ros::NodeHandle& node, const TopicSource& source, SharedState* shared, bool may_command);
  ~CrtkDevice() { stop(); }
  CrtkDevice(const CrtkDevice&) = delete;
  CrtkDevice& operator=(const CrtkDevice&) = delete;

  /** Any thread. */
  diagnostic_msgs::DiagnosticStatus status() const;
  /** Resolved names of what answers, to be registered again with a ROS master that came back. */
  std::vector<std::string> services() const;

  /** Ends its threads. */
  void stop();

 private:
  void publish();
  bool loadCycle();
  void reportRefused();

  const TopicSource source_;
  SharedState& shared_;
  ros::CallbackQueue queue_;
  ros::NodeHandle node_;
  ros::AsyncSpinner spinner_;
  CrtkInbox inbox_;
  PerArm<std::unique_ptr<CrtkVoice>> voices_;
  PerArm<std::unique_ptr<CrtkArm>> arms_;
  PerArm<std::unique_ptr<CrtkListener>> listeners_;
  PerArm<std::unique_ptr<CrtkKinematics>> kinematics_;
  std::unique_ptr<CrtkStateTopic> state_;  ///< of both arms, in the robot's own dialect
  CrtkStamp stamp_;
  CrtkCycle cycle_;
  Tick published_{-1};
  PeriodicThread publisher_;
};

}  // namespace raven2_trainer::ros_bridge
