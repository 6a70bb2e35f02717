#pragma once

#include <ros/time.h>
#include <tf2_msgs/TFMessage.h>

#include <set>
#include <string>
#include <vector>

#include "raven2_trainer/model/raven_model.h"
#include "raven2_trainer/render/render_config.h"

namespace raven2_trainer::ros_bridge {

/** By link index: whether no joint moves it against the world. */
std::vector<bool> fixedLinks(const model::Description& description);

/** Cameras whose frames are published: the live one, and both eyes. */
std::set<std::string> liveCameras(const RenderConfig& render);

/** The frames of /tf_static, which /tf does not have: the fixed links of model and robot, and the cameras
 * that stay where the configuration puts them. @throw ConfigException for a camera that is not configured. */
tf2_msgs::TFMessage fixedFrames(const model::RavenModel& raven, const RenderConfig& render, const ros::Time& stamp);

}  // namespace raven2_trainer::ros_bridge
