#pragma once

#include <cstdint>

#include "raven2_trainer/core/state.h"
#include "raven2_trainer/core/state_cell.h"

namespace raven2_trainer::loop {

/**
 * The robot's state, and whether model and robot are linked: started from a common pose, with nothing between. A robot
 * hears no packets if the last sequence that it reports does not change. If it is not in PEDAL_DN then, it is sent
 * pedal-up until the surgeon's next pedal-down: a press that it did not hear does not engage it when it hears again.
 * One thread; real-time safe.
 */
class RobotTie {
 public:
  /** @param[in] stale_after [s] A state that is older moves and cues nothing. */
  explicit RobotTie(double stale_after) noexcept;

  /** Once a tick: its newest state. A robot that is lost is no longer linked. */
  void hear(const StateCell<RobotState>& newest, std::int64_t now_ns) noexcept;
  /** Once a tick, behind hear(): whether it hears us. */
  void listen() noexcept;
  /** A robot that went away, started again or is not homed is another robot: nothing known of the old one holds. */
  void forgetOld() noexcept;
  /** @return whether it is homed and disengaged, and was not before. */
  bool becomesReady() noexcept;

  const RobotState& state() const noexcept { return robot_; }
  /** [rad; m] */
  PerArm<JointArray> joints() const noexcept { return {robot_.arms[0].q, robot_.arms[1].q}; }

  /** It is connected and has said something. */
  bool isHeard() const noexcept { return robot_.connected != 0 && robot_.frame > 0; }
  /** There was one once: it hears from us every tick from then on. */
  bool wasHeard() const noexcept { return was_heard_; }
  bool isFresh() const noexcept { return is_fresh_; }
  /** It was homed when we met it. */
  bool isReady() const noexcept { return is_ready_; }
  bool isThere() const noexcept { return is_fresh_ && is_ready_; }
  bool isNotReady() const noexcept { return is_fresh_ && !is_ready_; }
  /** It searches its stops, or will. */
  bool isUnhomed() const noexcept { return is_fresh_ && robot_.homed == 0; }
  bool isLost() const noexcept { return !isHeard() || is_silent_; }
  bool isStopped() const noexcept { return robot_.runlevel == RunLevel::kEStop; }

  /** It was ready and heard in the tick before; remembers how it is now. */
  bool wasThere() const noexcept { return was_there_; }
  void remember() noexcept { was_there_ = is_ready_ && !isLost(); }

  // ---- the link
  /** Pedal-down: from now on both move from a common pose, or the model alone. */
  void link(bool is_common) noexcept;
  void unlink() noexcept { is_linked_ = false; }
  bool isLinked() const noexcept { return is_linked_; }
  /** It was deaf to the pedal-down. */
  bool isUnheard() const noexcept { return is_unheard_; }
  /** It is sent what moves the model. */
  bool isLed() const noexcept { return is_linked_ && !is_unheard_; }
  /** Both sides must apply the same increments: the robot does so from the cycle in which it reports PEDAL_DN. */
  bool applies() const noexcept;
  /** An execution pauses until the robot takes increments, and while it is not heard. */
  bool mayMoveOn() const noexcept { return !is_linked_ || (applies() && is_fresh_); }

 private:
  bool isDeaf() const noexcept;
  bool heardSinceLink() const noexcept { return heard_cycle_ > linked_cycle_; }

  std::int64_t stale_ns_;
  RobotState robot_{};
  bool is_fresh_{false};
  bool is_silent_{true};  ///< its newest state is so old that model and robot must start again from a common pose
  bool was_heard_{false};
  bool is_ready_{false};
  bool was_there_{false};
  bool is_linked_{false};
  bool is_unheard_{false};
  bool reports_sequence_{false};     ///< the last sequence that this robot reports has changed once: some report none
  std::uint32_t heard_sequence_{0};  ///< the newest that it reported
  std::uint64_t heard_cycle_{0};     ///< its cycle in which it did first
  std::uint64_t last_cycle_{0};
  std::uint64_t linked_cycle_{0};  ///< heard_cycle_ at the pedal-down
};

}  // namespace raven2_trainer::loop
