#pragma once

#include <functional>
#include <string>

#include "raven2_trainer/config/trainer_config.h"
#include "raven2_trainer/session/session_directory.h"

namespace raven2_trainer::apps {

/** What was written. */
struct BagCounts {
  std::uint64_t messages{};
  std::size_t topics{};
};

/**
 * Writes a session from the first pedal down as a ROS bag: the daemon's topics of states, each message made by the code
 * that makes it live (ros_bridge::SessionTeller), and besides /session/configuration, /console/pedal, the tips
 * (/model/ARM/measured_cp) and the /faults as they begin and end. In order of time, stamped by the wall clock.
 * @param[in] config apps::viewingConfig() of the session.
 * @throw SessionException if there is nothing to write, or the bag cannot be written.
 */
BagCounts writeSessionBag(const TrainerConfig& config,
                          const session::SessionPaths& paths,
                          const std::string& bag,
                          const std::function<void(double)>& progress);

}  // namespace raven2_trainer::apps
