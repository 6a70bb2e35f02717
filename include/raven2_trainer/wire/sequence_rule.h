#pragma once

#include <cstdint>

#include "raven2_trainer/core/counters.h"

namespace raven2_trainer::wire {

/** The robot's own rule for ITP sequence numbers, row by row as its network layer tests them (raven2.md 1.5): unsigned
 *  comparison, no wrap, a gap costs the packet after it. Real-time safe. */
class SequenceRule {
 public:
  /** kNone (use it), kSequenceZero, kSequenceGap, kDuplicate, kReset or kOutOfOrder. */
  Reject check(std::uint32_t sequence) noexcept;

  std::uint32_t last() const noexcept { return last_; }

 private:
  std::uint32_t last_{0};
};

}  // namespace raven2_trainer::wire
