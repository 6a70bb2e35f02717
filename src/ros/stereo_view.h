#pragma once

#include <ros/node_handle.h>
#include <ros/publisher.h>

#include <array>

#include "raven2_trainer/core/config.h"
#include "raven2_trainer/runtime/render_loop.h"

namespace raven2_trainer::ros_bridge {

/** `camera/left` and `camera/right`, each with `image_raw` and `camera_info`, as stereo_image_proc takes them. */
class StereoView {
 public:
  StereoView(const ros::NodeHandle& node, const StereoConfig& config);

  /** Whether anybody looks at either: else there is no need to draw them. */
  bool isWatched() const;
  /** A picture of the left or the right eye. */
  void show(const runtime::LiveImage& picture, const ros::Time& stamp) const;

 private:
  StereoConfig config_;
  ros::NodeHandle node_;
  std::array<ros::Publisher, 2> images_, infos_;  // left, right
};

}  // namespace raven2_trainer::ros_bridge
