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

/** As one number: address << 16 | port. */
constexpr std::uint64_t sourceId(const Endpoint& endpoint) noexcept {
  return static_cast<std::uint64_t>(endpoint.address) << 16U | endpoint.port;
}
constexpr Endpoint endpointOf(std::uint64_t source) noexcept {
  return {static_cast<std::uint32_t>(source >> 16U), static_cast<std::uint16_t>(source & 0xFFFFU)};
}

/** [s] for which a port that is taken is tried again: a session that is ending takes at most 2. */
constexpr double kBindPatience = 3.0;

/** "127.0.0.1:36010" */
std::string toString(const Endpoint& endpoint);

/**
 * Address of a name or of dotted numbers. May block on the name service: set-up only.
 * @throw NetworkException with host and port if it is unknown.
 */
Endpoint resolve(const std::string& host, std::uint16_t port);

}  // namespace raven2_trainer::net
