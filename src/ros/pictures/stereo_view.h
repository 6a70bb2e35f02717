#pragma once

#include <ros/node_handle.h>
#include <ros/publisher.h>

#include <array>

#include "raven2_trainer/daemon/render_loop.h"
#include "raven2_trainer/render/render_config.h"
#include "ros/pictures/jpeg_encoder.h"

namespace raven2_trainer::ros_bridge {

/** `camera/left` and `camera/right`, each with `image_raw`, its JPEG under `image_raw/compressed`, and `camera_info`,
 * as stereo_image_proc takes them. */
class StereoView {
 public:
  /** @throw RenderException. */
  StereoView(const ros::NodeHandle& node, const RenderConfig& config);

  /** Whether anybody looks at either: else there is no need to draw them. */
  bool isWatched() const;
  /** A picture of the left or the right eye. One thread. */
  void show(const daemon::LiveImage& picture, const ros::Time& stamp);

 private:
  StereoConfig config_;
  ros::NodeHandle node_;
  JpegEncoder encoder_;
  std::array<ros::Publisher, 2> images_, compressed_, infos_;  // left, right
};

}  // namespace raven2_trainer::ros_bridge
