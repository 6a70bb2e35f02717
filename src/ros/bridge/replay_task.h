#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "ros/planning/planning_client.h"
#include "ros/raven/error_codes.h"

namespace raven2_trainer::ros_bridge {

/** Begins to show a recorded session: reads it, then asks the loop. Not from a real-time thread. */
class ReplayTask {
 public:
  /** Simulator::openReplay(). */
  using Open = std::function<std::uint32_t(const std::string&)>;

  struct Outcome {
    ErrorCode code{ErrorCode::kSuccess};
    std::string status;
  };

  /**
   * @param[in] client must outlive this.
   * @param[in] running directory of the running session: relative directories are searched next to it.
   */
  ReplayTask(PlanningClient* client, Open open, const std::string& running);

  /** @param[in] session its directory. @return whether it is shown, or why not. */
  Outcome begin(const std::string& session);

 private:
  PlanningClient& client_;
  const Open open_;
  const std::string sessions_;
};

}  // namespace raven2_trainer::ros_bridge
