#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "raven2_trainer/core/command.h"
#include "raven2_trainer/core/pedals.h"
#include "raven2_trainer/core/state.h"
#include "raven2_trainer/wire/newest_only.h"

namespace raven2_trainer::loop {

/** Most requests that one packet of pedals can make: each of them, and the camera's release. */
constexpr std::size_t kMaxPedalRequests = kPedalCount;

/** In the order in which they are meant. */
struct PedalRequests {
  std::array<Request, kMaxPedalRequests> items{};
  std::size_t count{};
};

/**
 * Turns the pedals other than the engaging one into requests: a press asks, and so does the
 * release of the camera's pedal, which alone is held. The meaning of a press depends on the state: planning's begins it
 * and records the goal at the next press, simulation's and the trial's begin and end. The stop comes first; it is
 * cleared by a request, never by a pedal. Packets may be lost or doubled, and come late: each has all held pedals.
 * Pure; real-time safe.
 */
class PedalGate {
 public:
  /** @param[in] timeout [s] of silence after which the camera's counts as up. */
  explicit PedalGate(double timeout) noexcept : timeout_ns_(static_cast<std::int64_t>(timeout * 1e9)) {}

  /** Whether a packet with this number is to be taken: kNone, or why it came too late. */
  Reject check(std::uint32_t sequence, std::int64_t now_ns) const noexcept;

  /** A packet of the master's; one that check() refuses changes nothing. @param[in] mode, view of the newest state. */
  PedalRequests take(const PedalState& pedals, std::int64_t now_ns, Mode mode, std::uint8_t view) noexcept;

  /** At least every 100 ms: silence lets go of the camera. */
  PedalRequests idle(std::int64_t now_ns) noexcept;

  /** Bits by Pedal. */
  std::uint32_t held() const noexcept { return held_; }

 private:
  void beginAgain(std::uint32_t sequence) noexcept;
  PedalRequests change(std::uint32_t held, Mode mode, std::uint8_t view) noexcept;
  bool isHeard(std::int64_t now_ns) const noexcept { return is_heard_ && now_ns - heard_ns_ <= timeout_ns_; }

  std::int64_t timeout_ns_;
  std::int64_t heard_ns_{0};
  wire::NewestOnly order_;
  std::uint32_t held_{0};
  bool is_heard_{false};
};

}  // namespace raven2_trainer::loop
