#include "raven2_trainer/net/endpoint.h"

#include <arpa/inet.h>
#include <netdb.h>
#include <sys/socket.h>

#include "raven2_trainer/core/exceptions.h"
#include "sockets.h"

namespace raven2_trainer::net {

std::string toString(const Endpoint& endpoint) {
  const in_addr address{htonl(endpoint.address)};
  char text[INET_ADDRSTRLEN] = "?";
  ::inet_ntop(AF_INET, &address, text, sizeof(text));
  return std::string(text) + ":" + std::to_string(endpoint.port);
}

Endpoint resolve(const std::string& host, std::uint16_t port) {
  addrinfo hints{};
  hints.ai_family = AF_INET;
  hints.ai_socktype = SOCK_DGRAM;  // one answer an address
  addrinfo* found = nullptr;
  const int error = ::getaddrinfo(host.c_str(), nullptr, &hints, &found);
  if (error != 0) {
    throw NetworkException("host " + host + " port " + std::to_string(port) + ": " + ::gai_strerror(error));
  }
  Endpoint endpoint = fromSockaddr(*reinterpret_cast<const sockaddr_in*>(found->ai_addr));
  ::freeaddrinfo(found);
  endpoint.port = port;
  return endpoint;
}

}  // namespace raven2_trainer::net
