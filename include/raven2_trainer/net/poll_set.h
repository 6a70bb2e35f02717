#pragma once

#include <poll.h>

#include <cstdint>
#include <vector>

namespace raven2_trainer::net {

/** Waits for any of several descriptors, to a point in time. Filled again for every wait. */
class PollSet {
 public:
  void clear() noexcept { entries_.clear(); }
  void add(int fd, bool to_read, bool to_write);

  /** Until one of them is ready or CLOCK_MONOTONIC reaches `until_ns`. */
  void wait(std::int64_t until_ns) noexcept;

 private:
  std::vector<pollfd> entries_;
};

}  // namespace raven2_trainer::net
