#pragma once

#include <functional>
#include <string>

#include "raven2_trainer/config/trainer_config.h"
#include "raven2_trainer/session/session_directory.h"

namespace raven2_trainer::apps {

/** Number of messages and topics in a bag. */
struct BagCounts {
  std::uint64_t messages{};
  std::size_t topics{};
};

/**
 * Writes a session from the first pedal-down as a ROS bag, in order of time, stamped by the wall clock. It has the daemon's
 * topics of states, made by the code of the live topics, /session/configuration, /console/pedal, the tips
 * (/model/ARM/measured_cp), and /faults.
 * @param[in] config apps::viewingConfig() of the session.
 * @throw SessionException if the session is empty or the bag cannot be written.
 */
BagCounts writeSessionBag(const TrainerConfig& config,
                          const session::SessionPaths& paths,
                          const std::string& bag,
                          const std::function<void(double)>& progress);

}  // namespace raven2_trainer::apps
