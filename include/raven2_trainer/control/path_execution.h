#pragma once

#include "raven2_trainer/control/arm_controller.h"
#include "raven2_trainer/control/execution_config.h"
#include "raven2_trainer/core/command.h"

namespace raven2_trainer::control {

/**
 * A plan's path in time, as it is executed: from the arm's place to the path's start in `hold_time`, then the path
 * at `speed` times its own, then its last waypoint. Time goes on only in the ticks in which the arm may move. So the
 * execution waits for a robot that is not ready yet, or not heard. Then it comes up to speed again in 0.1 s, since the
 * path may have to go on where it was fast. Pure; real-time safe.
 */
class PathExecution {
 public:
  explicit PathExecution(const ExecutionConfig& config) noexcept : config_(config) {}

  /** @param[in] plan one that succeeded. @param[in] from [rad; m] joints of the arm. */
  void start(const PlanResult& plan, const JointArray& from) noexcept;

  /** Where the arm shall be in this tick, and how fast it shall move there; at rest where it was if it may not move. */
  const JointTarget& tick(bool may_move) noexcept;
  /** [rad; m] */
  const JointArray& desired() const noexcept { return target_.q; }

  /** The last waypoint is what is desired. */
  bool isOver() const noexcept { return pathTime() >= duration(); }
  /** [-] 0 to 1: share of the path's time that is gone. */
  double progress() const noexcept;
  /** [s] since the arm last might move. */
  double waited() const noexcept { return static_cast<double>(waiting_) * kTickSeconds; }
  /** [s] since the path was over, with the arm free to move. */
  double rested() const noexcept { return static_cast<double>(resting_) * kTickSeconds; }
  /** [s] that the path takes at full speed. */
  double duration() const noexcept;
  /** [rad; m] where the path ends. */
  const JointArray& goal() const noexcept {
    return plan_.waypoints[plan_.waypoint_count > 0 ? plan_.waypoint_count - 1 : 0];
  }

 private:
  JointArray joints() noexcept;
  static constexpr std::int64_t kFullRate = 100;  ///< [1/100 of the path's own], and the ticks that it takes
  double held() const noexcept { return static_cast<double>(elapsed_) / kFullRate * kTickSeconds; }
  double pathTime() const noexcept { return (held() - config_.hold_time) * config_.speed; }

  ExecutionConfig config_;
  PlanResult plan_{};
  JointArray offset_{};  ///< of the arm from the path's start
  JointTarget target_{};
  std::int64_t elapsed_{0};                                 ///< [1/100 ticks] of the path's time
  std::int64_t rate_{kFullRate}, waiting_{0}, resting_{0};  ///< [1/100]; [ticks]
  std::uint32_t segment_{0};
};

}  // namespace raven2_trainer::control
