#pragma once

#include <geometry_msgs/WrenchStamped.h>
#include <gtest/gtest.h>
#include <ros/callback_queue.h>
#include <ros/ros.h>
#include <sensor_msgs/JointState.h>

#include <cmath>
#include <functional>
#include <map>
#include <string>

// Shared by the integration tests: the newest message of each topic, and a wait for a condition with a deadline.

namespace raven2_trainer {

constexpr double kStartDeadline = 30.0;  // [s] processes, homing and first pedal-down on a busy machine

/** Handles messages as they come, until `condition` holds. @return false after `seconds`. */
inline bool waitFor(const std::function<bool()>& condition, double seconds) {
  const ros::WallTime deadline = ros::WallTime::now() + ros::WallDuration(seconds);
  while (ros::ok() && ros::WallTime::now() < deadline) {
    ros::getGlobalCallbackQueue()->callAvailable(ros::WallDuration(0.01));
    if (condition()) return true;
  }
  return false;
}

/** Newest message of a topic, and how many were received. */
template <typename Message>
class Latest {
 public:
  explicit Latest(const std::string& topic)
      : subscriber_(node_.subscribe<Message>(topic, 50, [this](const typename Message::ConstPtr& message) {
          message_ = *message;
          received_ = ros::WallTime::now();
          ++count_;
        })) {}

  int count() const { return count_; }
  const Message& get() const { return message_; }
  double age() const { return (ros::WallTime::now() - received_).toSec(); }

 private:
  ros::NodeHandle node_;
  Message message_;
  ros::WallTime received_;
  int count_{0};
  ros::Subscriber subscriber_;
};

/** Position of one joint by name; NaN if the joint is missing. */
inline double position(const sensor_msgs::JointState& state, const std::string& joint) {
  for (std::size_t i = 0; i < state.name.size() && i < state.position.size(); ++i) {
    if (state.name[i] == joint) return state.position[i];
  }
  return std::nan("");
}

inline double magnitude(const geometry_msgs::WrenchStamped& wrench) {
  return std::hypot(wrench.wrench.force.x, wrench.wrench.force.y, wrench.wrench.force.z);
}

/** Whether the gold arm's shoulder has left its home: then the scripted surgeon is at work. */
inline bool isMoving(const Latest<sensor_msgs::JointState>& joints) {
  return joints.count() > 0 && std::abs(position(joints.get(), "shoulder_L") - 0.5236) > 0.02;
}

/** gtest's main with ROS, for every test program of this folder. */
#define RAVEN2_INTEGRATION_MAIN(name)     \
  int main(int argc, char** argv) {       \
    testing::InitGoogleTest(&argc, argv); \
    ros::init(argc, argv, name);          \
    ros::NodeHandle keeps_ros_alive;      \
    return RUN_ALL_TESTS();               \
  }

}  // namespace raven2_trainer
