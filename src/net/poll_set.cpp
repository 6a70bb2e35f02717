#include "raven2_trainer/net/poll_set.h"

#include <algorithm>
#include <ctime>

#include "raven2_trainer/net/clock.h"

namespace raven2_trainer::net {

void PollSet::add(int fd, bool to_read, bool to_write) {
  const int events = (to_read ? POLLIN : 0) | (to_write ? POLLOUT : 0);
  if (events != 0) entries_.push_back({fd, static_cast<short>(events), 0});
}

void PollSet::wait(std::int64_t until_ns) noexcept {
  const std::int64_t left = std::max<std::int64_t>(until_ns - monotonicNow(), 0);
  timespec timeout{};
  timeout.tv_sec = static_cast<time_t>(left / 1'000'000'000);
  timeout.tv_nsec = static_cast<long>(left % 1'000'000'000);
  ::ppoll(entries_.data(), entries_.size(), &timeout, nullptr);
}

}  // namespace raven2_trainer::net
