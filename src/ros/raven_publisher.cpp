#include "raven2_trainer/ros/raven_publisher.h"

#include <ros/init.h>
#include <ros/node_handle.h>
#include <ros/spinner.h>
#include <std_srvs/Trigger.h>

#include "ros/raven_conversion.h"

namespace raven2_trainer::ros_bridge {
namespace {

const ros::Duration kJointGate(0.03);        // of the robot's publish_joints (raven2.md 5.1)
constexpr std::uint32_t kStateQueue = 100;   // [messages] a recorder may be away for that many cycles
constexpr std::uint32_t kAutomoveQueue = 1;  // the robot's own
constexpr int kWaitMs = 20;

}  // namespace

struct RavenPublisher::Impl {
  Impl(double shaft, runtime::RavenServer* virtual_raven)
      : d4(shaft),
        server(*virtual_raven),
        states(node.advertise<raven_2::RavenState>("/ravenstate", kStateQueue)),
        joints(node.advertise<sensor_msgs::JointState>("/joint_states", 1)),
        automoves(node.subscribe("/raven_automove",
                                 kAutomoveQueue,
                                 &Impl::automove,
                                 this,
                                 ros::TransportHints().tcpNoDelay())),
        service(node.advertiseService("virtual_raven/press_start", &Impl::pressStart, this)),
        spinner(1) {}

  bool pressStart(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
    server.pressStart();
    response.success = true;
    return true;
  }

  void automove(const raven_2::RavenAutomove& message) {
    const std::optional<RavenAutomove> move = toAutomove(message);
    if (move) server.automove(*move);
  }

  void run() {
    RavenReport report;
    while (!stop.load()) {
      server.waitForReport(kWaitMs);
      while (!stop.load() && server.nextReport(&report))
        publish(report);
    }
  }

  void publish(const RavenReport& report) {
    const ros::Time now = ros::Time::now();
    state.hdr.stamp = now;
    state.dt = last_state.isZero() ? ros::Duration(0.0) : now - last_state;
    last_state = now;
    fillRavenState(report, &state);
    states.publish(state);
    if (now - last_joints < kJointGate && now >= last_joints) return;
    last_joints = now;
    joints.publish(ravenJointState(report, d4, now));
  }

  double d4;
  runtime::RavenServer& server;
  ros::NodeHandle node;
  ros::Publisher states, joints;
  ros::Subscriber automoves;
  ros::ServiceServer service;
  ros::AsyncSpinner spinner;
  raven_2::RavenState state;
  ros::Time last_state, last_joints;
  std::atomic<bool> stop{false};
  runtime::Thread thread;
};

RavenPublisher::RavenPublisher(double d4, runtime::RavenServer* server) : impl_(std::make_unique<Impl>(d4, server)) {}

RavenPublisher::~RavenPublisher() {
  stop();
}

void RavenPublisher::start() {
  impl_->spinner.start();
  impl_->thread.start({"raven_ros", ThreadConfig{0, -1}}, [this] { impl_->run(); });
}

void RavenPublisher::stop() {
  impl_->stop.store(true);
  impl_->thread.join();
  impl_->spinner.stop();
  ros::shutdown();
}

}  // namespace raven2_trainer::ros_bridge
