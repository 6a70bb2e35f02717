#include "ros/bridge/state_topics.h"

#include <algorithm>
#include <string>

#include "raven2_trainer/control/reach.h"
#include "raven2_trainer/model/camera.h"
#include "ros/bridge/fixed_frames.h"
#include "ros/bridge/markers.h"
#include "ros/bridge/messages.h"
#include "ros/node/topic.h"

namespace raven2_trainer::ros_bridge {
namespace {

constexpr double kTransformPeriod = 0.033;  // [s] as the robot's own /joint_states

}  // namespace

bool isAtEdge(const ModelState& model, const HapticState& haptic) noexcept {
  const auto is_held_back = [&model](Arm arm) { return control::isAtEdge(model, arm); };
  const auto is_felt = [](const Vec3& force) { return force != Vec3{}; };
  return std::any_of(kArms.begin(), kArms.end(), is_held_back) ||
         std::any_of(haptic.edge_B.begin(), haptic.edge_B.end(), is_felt);
}

int cyclesIn(double period, double base) noexcept {
  return std::max(1, static_cast<int>(period / base + 0.5));
}

StateTopics::StateTopics(const TopicMaker& topics, const TopicSource& source, std::uint32_t queue, const ros::Time& now)
    : source_(source),
      planning_(topics, source),
      training_(topics, source),
      model_joints_(topics.advertise<sensor_msgs::JointState>("model/joint_states", queue)),
      robot_joints_(topics.advertise<sensor_msgs::JointState>("robot/joint_states", queue)),
      forces_{topics.advertise<geometry_msgs::WrenchStamped>("haptic/gold/force", queue),
              topics.advertise<geometry_msgs::WrenchStamped>("haptic/green/force", queue)},
      transforms_(topics.advertise<tf2_msgs::TFMessage>("/tf", queue)),
      fixed_transforms_(topics.advertise<tf2_msgs::TFMessage>("/tf_static", queue, kLatched)),
      markers_(topics.advertise<visualization_msgs::MarkerArray>("markers", queue)),
      edge_(topics.advertise<std_msgs::Bool>("workspace_edge", queue, kLatched)),
      positions_(source.raven.description.links.size()),
      poses_(positions_.size()),
      is_fixed_(fixedLinks(source.raven.description)) {
  fixed_transforms_.publish(fixedFrames(source.raven, source.render, now));
}

void StateTopics::publish(const PublishedStates& states, const ros::Time& stamp) {
  const double d4 = source_.geometry.d4;
  model_joints_.publish(jointState(states.model, d4, stamp));
  if (states.robot.frame > 0 && states.robot.connected != 0) robot_joints_.publish(jointState(states.robot, d4, stamp));
  for (const Arm arm : kArms)
    at(forces_, arm).publish(wrench(states.haptic, arm, stamp));
  planning_.publish(states.model, stamp);
  training_.publish(states.model, stamp);
  publishEdge(states);
  if (cycle_ % cyclesIn(kTransformPeriod, source_.period) == 0) {
    publishTransforms(states, stamp);
    publishMarkers(states, stamp);
  }
  ++cycle_;
}

void StateTopics::startOver() {
  planning_.startOver();
  training_.startOver();
  cycle_ = 0;
  has_published_edge_ = false;
}

void StateTopics::publishMarkers(const PublishedStates& states, const ros::Time& stamp) {
  if (!markers_.isHeard()) return;
  visualization_msgs::MarkerArray all = contactMarkers(states.contacts, stamp);
  const auto forces = forceMarkers(states.model, states.haptic, source_.raven.X_WB, stamp);
  all.markers.insert(all.markers.end(), forces.markers.begin(), forces.markers.end());
  markers_.publish(all);
}

void StateTopics::publishEdge(const PublishedStates& states) {
  const bool is_at_edge = isAtEdge(states.model, states.haptic);
  if (has_published_edge_ && is_at_edge == published_edge_) return;
  has_published_edge_ = true;
  published_edge_ = is_at_edge;
  std_msgs::Bool message;
  message.data = is_at_edge;
  edge_.publish(message);
}

void StateTopics::publishTransforms(const PublishedStates& states, const ros::Time& stamp) {
  tf2_msgs::TFMessage message;
  const ModelState& model = states.model;
  const RobotState& robot = states.robot;
  addArms("model/", {model.arms[0].q, model.arms[1].q}, stamp, &message.transforms);
  if (robot.frame > 0 && robot.connected != 0)
    addArms("robot/", {robot.arms[0].q, robot.arms[1].q}, stamp, &message.transforms);
  addCameras(model, stamp, &message.transforms);
  transforms_.publish(message);
}

/** The moving cameras of the live pictures, at their present places. */
void StateTopics::addCameras(const ModelState& model,
                             const ros::Time& stamp,
                             std::vector<geometry_msgs::TransformStamped>* transforms) {
  const RenderConfig& render = source_.render;
  for (const std::string& name : liveCameras(render)) {
    const CameraConfig& config = model::requireCamera(render.cameras, name);
    if (config.moves == CameraMoves::kNever) continue;
    const model::Camera camera = model::cameraAt(config, model, source_.raven.X_WB, 2, 2);
    transforms->push_back(transform(camera.X_WC, opticalFrame(name), stamp));
  }
}

void StateTopics::addArms(const std::string& prefix,
                          const PerArm<JointArray>& q,
                          const ros::Time& stamp,
                          std::vector<geometry_msgs::TransformStamped>* transforms) {
  source_.raven.linkPosesInWorld(q, &positions_, &poses_);
  const auto& links = source_.raven.description.links;
  for (std::size_t i = 0; i < links.size(); ++i)
    if (!is_fixed_[i]) transforms->push_back(transform(poses_[i], prefix + links[i].name, stamp));
}

}  // namespace raven2_trainer::ros_bridge
