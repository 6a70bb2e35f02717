#include "raven2_trainer/ros/ros_bridge.h"

#include <ros/node_handle.h>
#include <ros/spinner.h>
#include <tf2_msgs/TFMessage.h>

#include <array>
#include <memory>
#include <set>
#include <string>
#include <utility>

#include "raven2_trainer/net/clock.h"
#include "ros/camera_view.h"
#include "ros/exposure.h"
#include "ros/joy_pedals.h"
#include "ros/messages.h"
#include "ros/move_arm_action.h"
#include "ros/periodic_thread.h"
#include "ros/planning_client.h"
#include "ros/planning_services.h"
#include "ros/planning_topics.h"
#include "ros/services.h"
#include "ros/stereo_view.h"
#include "ros/training_services.h"
#include "ros/training_topics.h"

namespace raven2_trainer::ros_bridge {
namespace {

constexpr double kTransformPeriod = 0.033;  // [s] as the robot's own /joint_states
constexpr double kDiagnosticsPeriod = 1.0;  // [s] custom of /diagnostics
constexpr double kNewsPeriod = 0.05;        // [s] what an operator must hear of at once is told no more often than this
constexpr std::uint32_t kQueue = 10;

int every(double period, double base) {
  return std::max(1, static_cast<int>(period / base + 0.5));
}

}  // namespace

struct RosBridge::Impl {
  explicit Impl(runtime::Simulator* daemon)
      : simulator(*daemon),
        may_command(mayCommand(daemon->config().runtime.enable_remote_control)),
        client(&daemon->shared()),
        services(&node, daemon, &client, may_command),
        planning_services(node, daemon->config(), &client, may_command),
        replay(
            &client,
            [daemon](const std::string& path) { return daemon->openReplay(path); },
            daemon->paths().directory),
        training_services(&node, &client, isLoopbackOnly() ? &replay : nullptr, may_command),
        planning_topics(&node, *daemon),
        training_topics(&node, *daemon),
        view(node, daemon->config().render, &daemon->shared()),
        stereo(node, daemon->config().render.stereo),
        pedals(daemon->config().network.joy, daemon->shared(), &client, may_command),
        model_joints(node.advertise<sensor_msgs::JointState>("model/joint_states", kQueue)),
        robot_joints(node.advertise<sensor_msgs::JointState>("robot/joint_states", kQueue)),
        forces{node.advertise<geometry_msgs::WrenchStamped>("haptic/gold/force", kQueue),
               node.advertise<geometry_msgs::WrenchStamped>("haptic/green/force", kQueue)},
        images(node.advertise<sensor_msgs::Image>("camera/image_raw", 2)),
        camera_infos(node.advertise<sensor_msgs::CameraInfo>("camera/camera_info", 2)),
        transforms(node.advertise<tf2_msgs::TFMessage>("/tf", kQueue)),
        diagnostic_arrays(node.advertise<diagnostic_msgs::DiagnosticArray>("/diagnostics", kQueue)),
        spinner(1) {
    positions.resize(simulator.raven().description.links.size());
    poses.resize(positions.size());
    if (may_command) move_arm = std::make_unique<MoveArmServer>(node, *daemon, &client);
    listenToPedals(daemon->config().network.joy);
    spinner.start();
    publisher.start(simulator.config().runtime.ros_period, [this] { publish(); });
    simulator.setImageSink([this](const runtime::LiveImage& picture) { publishImage(picture); });
  }

  ~Impl() {
    simulator.setImageSink({});
    simulator.shared().stereo_watched.store(0);
    planning_services.stop();
    training_services.stop();
    if (move_arm) move_arm->stop();
    publisher.stop();
    view.stop();
    spinner.stop();
  }

  void listenToPedals(const JoyConfig& joy) {
    if (joy.topic.empty()) return;
    const auto hear = [this](const sensor_msgs::JoyConstPtr& message) { pedals.hear(*message, net::monotonicNow()); };
    const auto at_once = ros::TransportHints().tcpNoDelay();
    joy_messages = node.subscribe<sensor_msgs::Joy>(joy.topic, kQueue, hear, ros::VoidConstPtr(), at_once);
  }

  void publish() {
    const ros::Time stamp = ros::Time::now();
    const ModelState model = simulator.shared().model.load();
    const RobotState robot = simulator.shared().robot.load();
    const HapticState haptic = simulator.shared().haptic.load();
    const double d4 = simulator.config().arms.geometry.d4;
    model_joints.publish(jointState(model, d4, stamp));
    if (robot.frame > 0 && robot.connected != 0) robot_joints.publish(jointState(robot, d4, stamp));
    for (const Arm arm : kArms)
      at(forces, arm).publish(wrench(haptic, arm, stamp));
    planning_topics.publish(model, stamp);
    training_topics.publish(model, stamp);
    pedals.idle(net::monotonicNow());
    const double period = simulator.config().runtime.ros_period;
    if (cycle % every(kTransformPeriod, period) == 0) publishTransforms(model, robot, stamp);
    if (cycle % every(kDiagnosticsPeriod, period) == 0 || (cycle % every(kNewsPeriod, period) == 0 && isNews())) {
      diagnostic_msgs::DiagnosticArray array = diagnostics(simulator.counts(), simulator.shared(), robot,
                                                           net::monotonicNow(), simulator.realtimeStatus(), stamp);
      array.status.push_back(linkStatus("pedals to daemon", simulator.shared().pedal_link.load()));
      diagnostic_arrays.publish(array);
    }
    ++cycle;
  }

