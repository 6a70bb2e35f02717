#include "ros/pictures/other_views.h"

#include <utility>

#include "ros/bridge/messages.h"
#include "ros/node/topic.h"
#include "ros/pictures/compressed_picture.h"

namespace raven2_trainer::ros_bridge {

OtherViews::View::View(ros::NodeHandle* node, const std::string& name, std::string optical_frame, double to_the_right)
    : frame(std::move(optical_frame)),
      aside(to_the_right),
      images(node->advertise<sensor_msgs::Image>(name + "/image_raw", kPictureQueue)),
      compressed(node->advertise<sensor_msgs::CompressedImage>(name + "/image_raw/compressed", kPictureQueue)),
      infos(node->advertise<sensor_msgs::CameraInfo>(name + "/camera_info", kPictureQueue)) {}

bool OtherViews::View::isWatched() const {
  return images.getNumSubscribers() > 0 || compressed.getNumSubscribers() > 0 || infos.getNumSubscribers() > 0;
}

/** Both eyes are in the left one's frame (REP 104). */
OtherViews::OtherViews(const ros::NodeHandle& node, const RenderConfig& config)
    : node_(node),
      encoder_(config.live_jpeg_quality),
      left_(&node_, "camera/left", opticalFrame(config.stereo.camera + "_left"), 0.0),
      right_(&node_, "camera/right", left_.frame, config.stereo.baseline),
      second_(&node_, "camera/second", opticalFrame(config.live_second), 0.0) {}

WatchedPictures OtherViews::watched() const {
  WatchedPictures watched;
  watched.stereo = left_.isWatched() || right_.isWatched() ? 1 : 0;
  watched.second = second_.isWatched() ? 1 : 0;
  return watched;
}

void OtherViews::show(const daemon::LiveImage& picture, const ros::Time& stamp) {
  const bool is_left = picture.viewpoint == daemon::Viewpoint::kLeftEye;
  const View& view = picture.viewpoint == daemon::Viewpoint::kSecond ? second_ : is_left ? left_ : right_;
  if (view.images.getNumSubscribers() > 0) view.images.publish(image(picture, view.frame, stamp));
  sensor_msgs::CompressedImage jpeg;
  if (view.compressed.getNumSubscribers() > 0 && compress(picture, view.frame, stamp, &encoder_, &jpeg))
    view.compressed.publish(jpeg);
  view.infos.publish(cameraInfo(picture.camera, view.frame, stamp, view.aside));
}

}  // namespace raven2_trainer::ros_bridge
