#pragma once

#include <dirent.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <cstdint>
#include <vector>

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
  /** Accepts one and sends it a byte; it stays open. */
  bool greet(std::uint8_t byte) {
    guest_ = FileDescriptor(::accept(fd_.get(), nullptr, nullptr));
    return ::send(guest_.get(), &byte, 1, MSG_NOSIGNAL) == 1;
  }
  bool acceptAndClose() { return FileDescriptor(::accept(fd_.get(), nullptr, nullptr)).isOpen(); }

 private:
  FileDescriptor fd_, guest_;
  std::uint16_t port_{0};
};

/** A client of 127.0.0.1 that may do anything. */
class PlainSocket {
 public:
  PlainSocket() : fd_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {}
  bool connect(std::uint16_t port) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address.sin_port = htons(port);
    return ::connect(fd_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof(address)) == 0;
  }
  bool write(const std::vector<std::uint8_t>& bytes) {
    const ssize_t size = ::send(fd_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
    return size == static_cast<ssize_t>(bytes.size());
  }
  /** Closes with a reset, or normally. */
  void close(bool reset) {
    const linger now{1, 0};
    if (reset) ::setsockopt(fd_.get(), SOL_SOCKET, SO_LINGER, &now, sizeof(now));
    fd_.close();
  }

 private:
  FileDescriptor fd_;
};

}  // namespace raven2_trainer::net
