#pragma once

#include <cstdint>
#include <string>

namespace raven2_trainer::net {

/** IPv4 address and port, both in host byte order. */
struct Endpoint {
  std::uint32_t address{};
  std::uint16_t port{};

  bool operator==(const Endpoint& other) const noexcept { return address == other.address && port == other.port; }
  bool operator!=(const Endpoint& other) const noexcept { return !(*this == other); }
};

/** "127.0.0.1:36010" */
std::string toString(const Endpoint& endpoint);

/**
 * Address of a name or of dotted numbers. May block on the name service: set-up only.
 * @throw NetworkException with host and port if there is none.
 */
Endpoint resolve(const std::string& host, std::uint16_t port);

}  // namespace raven2_trainer::net
