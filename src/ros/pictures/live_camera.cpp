#include "ros/pictures/live_camera.h"

#include "ros/bridge/messages.h"
#include "ros/node/topic.h"
#include "ros/pictures/compressed_picture.h"

namespace raven2_trainer::ros_bridge {
LiveCamera::LiveCamera(ros::NodeHandle* node, const RenderConfig& config, const CameraView& view)
    : frame_(opticalFrame(config.live_camera)),
      view_(view),
      encoder_(config.live_jpeg_quality),
      images_(node->advertise<sensor_msgs::Image>("camera/image_raw", kPictureQueue)),
      infos_(node->advertise<sensor_msgs::CameraInfo>("camera/camera_info", kPictureQueue)),
      compressed_(node->advertise<sensor_msgs::CompressedImage>("camera/image_raw/compressed", kPictureQueue)) {}

bool LiveCamera::isWatched() const {
  return images_.getNumSubscribers() > 0 || infos_.getNumSubscribers() > 0 || compressed_.getNumSubscribers() > 0;
}

void LiveCamera::show(const daemon::LiveImage& picture, const ros::Time& stamp) {
  if (images_.getNumSubscribers() > 0 || (picture.is_view && view_.isRawWatched())) {
    const sensor_msgs::Image message = image(picture, frame_, stamp);
    images_.publish(message);
    if (picture.is_view) view_.show(message);
  }
  if (compressed_.getNumSubscribers() > 0 || (picture.is_view && view_.isCompressedWatched())) {
    sensor_msgs::CompressedImage message;
    const bool is_good = compress(picture, frame_, stamp, &encoder_, &message);
    if (is_good) compressed_.publish(message);
    if (is_good && picture.is_view) view_.show(message);
  }
  infos_.publish(cameraInfo(picture.camera, frame_, stamp));
}

}  // namespace raven2_trainer::ros_bridge
