#include "ros/pictures/camera_view.h"

#include <cstdio>

#include "raven2_trainer/net/clock.h"
#include "ros/node/topic.h"
#include "ros/pictures/compressed_picture.h"

namespace raven2_trainer::ros_bridge {
bool isWhole(const sensor_msgs::Image& picture) noexcept {
  return picture.width > 0 && picture.height > 0 && picture.step >= picture.width &&
         picture.data.size() == static_cast<std::size_t>(picture.step) * picture.height;
}

CameraView::CameraView(const ros::NodeHandle& node, const RenderConfig& config, SharedState* shared)
    : shared_(*shared),
      stale_ns_(static_cast<std::int64_t>(config.real_stale_after * 1e9)),
      node_(node),
      spinner_(1, &queue_),
      encoder_(config.live_jpeg_quality) {
  node_.setCallbackQueue(&queue_);
  pictures_ = node_.advertise<sensor_msgs::Image>("view/image_raw", kPictureQueue);
  compressed_ = node_.advertise<sensor_msgs::CompressedImage>("view/image_raw/compressed", kPictureQueue);
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

/** Whether the view is the real camera's, which is heard. */
bool CameraView::isReal() const {
  const bool is_fresh = net::monotonicNow() - shared_.real_picture_ns.load() <= stale_ns_;
  return is_fresh && shared_.model.load().view != 0;
}

void CameraView::show(const sensor_msgs::Image& picture) const {
  if (!isReal()) pictures_.publish(picture);
}

void CameraView::show(const sensor_msgs::CompressedImage& picture) const {
  if (!isReal()) compressed_.publish(picture);
}

/** Notes its time first: no virtual picture is sent from then on. */
void CameraView::hear(const sensor_msgs::ImageConstPtr& picture) {
  if (!isWhole(*picture)) return;
  shared_.real_picture_ns.store(net::monotonicNow());
  if (shared_.model.load().view == 0) return;
  pictures_.publish(picture);
  sensor_msgs::CompressedImage jpeg;
  if (isCompressedWatched() && compress(*picture, &encoder_, &jpeg)) compressed_.publish(jpeg);
}

}  // namespace raven2_trainer::ros_bridge
