#pragma once

#include <ros/callback_queue.h>
#include <ros/node_handle.h>
#include <ros/publisher.h>
#include <ros/spinner.h>
#include <sensor_msgs/Image.h>

#include <cstdint>

#include "raven2_trainer/core/config.h"
#include "raven2_trainer/core/shared_state.h"

namespace raven2_trainer::ros_bridge {

/** Has it rows, and all their bytes? */
bool isWhole(const sensor_msgs::Image& picture) noexcept;

/**
 * `view/image_raw`: the real camera's pictures as they come, once they were asked for (ModelState::view); else, and
 * while the real camera is silent, the virtual ones. The real camera is heard all the time, so that it is there when it
 * is asked for, on a thread of its own: its pictures are large.
 */
class CameraView {
 public:
  /** @param[in] shared must outlive this. */
  CameraView(const ros::NodeHandle& node, const RenderConfig& config, SharedState* shared);
  ~CameraView() { stop(); }
  CameraView(const CameraView&) = delete;
  CameraView& operator=(const CameraView&) = delete;

  /** Whether anybody looks. */
  bool isWatched() const { return pictures_.getNumSubscribers() > 0; }
  /** A virtual picture that was to be the view when its drawing began (LiveImage::is_view). Not sent if the view is the
   *  real camera's by now. Any thread. */
  void show(const sensor_msgs::Image& picture) const;

  /** Ends its thread. */
  void stop();

 private:
  void hear(const sensor_msgs::ImageConstPtr& picture);

  SharedState& shared_;
  std::int64_t stale_ns_;
  ros::CallbackQueue queue_;
  ros::NodeHandle node_;
  ros::AsyncSpinner spinner_;
  ros::Publisher pictures_;
  ros::Subscriber real_;
};

}  // namespace raven2_trainer::ros_bridge
