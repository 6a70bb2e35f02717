#pragma once

#include <string>

#include "raven2_trainer/net/endpoint.h"

namespace raven2_trainer::net {

/**
 * The process that has a port, and how the port becomes free: "Process 4711 (simulator --hazard none) has it: end it".
 * Reads /proc, where a user sees the sockets of all, but the programs of others only as root. For set-up.
 * @param[in] type SOCK_STREAM or SOCK_DGRAM.
 */
std::string portHolder(const Endpoint& endpoint, int type);

}  // namespace raven2_trainer::net
