#include "raven2_trainer/wire/replay_window.h"

namespace raven2_trainer::wire {

bool ReplayWindow::isFresh(std::uint64_t counter) const noexcept {
  if (seen_ == 0 || counter > newest_) return true;
  const std::uint64_t behind = newest_ - counter;
  return behind < kWindow && (seen_ >> behind & 1U) == 0;
}

void ReplayWindow::mark(std::uint64_t counter) noexcept {
  if (isLate(counter)) {
    seen_ |= std::uint64_t{1} << (newest_ - counter);
    return;
  }
  const std::uint64_t ahead = counter - newest_;
  seen_ = (seen_ == 0 || ahead >= kWindow ? 0 : seen_ << ahead) | 1U;
  newest_ = counter;
}

}  // namespace raven2_trainer::wire
