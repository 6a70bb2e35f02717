#pragma once

#include "raven2_trainer/net/file_descriptor.h"

namespace raven2_trainer::net {

/** Wakes one waiting thread from any other. Signals that come before the wait are not lost; many make one wake-up. */
class EventFd {
 public:
  /** @throw NetworkException if the system gives no descriptor. */
  EventFd();

  /** One write(2), never blocks: for real-time threads. */
  void signal() noexcept;

  /** Waits at most `timeout_ms` (0: just looks). @return true, and cleared, if there was a signal. */
  bool wait(int timeout_ms) noexcept;

 private:
  FileDescriptor fd_;
};

}  // namespace raven2_trainer::net
