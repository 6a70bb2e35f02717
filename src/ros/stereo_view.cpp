#include "ros/stereo_view.h"

#include "ros/messages.h"

namespace raven2_trainer::ros_bridge {
namespace {

constexpr std::uint32_t kQueue = 2;
constexpr std::array<const char*, 2> kSides{"left", "right"};

}  // namespace

StereoView::StereoView(const ros::NodeHandle& node, const StereoConfig& config) : config_(config), node_(node) {
  for (std::size_t i = 0; i < kSides.size(); ++i) {
    const std::string topic = std::string("camera/") + kSides[i];
    images_[i] = node_.advertise<sensor_msgs::Image>(topic + "/image_raw", kQueue);
    infos_[i] = node_.advertise<sensor_msgs::CameraInfo>(topic + "/camera_info", kQueue);
  }
}

bool StereoView::isWatched() const {
  for (std::size_t i = 0; i < kSides.size(); ++i) {
    if (images_[i].getNumSubscribers() > 0 || infos_[i].getNumSubscribers() > 0) return true;
  }
  return false;
}

void StereoView::show(const runtime::LiveImage& picture, const ros::Time& stamp) const {
  if (picture.eye == runtime::Eye::kMiddle) return;
  const bool is_right = picture.eye == runtime::Eye::kRight;
  const std::string frame = opticalFrame(config_.camera + "_left");
  images_[is_right ? 1 : 0].publish(image(picture, frame, stamp));
  infos_[is_right ? 1 : 0].publish(cameraInfo(picture.camera, frame, stamp, is_right ? config_.baseline : 0.0));
}

}  // namespace raven2_trainer::ros_bridge
