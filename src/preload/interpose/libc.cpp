// The C library's calls, as a program with LD_PRELOAD=libraven2_usb_faults.so finds them first. Each makes the real
// call itself, outside of any noexcept function: a thread that is cancelled while it waits there unwinds through this
// frame.

#include <dlfcn.h>
#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdarg>
#include <cstdint>
#include <cstring>

#include "preload/interpose/injector.h"

namespace {

using namespace raven2_trainer;
using preload::Role;

/** The calls that these replace: the C library's, or those of the next preloaded library. */
struct Next {
  template <typename Function>
  static void find(const char* name, Function** function) {
    *function = reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
  }
  Next() {
    find("open", &open);
    find("openat", &openat);
    find("close", &close);
    find("read", &read);
    find("write", &write);
    find("recvfrom", &recvfrom);
  }

  int (*open)(const char*, int, ...){};
  int (*openat)(int, const char*, int, ...){};
  int (*close)(int){};
  ssize_t (*read)(int, void*, size_t){};
  ssize_t (*write)(int, const void*, size_t){};
  ssize_t (*recvfrom)(int, void*, size_t, int, sockaddr*, socklen_t*){};
};

const Next& next() {
  static const Next found;
  return found;
}

/** The argument behind the flags, where there is one. */
mode_t modeOf(int flags, va_list rest) {
  const bool has_mode = (flags & O_CREAT) != 0 || (flags & O_TMPFILE) == O_TMPFILE;
  return has_mode ? static_cast<mode_t>(va_arg(rest, unsigned)) : 0;
}

int openNext(const char* path, int flags, mode_t mode) {
  const int descriptor = next().open(path, flags, mode);
  preload::opened(path, descriptor);
  return descriptor;
}

int openNextAt(int folder, const char* path, int flags, mode_t mode) {
  const int descriptor = next().openat(folder, path, flags, mode);
  preload::opened(path, descriptor);
  return descriptor;
}

ssize_t readNext(int descriptor, void* buffer, size_t size) {
  const ssize_t count = next().read(descriptor, buffer, size);
  const Role role = preload::roleOf(descriptor);
  return preload::isBoard(role) ? preload::afterRead(preload::armOf(role), count, buffer, size) : count;
}

/** Sender of the newest packet, also for one that was held back. For the network thread only. */
struct Source {
  sockaddr_storage address{};
  socklen_t size{0};

  void copyTo(sockaddr* to, socklen_t* to_size) const {
    if (to == nullptr || to_size == nullptr) return;
    std::memcpy(to, &address, std::min(*to_size, size));
    *to_size = size;
  }
};

bool waits(int descriptor, int flags) {
  if ((flags & MSG_DONTWAIT) != 0) return false;
  const int error = errno;
  const int status = fcntl(descriptor, F_GETFL);
  errno = error;
  return status < 0 || (status & O_NONBLOCK) == 0;
}

std::int64_t nowMs() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return std::int64_t{now.tv_sec} * 1000 + now.tv_nsec / 1000000;
}

/** How long who waits for a packet is kept waiting behind a lost one: as long as raven2's network thread waits in its
 * select() (network_layer.cpp:206-235), and then looks whether it is to end. */
class Patience {
 public:
  /** A packet was lost. @return whether another may come; false with errno, EAGAIN without a packet. */
  bool awaitsNext(int descriptor, int flags) {
    if (until_ms_ == 0) until_ms_ = waits(descriptor, flags) ? nowMs() + kPatienceMs : kNone;
    const std::int64_t left = std::max<std::int64_t>(until_ms_ - nowMs(), 0);
    pollfd socket{descriptor, POLLIN, 0};
    const int ready = left > 0 ? poll(&socket, 1, static_cast<int>(left)) : 0;
    if (ready == 0) errno = EAGAIN;
    return ready > 0;
  }

 private:
  static constexpr std::int64_t kPatienceMs = 2000;
  static constexpr std::int64_t kNone = -1;
  std::int64_t until_ms_{0};
};

/** As the socket would behave without the lost packets. A waiting call waits for the next packet, but no longer than
 * its timeout. Another call gets
 * EAGAIN, although select() said otherwise, as it may when a datagram's check sum is wrong. */
