#pragma once

#include <cstdint>

#include "raven2_trainer/core/types.h"

namespace raven2_trainer::ros_bridge {

/** Shows an arm as busy. A client waits until it is busy, and then until it is not. A thread that comes late may find a
 * move at its end already, so each move is shown for a while from then on. One thread. */
class CrtkBusy {
 public:
  /** @param[in] moves Moves that began since the start. @param[in] tick Of the state; shown for kShown ticks from it.
   */
  bool of(bool is_busy, std::uint32_t moves, Tick tick) noexcept {
    if (has_seen_ && moves != moves_) until_ = tick + kShown;
    if (tick < until_ - kShown) until_ = tick;  // the loop started again
    moves_ = moves;
    has_seen_ = true;
    return is_busy || tick < until_;
  }

 private:
  static constexpr Tick kShown = 50;  ///< several looks of a client that asks a hundred times a second; ours
  std::uint32_t moves_{};
  Tick until_{};
  bool has_seen_{false};
};

}  // namespace raven2_trainer::ros_bridge
