#include "ros/bridge/fixed_frames.h"

#include "raven2_trainer/model/camera.h"
#include "ros/bridge/messages.h"

namespace raven2_trainer::ros_bridge {

std::vector<bool> fixedLinks(const model::Description& description) {
  std::vector<bool> fixed;
  for (const model::Link& link : description.links) {  // parents come before children
    const bool is_held = link.parent < 0 || fixed[static_cast<std::size_t>(link.parent)];
    fixed.push_back(is_held && link.joint == model::JointKind::kFixed);
  }
  return fixed;
}

std::set<std::string> liveCameras(const RenderConfig& render) {
  return {render.live_camera, render.live_second, render.stereo.camera + "_left", render.stereo.camera + "_right"};
}

tf2_msgs::TFMessage fixedFrames(const model::RavenModel& raven, const RenderConfig& render, const ros::Time& stamp) {
  tf2_msgs::TFMessage message;
  const auto& links = raven.description.links;
  const std::vector<bool> fixed = fixedLinks(raven.description);
  std::vector<double> positions(links.size());
  std::vector<Pose> poses(links.size());
  raven.linkPosesInWorld({}, &positions, &poses);  // of any joints: none of them matters here
  for (const char* prefix : {"model/", "robot/"}) {
    for (std::size_t i = 0; i < links.size(); ++i)
      if (fixed[i]) message.transforms.push_back(transform(poses[i], prefix + links[i].name, stamp));
  }
  for (const std::string& name : liveCameras(render)) {
    const CameraConfig& config = model::requireCamera(render.cameras, name);
    if (config.moves != CameraMoves::kNever) continue;
    message.transforms.push_back(transform(model::makeCamera(config, 2, 2).X_WC, opticalFrame(name), stamp));
  }
  return message;
}

}  // namespace raven2_trainer::ros_bridge
