#pragma once

#include <netinet/in.h>

#include <string>

#include "raven2_trainer/net/endpoint.h"
#include "raven2_trainer/net/file_descriptor.h"

// Shared by the sockets of this module.

namespace raven2_trainer::net {

/** @throw NetworkException "WHAT ADDRESS:PORT: CALL: system error". */
[[noreturn]] void throwNetwork(const std::string& what, const Endpoint& endpoint, const char* call, int error);

sockaddr_in toSockaddr(const Endpoint& endpoint) noexcept;
Endpoint fromSockaddr(const sockaddr_in& address) noexcept;

/** Non-blocking, closed on exec. `type` is SOCK_STREAM or SOCK_DGRAM. Check isOpen(). */
FileDescriptor openSocket(int type) noexcept;

/** Sets an integer option. @return false if refused. */
bool setOption(int fd, int level, int option, int value) noexcept;

/** Prompt sending, and a dead peer noticed within about 3 s (sources.md 2.2). */
void tuneTcp(int fd) noexcept;

/** Address and port the socket got. */
Endpoint localEndpoint(int fd) noexcept;

/** Waits at most `timeout_ms` (negative: does not wait) for `events`. @return the events that came; 0 after the time or
 * a signal. */
short waitFor(int fd, short events, int timeout_ms) noexcept;

/** [bytes] of each TCP buffer: small, so that what is in flight is fresh (sources.md 2.2). */
constexpr int kTcpBuffer = 32 * 1024;

}  // namespace raven2_trainer::net
