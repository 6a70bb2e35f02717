#pragma once

#include <cstdint>
#include <optional>

#include "raven2_trainer/core/pedals.h"

namespace raven2_trainer::loop {

/**
 * When a console sends the pedals that ITP does not carry: at each change and every 10 ms, because packets
 * get lost; nothing before the first of them is pressed. Pure; real-time safe.
 */
class PedalBeat {
 public:
  static constexpr int kPeriod = 10;  ///< [ticks] a twentieth of network.yaml's master_timeout, which lets go

  /** Once a millisecond. @return what is to be sent now. */
  std::optional<PedalState> tick(std::uint32_t held) noexcept {
    const bool is_change = held != told_.held;
    if (told_.sequence == 0 && !is_change) return std::nullopt;
    if (!is_change && ++since_ < kPeriod) return std::nullopt;
    since_ = 0;
    told_ = {told_.sequence + 1, held};
    return told_;
  }

 private:
  PedalState told_{};
  int since_{0};  ///< [ticks]
};

}  // namespace raven2_trainer::loop
