#pragma once

#include <cstdint>

#include "raven2_trainer/core/counters.h"

namespace raven2_trainer::wire {

/** Order rule of packets with complete states: only a packet newer than the newest counts, whatever was lost
 *  in between. Serial arithmetic on 32 bits. Real-time safe. */
class NewestOnly {
 public:
  /** kNone (use it), kDuplicate or kOutOfOrder. */
  Reject check(std::uint32_t sequence) noexcept {
    const std::uint32_t ahead = sequence - last_;
    if (started_ && ahead == 0) return Reject::kDuplicate;
    if (started_ && ahead >= 0x80000000U) return Reject::kOutOfOrder;
    started_ = true;
    last_ = sequence;
    return Reject::kNone;
  }

  /** The sender is gone: another one may begin with any number. */
  void reset() noexcept { started_ = false; }

 private:
  std::uint32_t last_{0};
  bool started_{false};
};

}  // namespace raven2_trainer::wire
