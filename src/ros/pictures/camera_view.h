#pragma once

#include <ros/callback_queue.h>
#include <ros/node_handle.h>
#include <ros/publisher.h>
#include <ros/spinner.h>
#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>

#include <cstdint>

#include "raven2_trainer/loop/shared_state.h"
#include "raven2_trainer/render/render_config.h"
#include "ros/pictures/jpeg_encoder.h"

namespace raven2_trainer::ros_bridge {

/** Has it rows, and all their bytes? */
bool isWhole(const sensor_msgs::Image& picture) noexcept;

/**
 * `view/image_raw` and its JPEG under `view/image_raw/compressed`: the real camera's pictures as they come, once they
 * were asked for (ModelState::view); else, and while the real camera is silent, the virtual ones. A separate
 * thread receives the real camera all the time, so that it is ready when it is requested: its pictures are large.
 */
class CameraView {
 public:
  /** @param[in] shared must outlive this. @throw RenderException. */
  CameraView(const ros::NodeHandle& node, const RenderConfig& config, SharedState* shared);
  ~CameraView() { stop(); }
  CameraView(const CameraView&) = delete;
  CameraView& operator=(const CameraView&) = delete;

  /** Whether anybody looks at either. */
  bool isWatched() const { return isRawWatched() || isCompressedWatched(); }
  bool isRawWatched() const { return pictures_.getNumSubscribers() > 0; }
  bool isCompressedWatched() const { return compressed_.getNumSubscribers() > 0; }
  /** A virtual picture that was to be the view when its drawing began (LiveImage::is_view). Not sent if the view is the
   *  real camera's by now. Any thread. */
  void show(const sensor_msgs::Image& picture) const;
  void show(const sensor_msgs::CompressedImage& picture) const;

  /** Ends its thread. */
  void stop();

 private:
  bool isReal() const;
  void hear(const sensor_msgs::ImageConstPtr& picture);

  SharedState& shared_;
  std::int64_t stale_ns_;
  ros::CallbackQueue queue_;
  ros::NodeHandle node_;
  ros::AsyncSpinner spinner_;
  JpegEncoder encoder_;  // of real pictures, on the thread that hears them
  ros::Publisher pictures_, compressed_;
  ros::Subscriber real_;
};

}  // namespace raven2_trainer::ros_bridge
