#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "raven2_trainer/core/command.h"
#include "raven2_trainer/core/pedals.h"
#include "raven2_trainer/core/state.h"
#include "raven2_trainer/wire/newest_only.h"

namespace raven2_trainer::loop {

/** Most requests from one pedal packet: each pedal, or the camera's release. */
constexpr std::size_t kMaxPedalRequests = kPedalCount;

/** Requests, in the order of execution. */
struct PedalRequests {
  std::array<Request, kMaxPedalRequests> items{};
  std::size_t count{};
};

/**
 * Converts pedals other than the engaging one to requests: a press makes one, and so does the release of the camera
 * pedal. The meaning of a press depends on the mode. The planning pedal begins planning and then records the goal; the
 * simulation and trial pedals begin and end. The stop comes first; only a request clears it, never a pedal. Packets may
 * be lost, doubled or late: each contains all held pedals. No I/O; real-time safe.
 */
class PedalGate {
 public:
  /** @param[in] timeout [s] of silence after which the camera pedal counts as up. */
  explicit PedalGate(double timeout) noexcept : timeout_ns_(static_cast<std::int64_t>(timeout * 1e9)) {}

  /** @return kNone if a packet with this number is valid, else why it is too late. */
  Reject check(std::uint32_t sequence, std::int64_t now_ns) const noexcept;

  /** A packet of the master; one that check() rejects changes nothing. @param[in] mode, view of the newest state. */
  PedalRequests take(const PedalState& pedals, std::int64_t now_ns, Mode mode, std::uint8_t view) noexcept;

  /** Call at least every 100 ms: silence releases the camera pedal. */
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
