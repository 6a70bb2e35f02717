#include "raven2_trainer/wire/sequence_window.h"

namespace raven2_trainer::wire {

Reject SequenceWindow::check(std::uint32_t sequence, bool pedal) noexcept {
  if (!started_) {
    started_ = true;
    last_ = sequence;
    return Reject::kNone;
  }
  const std::uint32_t ahead = sequence - last_;  // serial arithmetic: wraps with the counter
  if (ahead == 0) return Reject::kDuplicate;
  if (ahead > kWindow) {
    const bool is_late = ahead >= 0x80000000U;
    return outside(sequence, pedal, is_late ? Reject::kOutOfOrder : Reject::kSequenceJump);
  }
  last_ = sequence;
  lost_ += ahead - 1;
  candidate_run_ = 0;
  return Reject::kNone;
}

Reject SequenceWindow::outside(std::uint32_t sequence, bool pedal, Reject reason) noexcept {
  if (pedal) {
    candidate_run_ = 0;
    return reason;
  }
  if (candidate_run_ > 0 && sequence == candidate_) return Reject::kDuplicate;
  const bool continues = candidate_run_ > 0 && sequence == candidate_ + 1;
  candidate_run_ = continues ? candidate_run_ + 1 : 1;
  candidate_ = sequence;
  if (!continues) return reason;
  if (candidate_run_ >= kRebaseAfter) {
    last_ = sequence;
    candidate_run_ = 0;
  }
  return Reject::kReset;
}

}  // namespace raven2_trainer::wire
