#pragma once

#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>

#include <string>

#include "raven2_trainer/daemon/render_loop.h"
#include "ros/pictures/jpeg_encoder.h"

// Pictures for the topics BASE/compressed, as compressed_image_transport names and fills them.

namespace raven2_trainer::ros_bridge {

/** A live picture. @return false if it cannot be encoded. */
bool compress(const daemon::LiveImage& picture,
              const std::string& frame,
              const ros::Time& stamp,
              JpegEncoder* encoder,
              sensor_msgs::CompressedImage* message);

/** Another's picture, of an encoding that toPicture() knows, with its own header. @return false for any other. */
bool compress(const sensor_msgs::Image& picture, JpegEncoder* encoder, sensor_msgs::CompressedImage* message);

}  // namespace raven2_trainer::ros_bridge
