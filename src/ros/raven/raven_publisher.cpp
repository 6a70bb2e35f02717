#include "raven2_trainer/ros/raven_publisher.h"

#include <ros/init.h>
#include <ros/node_handle.h>
#include <ros/spinner.h>
#include <std_srvs/Trigger.h>

#include "ros/node/exposure.h"
#include "ros/raven/raven_conversion.h"

namespace raven2_trainer::ros_bridge {
namespace {

const ros::Duration kJointGate(0.03);        // of the robot's publish_joints (raven2.md 5.1)
constexpr std::uint32_t kStateQueue = 100;   // [messages] a recorder may be away for that many cycles
constexpr std::uint32_t kAutomoveQueue = 1;  // the robot's own
constexpr int kWaitMs = 20;

}  // namespace

struct RavenPublisher::Impl {
  Impl(double shaft, bool may_command, robot::RavenServer* virtual_raven)
      : d4(shaft),
        server(*virtual_raven),
        states(node.advertise<raven_2::RavenState>("/ravenstate", kStateQueue)),
        joints(node.advertise<sensor_msgs::JointState>("/joint_states", 1)),
        spinner(1) {
    if (may_command) takeCommands();
    spinner.start();
    thread.start({"raven_ros", ThreadConfig{0, -1}}, [this] { run(); });
  }

  ~Impl() {
    stop.store(true);
    thread.join();
    spinner.stop();
  }

  void takeCommands() {
    automoves =
        node.subscribe("/raven_automove", kAutomoveQueue, &Impl::automove, this, ros::TransportHints().tcpNoDelay());
    service = node.advertiseService("virtual_raven/press_start", &Impl::pressStart, this);
  }

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
  robot::RavenServer& server;
  ros::NodeHandle node;
  ros::Publisher states, joints;
  ros::Subscriber automoves;
  ros::ServiceServer service;
  ros::AsyncSpinner spinner;
  raven_2::RavenState state;
  ros::Time last_state, last_joints;
  std::atomic<bool> stop{false};
  threads::Thread thread;
};

RavenPublisher::RavenPublisher(const ArmGeometry& geometry, bool enable_remote_control, robot::RavenServer* server)
    : d4_(geometry.d4), enable_remote_control_(enable_remote_control), server_(*server) {}

RavenPublisher::~RavenPublisher() {
  stop();
}

void RavenPublisher::start() {
  RavenReport old;
  while (server_.nextReport(&old)) {  // of the time without a master
  }
  lost_before_.store(server_.reportsDropped());
  impl_ = std::make_unique<Impl>(d4_, mayCommand(enable_remote_control_), &server_);
}

void RavenPublisher::stop() {
  impl_.reset();
}

std::vector<std::string> RavenPublisher::services() const {
  if (!impl_ || !impl_->service) return {};
  return {impl_->service.getService()};
}

std::uint64_t RavenPublisher::lost() const noexcept {
  return server_.reportsDropped() - lost_before_.load();
}

}  // namespace raven2_trainer::ros_bridge
