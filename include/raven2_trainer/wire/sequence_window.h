#pragma once

#include <cstdint>

#include "raven2_trainer/core/counters.h"

namespace raven2_trainer::wire {

/**
 * Order rule of the daemon's own ingest, behaviour "hardened" (decisions page). Packets apply in order only. A late
 * or repeated one is dropped, because ITP carries increments. A number up to 64 ahead is accepted, and the gap counted.
 * A jump beyond it is rejected and does not move the window, so one forged packet costs one packet. Ten consecutive
 * in-order packets of a new numbering, all with the pedal up, re-base it. Serial arithmetic on 32 bits.
 */
class SequenceWindow {
 public:
  static constexpr std::uint32_t kWindow = 64;
  static constexpr int kRebaseAfter = 10;

  /** kNone (apply it), kDuplicate, kOutOfOrder, kSequenceJump, kReset (counts toward, or completes, a re-base). */
  Reject check(std::uint32_t sequence, bool pedal) noexcept;

  std::uint32_t last() const noexcept { return last_; }
  std::uint64_t lost() const noexcept { return lost_; }  ///< numbers skipped by accepted gaps

 private:
  Reject outside(std::uint32_t sequence, bool pedal, Reject reason) noexcept;

  bool started_{false};
  std::uint32_t last_{0};
  std::uint64_t lost_{0};
  std::uint32_t candidate_{0};
  int candidate_run_{0};
};

}  // namespace raven2_trainer::wire
