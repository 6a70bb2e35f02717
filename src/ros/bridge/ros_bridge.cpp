#include "raven2_trainer/ros/ros_bridge.h"

#include <ros/node_handle.h>
#include <ros/spinner.h>

#include <array>
#include <memory>
#include <string>
#include <utility>

#include "raven2_trainer/loop/frame_states.h"
#include "raven2_trainer/net/clock.h"
#include "ros/bridge/messages.h"
#include "ros/bridge/services.h"
#include "ros/bridge/session_topic.h"
#include "ros/bridge/state_topics.h"
#include "ros/bridge/training_services.h"
#include "ros/crtk/crtk_device.h"
#include "ros/devices/joy_pedals.h"
#include "ros/node/exposure.h"
#include "ros/node/periodic_thread.h"
#include "ros/node/rates.h"
#include "ros/node/topic.h"
#include "ros/pictures/camera_view.h"
#include "ros/pictures/live_camera.h"
#include "ros/pictures/other_views.h"
#include "ros/pictures/picture_stamp.h"
#include "ros/planning/move_arm_action.h"
#include "ros/planning/planning_client.h"
#include "ros/planning/planning_services.h"

namespace raven2_trainer::ros_bridge {
namespace {

constexpr double kNewsPeriod = 0.05;  // [s] shortest time between two urgent messages to the operator

using News = std::array<std::uint64_t, 6>;  // counts and flags of urgent events; RosBridge::Impl::isNews

}  // namespace

struct RosBridge::Impl {
  Impl(daemon::Simulator* daemon, const FileHashes& hashes)
      : simulator(*daemon),
        may_command(mayCommand(daemon->config().runtime.enable_remote_control)),
        client(&daemon->shared()),
        services(&node, daemon, &client, may_command),
        planning_services(node,
                          daemon->config().arms.geometry,
                          daemon->config().planner.time_limit,
                          &client,
                          may_command),
        replay(
            &client,
            [daemon](const std::string& path) { return daemon->openReplay(path); },
            daemon->paths().directory),
        training_services(&node, &client, isLoopbackOnly() ? &replay : nullptr, may_command),
        topics(TopicMaker(&node), source(), kQueue, ros::Time::now()),
        view(node, daemon->config().render, &daemon->shared()),
        others(node, daemon->config().render),
        camera(&node, daemon->config().render, view),
        pedals(daemon->config().network.joy, daemon->shared(), &client, may_command),
        configuration(node.advertise<SessionConfiguration>("session/configuration", 1, kLatched)),
        diagnostic_arrays(node.advertise<diagnostic_msgs::DiagnosticArray>("/diagnostics", kQueue)),
        spinner(1) {
    if (may_command) move_arm = std::make_unique<MoveArmServer>(node, daemon->config().arms.geometry, *daemon, &client);
    if (daemon->config().crtk.enabled)
      crtk = std::make_unique<CrtkDevice>(node, source(), &daemon->shared(), may_command);
    listenToPedals(daemon->config().network.joy);
    configuration.publish(sessionConfiguration(daemon->config(), daemon->paths().directory, hashes, ros::Time::now()));
    spinner.start();
    publisher.start(simulator.config().runtime.ros_period, [this] { publish(); });
    simulator.setImageSink([this](const daemon::LiveImage& picture) { publishImage(picture); });
  }

  ~Impl() {
    simulator.setImageSink({});
    planning_services.stop();
    training_services.stop();
    if (move_arm) move_arm->stop();
    if (crtk) crtk->stop();
    publisher.stop();
    simulator.shared().pictures_watched.store({});
    view.stop();
    spinner.stop();
  }

  TopicSource source() const {
    return {simulator.config(), simulator.raven(), simulator.shared(), simulator.bodyNames(),
            [this] { return simulator.planCounts(); }};
  }

  void listenToPedals(const JoyConfig& joy) {
    if (joy.topic.empty()) return;
    const auto hear = [this](const sensor_msgs::JoyConstPtr& message) { pedals.hear(*message, net::monotonicNow()); };
    const auto at_once = ros::TransportHints().tcpNoDelay();
    joy_messages = node.subscribe<sensor_msgs::Joy>(joy.topic, kQueue, hear, ros::VoidConstPtr(), at_once);
  }