ssize_t receiveNext(int descriptor, void* buffer, size_t size, int flags, sockaddr* from, socklen_t* from_size) {
  static thread_local Source source;
  wire::ItpBytes packet;
  Patience patience;
  while (!preload::takePacket(&packet)) {
    source.size = sizeof(source.address);
    const ssize_t count =
        next().recvfrom(descriptor, buffer, size, flags, reinterpret_cast<sockaddr*>(&source.address), &source.size);
    if (count != static_cast<ssize_t>(wire::kItpSize)) {
      if (count >= 0) source.copyTo(from, from_size);
      return count;
    }
    preload::offerPacket(buffer);
    if (preload::takePacket(&packet)) break;
    if (!patience.awaitsNext(descriptor, flags)) return -1;
    flags |= MSG_DONTWAIT;  // what poll() saw may be gone
  }
  std::memcpy(buffer, packet.data(), packet.size());
  source.copyTo(from, from_size);
  return static_cast<ssize_t>(packet.size());
}

ssize_t receiveFrom(int descriptor, void* buffer, size_t size, int flags, sockaddr* from, socklen_t* from_size) {
  const bool is_itp = preload::roleOfSocket(descriptor) == Role::kItp && preload::isOn();
  if (!is_itp || size < wire::kItpSize || (flags & (MSG_PEEK | MSG_ERRQUEUE)) != 0)
    return next().recvfrom(descriptor, buffer, size, flags, from, from_size);
  return receiveNext(descriptor, buffer, size, flags, from, from_size);
}

}  // namespace

#define RAVEN2_EXPORT __attribute__((visibility("default")))

extern "C" {

RAVEN2_EXPORT int open(const char* path, int flags, ...) {
  va_list rest;
  va_start(rest, flags);
  const mode_t mode = modeOf(flags, rest);
  va_end(rest);
  return openNext(path, flags, mode);
}

RAVEN2_EXPORT int open64(const char* path, int flags, ...) {
  va_list rest;
  va_start(rest, flags);
  const mode_t mode = modeOf(flags, rest);
  va_end(rest);
  return openNext(path, flags | O_LARGEFILE, mode);
}

RAVEN2_EXPORT int openat(int folder, const char* path, int flags, ...) {
  va_list rest;
  va_start(rest, flags);
  const mode_t mode = modeOf(flags, rest);
  va_end(rest);
  return openNextAt(folder, path, flags, mode);
}

RAVEN2_EXPORT int openat64(int folder, const char* path, int flags, ...) {
  va_list rest;
  va_start(rest, flags);
  const mode_t mode = modeOf(flags, rest);
  va_end(rest);
  return openNextAt(folder, path, flags | O_LARGEFILE, mode);
}

// Programs built with _FORTIFY_SOURCE call these in their place.
RAVEN2_EXPORT int __open_2(const char* path, int flags) {
  return openNext(path, flags, 0);
}

RAVEN2_EXPORT int __open64_2(const char* path, int flags) {
  return openNext(path, flags | O_LARGEFILE, 0);
}

RAVEN2_EXPORT int __openat_2(int folder, const char* path, int flags) {
  return openNextAt(folder, path, flags, 0);
}

RAVEN2_EXPORT int __openat64_2(int folder, const char* path, int flags) {
  return openNextAt(folder, path, flags | O_LARGEFILE, 0);
}

RAVEN2_EXPORT int close(int descriptor) {
  preload::closed(descriptor);
  return next().close(descriptor);
}

RAVEN2_EXPORT ssize_t read(int descriptor, void* buffer, size_t size) {
  return readNext(descriptor, buffer, size);
}

RAVEN2_EXPORT ssize_t __read_chk(int descriptor, void* buffer, size_t size, size_t room) {
  return readNext(descriptor, buffer, std::min(size, room));
}

RAVEN2_EXPORT ssize_t write(int descriptor, const void* buffer, size_t size) {
  const Role role = preload::roleOf(descriptor);
  if (!preload::isBoard(role) || !preload::isOn() || size != sizeof(raven::UsbOutBytes))
    return next().write(descriptor, buffer, size);
  const preload::Delivery delivery = preload::beforeWrite(preload::armOf(role), descriptor, buffer);
  if (delivery.descriptor < 0) return static_cast<ssize_t>(size);
  return next().write(delivery.descriptor, delivery.bytes.data(), size);
}

RAVEN2_EXPORT ssize_t
recvfrom(int descriptor, void* buffer, size_t size, int flags, sockaddr* from, socklen_t* from_size) {
  return receiveFrom(descriptor, buffer, size, flags, from, from_size);
}

RAVEN2_EXPORT ssize_t __recvfrom_chk(int descriptor,
                                     void* buffer,
                                     size_t size,
                                     size_t room,
                                     int flags,
                                     sockaddr* from,
                                     socklen_t* from_size) {
  return receiveFrom(descriptor, buffer, std::min(size, room), flags, from, from_size);
}

}  // extern "C"
