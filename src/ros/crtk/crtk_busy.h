#pragma once

#include <cstdint>

#include "raven2_trainer/core/types.h"

namespace raven2_trainer::ros_bridge {

/** Whether clients are told that arms are busy. A client waits until they are, and then until they are not. A thread that
 * comes late may find a move at its end already, so each move is shown for a while from when it was seen. One thread. */
class CrtkBusy {
 public:
  /** @param[in] moves Moves that began since the start. @param[in] tick Of the state; shown for kShown ticks from it. */
  bool of(bool is_busy, std::uint32_t moves, Tick tick) noexcept {
    if (has_seen_ && moves != moves_) until_ = tick + kShown;
    if (tick < until_ - kShown) until_ = tick;  // the loop began anew
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
