#include "outgoing_queue.h"

#include <cstring>

namespace raven2_trainer::net {

std::size_t OutgoingQueue::push(const std::uint8_t* frame, std::size_t size) noexcept {
  std::size_t dropped = 0;
  if (count_ == slots_.size()) {
    head_ = (head_ + 1) % slots_.size();
    --count_;
    dropped = 1;
  }
  Slot& slot = slots_[(head_ + count_) % slots_.size()];
  slot.size = size;
  std::memcpy(slot.bytes.data(), frame, size);
  ++count_;
  return dropped;
}

const std::uint8_t* OutgoingQueue::data() noexcept {
  refill();
  return current_.bytes.data() + begin_;
}

std::size_t OutgoingQueue::size() noexcept {
  refill();
  return current_.size - begin_;
}

void OutgoingQueue::refill() noexcept {
  if (begin_ != current_.size || count_ == 0) return;
  const Slot& next = slots_[head_];
  current_.size = next.size;
  std::memcpy(current_.bytes.data(), next.bytes.data(), next.size);
  begin_ = 0;
  head_ = (head_ + 1) % slots_.size();
  --count_;
}

}  // namespace raven2_trainer::net
