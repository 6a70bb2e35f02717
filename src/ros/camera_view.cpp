#include "ros/camera_view.h"

#include <cstdio>

#include "raven2_trainer/net/clock.h"

namespace raven2_trainer::ros_bridge {
namespace {

constexpr std::uint32_t kQueue = 2;

}  // namespace

bool isWhole(const sensor_msgs::Image& picture) noexcept {
  return picture.width > 0 && picture.height > 0 && picture.step >= picture.width &&
         picture.data.size() == static_cast<std::size_t>(picture.step) * picture.height;
}

CameraView::CameraView(const ros::NodeHandle& node, const RenderConfig& config, SharedState* shared)
    : shared_(*shared), node_(node), spinner_(1, &queue_) {
  node_.setCallbackQueue(&queue_);
  pictures_ = node_.advertise<sensor_msgs::Image>("view/image_raw", kQueue);
  if (config.real_camera_topic.empty()) return;
  if (node_.resolveName(config.real_camera_topic) == pictures_.getTopic()) {  // by a remapping
    std::fprintf(stderr, "real camera: %s is the view itself; not listened to\n", pictures_.getTopic().c_str());
    return;
  }
  real_ = node_.subscribe(config.real_camera_topic, 1, &CameraView::hear, this);
  spinner_.start();
}

void CameraView::stop() {
  real_.shutdown();
  spinner_.stop();
}

/** Told first, so that of the virtual pictures at most the one that is being drawn comes behind the first real one. */
void CameraView::hear(const sensor_msgs::ImageConstPtr& picture) {
  if (!isWhole(*picture)) return;
  shared_.real_picture_ns.store(net::monotonicNow());
  if (shared_.model.load().view != 0) pictures_.publish(picture);
}

}  // namespace raven2_trainer::ros_bridge
