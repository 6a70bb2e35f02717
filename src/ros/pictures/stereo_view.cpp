#include "ros/pictures/stereo_view.h"

#include "ros/bridge/messages.h"
#include "ros/node/topic.h"
#include "ros/pictures/compressed_picture.h"

namespace raven2_trainer::ros_bridge {
namespace {

constexpr std::array<const char*, 2> kSides{"left", "right"};

}  // namespace

StereoView::StereoView(const ros::NodeHandle& node, const RenderConfig& config)
    : config_(config.stereo), node_(node), encoder_(config.live_jpeg_quality) {
  for (std::size_t i = 0; i < kSides.size(); ++i) {
    const std::string topic = std::string("camera/") + kSides[i];
    images_[i] = node_.advertise<sensor_msgs::Image>(topic + "/image_raw", kPictureQueue);
    compressed_[i] = node_.advertise<sensor_msgs::CompressedImage>(topic + "/image_raw/compressed", kPictureQueue);
    infos_[i] = node_.advertise<sensor_msgs::CameraInfo>(topic + "/camera_info", kPictureQueue);
  }
}

bool StereoView::isWatched() const {
  for (std::size_t i = 0; i < kSides.size(); ++i) {
    for (const ros::Publisher* topic : {&images_[i], &compressed_[i], &infos_[i]})
      if (topic->getNumSubscribers() > 0) return true;
  }
  return false;
}

void StereoView::show(const daemon::LiveImage& picture, const ros::Time& stamp) {
  if (picture.eye == daemon::Eye::kMiddle) return;
  const bool is_right = picture.eye == daemon::Eye::kRight;
  const std::size_t side = is_right ? 1 : 0;
  const std::string frame = opticalFrame(config_.camera + "_left");
  if (images_[side].getNumSubscribers() > 0) images_[side].publish(image(picture, frame, stamp));
  sensor_msgs::CompressedImage jpeg;
  if (compressed_[side].getNumSubscribers() > 0 && compress(picture, frame, stamp, &encoder_, &jpeg))
    compressed_[side].publish(jpeg);
  infos_[side].publish(cameraInfo(picture.camera, frame, stamp, is_right ? config_.baseline : 0.0));
}

}  // namespace raven2_trainer::ros_bridge
