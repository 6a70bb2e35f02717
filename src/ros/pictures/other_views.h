#pragma once

#include <ros/node_handle.h>
#include <ros/publisher.h>

#include <string>

#include "raven2_trainer/daemon/render_loop.h"
#include "raven2_trainer/render/render_config.h"
#include "ros/pictures/jpeg_encoder.h"

namespace raven2_trainer::ros_bridge {

/** `camera/left` and `camera/right`, as stereo_image_proc takes them, and `camera/second`. Each has `image_raw`, its
 * JPEG under `image_raw/compressed`, and `camera_info`. */
class OtherViews {
 public:
  /** @throw RenderException. */
  OtherViews(const ros::NodeHandle& node, const RenderConfig& config);

  /** Pictures without clients need not be drawn. */
  WatchedPictures watched() const;
  /** A picture of any of them; not of the live camera. One thread. */
  void show(const daemon::LiveImage& picture, const ros::Time& stamp);

 private:
  struct View {
    View(ros::NodeHandle* node, const std::string& name, std::string optical_frame, double to_the_right);
    bool isWatched() const;
    std::string frame;
    double aside;  // [m] from the origin of its frame
    ros::Publisher images, compressed, infos;
  };

  ros::NodeHandle node_;
  JpegEncoder encoder_;
  View left_, right_, second_;
};

}  // namespace raven2_trainer::ros_bridge
