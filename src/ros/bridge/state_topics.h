#pragma once

#include <geometry_msgs/TransformStamped.h>
#include <geometry_msgs/WrenchStamped.h>
#include <sensor_msgs/JointState.h>
#include <std_msgs/Bool.h>
#include <tf2_msgs/TFMessage.h>
#include <visualization_msgs/MarkerArray.h>

#include <vector>

#include "raven2_trainer/core/contact.h"
#include "ros/bridge/topic_source.h"
#include "ros/bridge/training_topics.h"
#include "ros/node/outlet.h"
#include "ros/planning/planning_topics.h"

namespace raven2_trainer::ros_bridge {

/** The states that one message each is made of. */
struct PublishedStates {
  ModelState model{};
  RobotState robot{};
  HapticState haptic{};
  ContactList contacts{};  ///< of the model's tick
};

/**
 * All topics of states, the same for a running daemon and for a recorded session: joint states,
 * forces, /tf and /tf_static, contacts, the edge of the workspace, plans, mode and exercise.
 */
class StateTopics {
 public:
  /** @param[in] queue [messages] of the topics that come in every cycle, for subscribers that are slow.
   *  @param[in] now of /tf_static, which is reported at once. */
  StateTopics(const TopicMaker& topics, const TopicSource& source, std::uint32_t queue, const ros::Time& now);

  /** Publishes one cycle of runtime.ros_period; one thread. News (plans, events) are the source's newest. */
  void publish(const PublishedStates& states, const ros::Time& stamp);

  /** Another run of a session begins: what was published before no longer counts; of events, those from now on are
   * published.
   */
  void startOver();

 private:
  void publishMarkers(const PublishedStates& states, const ros::Time& stamp);
  void publishEdge(const PublishedStates& states);
  void publishTransforms(const PublishedStates& states, const ros::Time& stamp);
  void addCameras(const ModelState& model,
                  const ros::Time& stamp,
                  std::vector<geometry_msgs::TransformStamped>* transforms);
  void addArms(const std::string& prefix,
               const PerArm<JointArray>& q,
               const ros::Time& stamp,
               std::vector<geometry_msgs::TransformStamped>* transforms);

  TopicSource source_;
  PlanningTopics planning_;
  TrainingTopics training_;
  Outlet<sensor_msgs::JointState> model_joints_, robot_joints_;
  PerArm<Outlet<geometry_msgs::WrenchStamped>> forces_;
  Outlet<tf2_msgs::TFMessage> transforms_, fixed_transforms_;
  Outlet<visualization_msgs::MarkerArray> markers_;
  Outlet<std_msgs::Bool> edge_;
  std::vector<double> positions_;
  std::vector<Pose> poses_;
  const std::vector<bool> is_fixed_;  ///< by link index: published by /tf_static
  int cycle_{0};
  bool has_published_edge_{false}, published_edge_{false};
};

/** Is a tool held back by the end of its workspace while a hand moves it (control::isAtEdge), or does a hand feel the
 * edge of its master's? */
bool isAtEdge(const ModelState& model, const HapticState& haptic) noexcept;

/** Cycles of `base` seconds in `period` seconds, at least 1. */
int cyclesIn(double period, double base) noexcept;

}  // namespace raven2_trainer::ros_bridge