  void publish() {
    const ros::Time stamp = ros::Time::now();
    const SharedState& shared = simulator.shared();
    PublishedStates states;
    loop::loadModel(shared, &states.model, &states.contacts);
    states.robot = shared.robot.load();
    states.haptic = shared.haptic.load();
    topics.publish(states, stamp);
    reportViewers();
    pedals.idle(net::monotonicNow());
    const double period = simulator.config().runtime.ros_period;
    if (cycle % cyclesIn(kDiagnosticsPeriod, period) == 0 || (cycle % cyclesIn(kNewsPeriod, period) == 0 && isNews())) {
      publishDiagnostics(states, stamp);
    }
    ++cycle;
  }

  void publishDiagnostics(const PublishedStates& states, const ros::Time& stamp) {
    const SharedState& shared = simulator.shared();
    const SessionCounts counts = simulator.counts();
    const LivePicture picture = shared.live_picture.load();
    diagnostic_msgs::DiagnosticArray array =
        diagnostics(counts, shared, states.robot, net::monotonicNow(), simulator.realtimeStatus(), stamp);
    array.status.push_back(pictureStatus(picture));
    array.status.push_back(linkStatus("pedals to daemon", shared.pedal_link.load()));
    if (crtk) array.status.push_back(crtk->status());
    array.status.push_back(realCameraStatus(simulator.config().render, shared.real_picture_ns.load(),
                                            states.model.view != 0, net::monotonicNow()));
    rates.addTo(&array, streams(counts, picture), net::monotonicNow());
    diagnostic_arrays.publish(array);
  }

  /** In every cycle, so that who comes new waits for the next frame alone. */
  void reportViewers() {
    WatchedPictures watched = others.watched();
    watched.live = camera.isWatched() || view.isWatched() ? 1 : 0;
    simulator.shared().pictures_watched.store(watched);
  }

  /** Since the last time it was asked: a second master, a loop that was late or gave time up, trouble with the disk,
   * another rate or size of the live picture, or its end? */
  bool isNews() {
    const SharedState& shared = simulator.shared();
    const LinkCounts master = shared.master_link.load();
    const LivePicture picture = shared.live_picture.load();
    const News news{master.rejected[static_cast<std::size_t>(Reject::kForeignSource)],
                    shared.recorder.load().failing,
                    shared.physics_timing.load().late_runs,
                    shared.haptic_timing.load().late_runs,
                    picture.changes,
                    picture.failed};
    return std::exchange(published, news) != news;
  }

  /** On the render thread; roscpp's publish is thread-safe. */
  void publishImage(const daemon::LiveImage& picture) {
    const ros::Time stamp = picture_stamp.of(picture.time_ns, net::monotonicNow(), ros::Time::now());
    if (picture.viewpoint == daemon::Viewpoint::kLive) return camera.show(picture, stamp);
    others.show(picture, stamp);
  }

  daemon::Simulator& simulator;
  ros::NodeHandle node;
  const bool may_command;
  PlanningClient client;
  Services services;
  PlanningServices planning_services;
  ReplayTask replay;
  TrainingServices training_services;
  StateTopics topics;
  CameraView view;
  OtherViews others;
  LiveCamera camera;
  PictureStamp picture_stamp;
  JoyPedals pedals;
  std::unique_ptr<MoveArmServer> move_arm;  ///< if commands may be given
  std::unique_ptr<CrtkDevice> crtk;         ///< if the configuration says so
  ros::Subscriber joy_messages;
  ros::Publisher configuration, diagnostic_arrays;
  Rates rates;
  ros::AsyncSpinner spinner;
  PeriodicThread publisher;
  int cycle{0};
  News published{};
};

RosBridge::RosBridge(daemon::Simulator* simulator)
    : simulator_(*simulator), hashes_(hashConfiguration(simulator->config())) {}

RosBridge::~RosBridge() {
  stop();
}

void RosBridge::start() {
  impl_ = std::make_unique<Impl>(&simulator_, hashes_);
}

void RosBridge::stop() {
  impl_.reset();
}

std::vector<std::string> RosBridge::services() const {
  if (!impl_) return {};
  std::vector<std::string> names = impl_->services.names();
  for (const auto& more : {impl_->planning_services.names(), impl_->training_services.names()})
    names.insert(names.end(), more.begin(), more.end());
  if (!impl_->crtk) return names;
  const std::vector<std::string> queries = impl_->crtk->services();
  names.insert(names.end(), queries.begin(), queries.end());
  return names;
}

}  // namespace raven2_trainer::ros_bridge
