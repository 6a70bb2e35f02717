#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "raven2_trainer/wire/robot_frame.h"

namespace raven2_trainer::net {

/**
 * Whole frames to be sent to one reader. Full: the oldest frame not yet begun is dropped, because the newest
 * state is worth most. The frame of which a part has gone is kept, or the reader's stream would break.
 * All memory is taken in the constructor.
 */
class OutgoingQueue {
 public:
  explicit OutgoingQueue(std::size_t capacity) : slots_(capacity) {}

  /** @return number of frames dropped for it, 0 or 1. `size` is at most wire::kMaxFrame. */
  std::size_t push(const std::uint8_t* frame, std::size_t size) noexcept;

  /** Bytes to send next; size 0: nothing. */
  const std::uint8_t* data() noexcept;
  std::size_t size() noexcept;

  /** That many of data() are sent. @return true if the frame is, whole. */
  bool consume(std::size_t count) noexcept {
    begin_ += count;
    return begin_ == current_.size;
  }

  /** Frames that wait, the one of which a part has gone included. */
  std::size_t frames() const noexcept { return count_ + (begin_ != current_.size ? 1 : 0); }

 private:
  struct Slot {
    std::size_t size{0};
    std::array<std::uint8_t, wire::kMaxFrame> bytes{};
  };

  void refill() noexcept;

  std::vector<Slot> slots_;
  std::size_t head_{0};
  std::size_t count_{0};
  Slot current_;          ///< the frame being sent
  std::size_t begin_{0};  ///< bytes of it that have gone
};

}  // namespace raven2_trainer::net