  /** Since the last time it was asked: a second master, a loop that was late or gave time up, trouble with the disk? */
  bool isNews() {
    const SharedState& shared = simulator.shared();
    const LinkCounts master = shared.master_link.load();
    const std::array<std::uint64_t, 4> news{master.rejected[static_cast<std::size_t>(Reject::kForeignSource)],
                                            shared.recorder.load().failing, shared.physics_timing.load().late_runs,
                                            shared.haptic_timing.load().late_runs};
    return std::exchange(told, news) != news;
  }

  void publishTransforms(const ModelState& model, const RobotState& robot, const ros::Time& stamp) {
    tf2_msgs::TFMessage message;
    addArms("model/", {model.arms[0].q, model.arms[1].q}, stamp, &message);
    if (robot.frame > 0 && robot.connected != 0) addArms("robot/", {robot.arms[0].q, robot.arms[1].q}, stamp, &message);
    addCameras(model, stamp, &message);
    transforms.publish(message);
  }

  /** Those of the live pictures, where they stand now. */
  void addCameras(const ModelState& model, const ros::Time& stamp, tf2_msgs::TFMessage* message) {
    const RenderConfig& render = simulator.config().render;
    std::set<std::string> names{render.live_camera, render.stereo.camera + "_left", render.stereo.camera + "_right"};
    for (const std::string& name : names) {
      const CameraConfig& config = runtime::findCamera(render, name);
      const model::Camera camera = model::cameraAt(config, model, simulator.raven().X_WB, 2, 2);
      message->transforms.push_back(transform(camera.X_WC, opticalFrame(name), stamp));
    }
  }

  void addArms(const std::string& prefix,
               const PerArm<JointArray>& q,
               const ros::Time& stamp,
               tf2_msgs::TFMessage* message) {
    simulator.raven().linkPosesInWorld(q, &positions, &poses);
    const auto& links = simulator.raven().description.links;
    for (std::size_t i = 0; i < links.size(); ++i) {
      message->transforms.push_back(transform(poses[i], prefix + links[i].name, stamp));
    }
  }

  /** On the render thread; roscpp's publish is thread-safe. */
  void publishImage(const runtime::LiveImage& picture) {
    const ros::Time stamp = stampOf(picture.time_ns, net::monotonicNow(), ros::Time::now());
    if (picture.eye != runtime::Eye::kMiddle) return stereo.show(picture, stamp);
    simulator.shared().stereo_watched.store(stereo.isWatched() ? 1 : 0);
    const std::string frame = opticalFrame(simulator.config().render.live_camera);
    const bool is_view = picture.is_view && view.isWatched();
    if (is_view || images.getNumSubscribers() > 0) {
      const sensor_msgs::Image message = image(picture, frame, stamp);
      images.publish(message);
      if (is_view) view.show(message);
    }
    camera_infos.publish(cameraInfo(picture.camera, frame, stamp));
  }

  runtime::Simulator& simulator;
  ros::NodeHandle node;
  const bool may_command;
  PlanningClient client;
  Services services;
  PlanningServices planning_services;
  ReplayTask replay;
  TrainingServices training_services;
  PlanningTopics planning_topics;
  TrainingTopics training_topics;
  CameraView view;
  StereoView stereo;
  JoyPedals pedals;
  std::unique_ptr<MoveArmServer> move_arm;  ///< if commands may be given
  ros::Publisher model_joints, robot_joints;
  PerArm<ros::Publisher> forces;
  ros::Subscriber joy_messages;
  ros::Publisher images, camera_infos, transforms, diagnostic_arrays;
  ros::AsyncSpinner spinner;
  PeriodicThread publisher;
  std::vector<double> positions;
  std::vector<Pose> poses;
  int cycle{0};
  std::array<std::uint64_t, 4> told{};
};

RosBridge::RosBridge(runtime::Simulator* simulator) : simulator_(*simulator) {}

RosBridge::~RosBridge() {
  stop();
}

void RosBridge::start() {
  impl_ = std::make_unique<Impl>(&simulator_);
}

void RosBridge::stop() {
  impl_.reset();
}

std::vector<std::string> RosBridge::services() const {
  if (!impl_) return {};
  std::vector<std::string> names = impl_->services.names();
  for (const auto& more : {impl_->planning_services.names(), impl_->training_services.names()})
    names.insert(names.end(), more.begin(), more.end());
  return names;
}

}  // namespace raven2_trainer::ros_bridge
