#include "ros/pictures/compressed_picture.h"

#include "ros/bridge/messages.h"
#include "ros/pictures/picture.h"

namespace raven2_trainer::ros_bridge {

bool compress(const daemon::LiveImage& picture,
              const std::string& frame,
              const ros::Time& stamp,
              JpegEncoder* encoder,
              sensor_msgs::CompressedImage* message) {
  *message = compressedImage(frame, stamp);
  return encoder->encode(picture.rgb, picture.camera.width, picture.camera.height, &message->data);
}

bool compress(const sensor_msgs::Image& picture, JpegEncoder* encoder, sensor_msgs::CompressedImage* message) {
  Picture colours;
  if (!toPicture(picture, &colours)) return false;
  *message = compressedImage(picture.header.frame_id, picture.header.stamp);
  return encoder->encode(colours.rgb, colours.width, colours.height, &message->data);
}

}  // namespace raven2_trainer::ros_bridge
