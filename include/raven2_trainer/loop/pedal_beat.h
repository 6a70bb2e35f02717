#pragma once

#include <cstdint>
#include <optional>

#include "raven2_trainer/core/pedals.h"

namespace raven2_trainer::loop {

/**
 * Decides when a console sends the pedals that ITP does not carry: at each change and, because packets get lost, every
 * 10 ms. Nothing is sent before the first press. No I/O; real-time safe.
 */
class PedalBeat {
 public:
  static constexpr int kPeriod = 10;  ///< [ticks] a twentieth of master_timeout, which releases the camera pedal

  /** Call once a millisecond. @return the packet to send now, if any. */
  std::optional<PedalState> tick(std::uint32_t held) noexcept {
    const bool is_change = held != sent_.held;
    if (sent_.sequence == 0 && !is_change) return std::nullopt;
    if (!is_change && ++since_ < kPeriod) return std::nullopt;
    since_ = 0;
    sent_ = {sent_.sequence + 1, held};
    return sent_;
  }

 private:
  PedalState sent_{};
  int since_{0};  ///< [ticks]
};

}  // namespace raven2_trainer::loop
