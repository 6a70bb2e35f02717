#pragma once

#include <ros/node_handle.h>
#include <ros/publisher.h>

#include <string>

#include "raven2_trainer/control/crtk_config.h"
#include "raven2_trainer/control/servo.h"
#include "ros/crtk/crtk_busy.h"
#include "ros/crtk/crtk_messages.h"

namespace raven2_trainer::ros_bridge {

/** A topic with an operating state: at each change and every CrtkConfig::state_period, latched. One thread. */
class CrtkStateTopic {
 public:
  CrtkStateTopic(ros::NodeHandle* node, const std::string& topic, const CrtkConfig& config);

  /** @param[in] moves ServoArmState::moves of the arms. @return whether the arms came to another state. */
  bool publish(const ServoState& servo, bool is_busy, std::uint32_t moves, const ros::Time& stamp);

 private:
  const double period_;  ///< [s]
  ros::Publisher publisher_;
  crtk::OperatingState published_;
  CrtkBusy busy_;
  bool has_published_{false};
  Tick last_tick_published_{};
};

}  // namespace raven2_trainer::ros_bridge
