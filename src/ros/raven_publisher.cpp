#include "raven2_trainer/ros/raven_publisher.h"

#include <ros/init.h>
#include <ros/node_handle.h>
#include <ros/spinner.h>
#include <std_srvs/Trigger.h>

#include "ros/messages.h"
#include "ros/periodic_thread.h"

namespace raven2_trainer::ros_bridge {
namespace {

constexpr double kPeriod = 0.03;  // [s] gate of the robot's publish_joints (raven2.md 5.1)

}  // namespace

struct RavenPublisher::Impl {
  Impl(double shaft, std::function<RobotState()> source, std::function<void()> button)
      : d4(shaft),
        state(std::move(source)),
        press_start(std::move(button)),
        joints(node.advertise<sensor_msgs::JointState>("/joint_states", 1)),
        service(node.advertiseService("virtual_raven/press_start", &Impl::pressStart, this)),
        spinner(1) {}

  bool pressStart(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
    press_start();
    response.success = true;
    return true;
  }

  void publish() {
    sensor_msgs::JointState message = jointState(state(), d4, ros::Time::now());
    message.velocity.clear();
    joints.publish(message);
  }

  double d4;
  std::function<RobotState()> state;
  std::function<void()> press_start;
  ros::NodeHandle node;
  ros::Publisher joints;
  ros::ServiceServer service;
  ros::AsyncSpinner spinner;
  PeriodicThread publisher;
};

RavenPublisher::RavenPublisher(double d4, std::function<RobotState()> state, std::function<void()> press_start)
    : impl_(std::make_unique<Impl>(d4, std::move(state), std::move(press_start))) {}

RavenPublisher::~RavenPublisher() {
  stop();
}

void RavenPublisher::start() {
  impl_->spinner.start();
  impl_->publisher.start(kPeriod, [this] { impl_->publish(); });
}

void RavenPublisher::stop() {
  impl_->publisher.stop();
  impl_->spinner.stop();
  ros::shutdown();
}

}  // namespace raven2_trainer::ros_bridge
