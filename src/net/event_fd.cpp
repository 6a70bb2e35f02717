#include "raven2_trainer/net/event_fd.h"

#include <poll.h>
#include <sys/eventfd.h>

#include <cerrno>
#include <cstdint>
#include <cstring>

#include "raven2_trainer/core/exceptions.h"
#include "sockets.h"

namespace raven2_trainer::net {

EventFd::EventFd() : fd_(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {
  if (!fd_.isOpen()) throw NetworkException(std::string("eventfd: ") + std::strerror(errno));
}

void EventFd::signal() noexcept {
  const std::uint64_t one = 1;
  // Fails only if 2^64 - 1 signals wait: then one is pending anyway.
  [[maybe_unused]] const ssize_t written = ::write(fd_.get(), &one, sizeof(one));
}

bool EventFd::wait(int timeout_ms) noexcept {
  if (timeout_ms != 0 && (waitFor(fd_.get(), POLLIN, timeout_ms) & POLLIN) == 0) return false;
  std::uint64_t count = 0;
  return ::read(fd_.get(), &count, sizeof(count)) == sizeof(count);
}

}  // namespace raven2_trainer::net
