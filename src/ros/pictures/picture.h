#pragma once

#include <sensor_msgs/Image.h>

#include "raven2_trainer/ros/picture_listener.h"

namespace raven2_trainer::ros_bridge {

/** rgb8, bgr8, rgba8, bgra8 and mono8 as RGB. @return false, `*picture` unchanged, for other encodings, and for
 * messages of which bytes are missing. */
bool toPicture(const sensor_msgs::Image& message, Picture* picture);

}  // namespace raven2_trainer::ros_bridge
