#pragma once

#include <cstdint>
#include <string>

#include "raven2_trainer/core/command.h"
#include "ros/planning/planning_client.h"
#include "ros/raven/error_codes.h"

namespace raven2_trainer::ros_bridge {

/**
 * Planning and executing as one order: asks for the plan, has it executed when it is there, and says how it ended.
 * Knows no ROS. Moved on by look(); one thread.
 */
class MoveArmTask {
 public:
  /** @param[in] client must outlive this. */
  explicit MoveArmTask(PlanningClient* client) : client_(*client) {}

  struct Outcome {
    ErrorCode code{ErrorCode::kFailure};
    std::string status;      ///< in a word
    bool was_cancelled{};    ///< by cancel()
    PlanResult plan{};       ///< id 0: no plan
    ExecutionReport report;  ///< id 0: nothing was executed
  };

  /** Asks for the plan. Waits for the loop's answer, at most half a second. @param[in] request from planRequest(). */
  void begin(const Request& request, bool on_robot);

  /** Gives up what is under way, unless another order has taken its place. Waits until that is done. */
  void cancel();

  /** One look at what became of it; to be called again and again. @return true once it is over, then outcome() holds.
   */
  bool look();

  bool isOver() const { return phase_ == Phase::kOver; }
  const Outcome& outcome() const { return outcome_; }

 private:
  enum class Phase { kOver, kPlanning, kExecuting };

  void lookForPlan();
  void lookForReport();
  void execute();
  void end(ErrorCode code, const std::string& status);

  PlanningClient& client_;
  Phase phase_{Phase::kOver};
  bool on_robot_{};
  std::uint32_t plan_{}, execution_{};  ///< ids
  Outcome outcome_;
};

}  // namespace raven2_trainer::ros_bridge
