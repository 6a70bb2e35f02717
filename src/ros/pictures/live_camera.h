#pragma once

#include <ros/node_handle.h>
#include <ros/publisher.h>

#include <string>

#include "raven2_trainer/daemon/render_loop.h"
#include "raven2_trainer/render/render_config.h"
#include "ros/pictures/camera_view.h"
#include "ros/pictures/jpeg_encoder.h"

namespace raven2_trainer::ros_bridge {

/**
 * The virtual camera's topics: camera/image_raw, camera/camera_info, and camera/image_raw/compressed as
 * compressed_image_transport names and fills it, so that image_transport's clients find it. The costly parts (a copy of
 * the pixels, JPEG) are done only while there is a subscriber, and once for camera and view together.
 */
class LiveCamera {
 public:
  /** @param[in] view that is shown the same pictures; must outlive this. @throw RenderException. */
  LiveCamera(ros::NodeHandle* node, const RenderConfig& config, const CameraView& view);

  /** Whether anybody looks, or asks where the camera is. */
  bool isWatched() const;
  /** A picture of the live camera. On the render thread; roscpp's publish is thread-safe. */
  void show(const daemon::LiveImage& picture, const ros::Time& stamp);

 private:
  const std::string frame_;
  const CameraView& view_;
  JpegEncoder encoder_;
  ros::Publisher images_, infos_, compressed_;
};

}  // namespace raven2_trainer::ros_bridge
