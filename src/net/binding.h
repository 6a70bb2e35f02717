#pragma once

#include <functional>
#include <string>

#include "raven2_trainer/net/endpoint.h"

namespace raven2_trainer::net {

/**
 * Calls `bind`, and calls it again for `patience` [s] as long as the port is taken: the program that had it may be
 * about to end.
 *
 * @param[in] type SOCK_STREAM or SOCK_DGRAM, for the search of the port's owner.
 * @param[in] bind returns 0 or the system's error.
 * @throw NetworkException "WHAT ADDRESS:PORT: bind: system error"; of a taken port, its owner and what to do.
 */
void bindPatiently(const std::string& what,
                   const Endpoint& endpoint,
                   int type,
                   double patience,
                   const std::function<int()>& bind);

/** bind() of one socket. @return 0 or the system's error. */
int bindOnce(int fd, const Endpoint& endpoint) noexcept;

}  // namespace raven2_trainer::net
