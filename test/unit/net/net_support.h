#pragma once

#include <dirent.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <cstdint>

#include "raven2_trainer/net/clock.h"
#include "raven2_trainer/net/file_descriptor.h"

namespace raven2_trainer::net {

constexpr std::int64_t kDeadlineNs =
    10'000'000'000;  ///< far beyond what a loaded machine needs; passes never wait so long

/** Calls `step` until it returns true. @return false after the deadline. `step` does the waiting. */
template <typename Step>
bool eventually(Step step) {
  const std::int64_t end = monotonicNow() + kDeadlineNs;
  while (monotonicNow() < end) {
    if (step()) return true;
  }
  return false;
}

/** Open descriptors of this process. */
inline int openDescriptors() {
  DIR* directory = ::opendir("/proc/self/fd");
  int count = 0;
  while (directory != nullptr && ::readdir(directory) != nullptr)
    ++count;
  if (directory != nullptr) ::closedir(directory);
  return count;
}

/** A TCP port on 127.0.0.1 that is taken but, until listen() is called, answers nobody. */
class TakenPort {
 public:
  TakenPort() : fd_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof(address);
    if (::bind(fd_.get(), reinterpret_cast<sockaddr*>(&address), size) == 0 &&
        ::getsockname(fd_.get(), reinterpret_cast<sockaddr*>(&address), &size) == 0) {
      port_ = ntohs(address.sin_port);
    }
  }
  std::uint16_t port() const { return port_; }
  bool listen(int backlog) { return ::listen(fd_.get(), backlog) == 0; }

 private:
  FileDescriptor fd_;
  std::uint16_t port_{0};
};

}  // namespace raven2_trainer::net
