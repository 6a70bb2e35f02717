#include "raven2_trainer/wire/sequence_rule.h"

namespace raven2_trainer::wire {
namespace {

constexpr std::uint32_t kResetDistance = 1000;

}  // namespace

Reject SequenceRule::check(std::uint32_t sequence) noexcept {
  if (sequence == 0) return Reject::kSequenceZero;
  // The robot adds in 32 bits, so behind the largest number everything is a gap.
  if (sequence > last_ + 1U) {
    last_ = sequence;
    return Reject::kSequenceGap;
  }
  if (sequence == last_) return Reject::kDuplicate;
  if (sequence > last_) {
    last_ = sequence;
    return Reject::kNone;
  }
  if (last_ > kResetDistance && sequence < last_ - kResetDistance) {
    last_ = sequence;
    return Reject::kReset;
  }
  return Reject::kOutOfOrder;
}

}  // namespace raven2_trainer::wire
