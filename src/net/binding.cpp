#include "binding.h"

#include <sys/socket.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <sstream>
#include <thread>

#include "port_holder.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/net/clock.h"
#include "sockets.h"

namespace raven2_trainer::net {
namespace {

constexpr auto kPause = std::chrono::milliseconds(100);

std::string takenFor(double patience, const Endpoint& endpoint, int type) {
  std::ostringstream text;
  text << ", also " << patience << " s later. " << portHolder(endpoint, type)
       << ", or take another port (config/network.yaml, or the option of this program)";
  return text.str();
}

}  // namespace

int bindOnce(int fd, const Endpoint& endpoint) noexcept {
  const sockaddr_in address = toSockaddr(endpoint);
  return ::bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) == 0 ? 0 : errno;
}

void bindPatiently(const std::string& what,
                   const Endpoint& endpoint,
                   int type,
                   double patience,
                   const std::function<int()>& bind) {
  const std::int64_t end = monotonicNow() + static_cast<std::int64_t>(1e9 * patience);
  int error = bind();
  while (error == EADDRINUSE && monotonicNow() < end) {
    std::this_thread::sleep_for(kPause);
    error = bind();
  }
  if (error == 0) return;
  const std::string more = error == EADDRINUSE ? takenFor(patience, endpoint, type) : "";
  throw NetworkException(what + " " + toString(endpoint) + ": bind: " + std::strerror(error) + more);
}

}  // namespace raven2_trainer::net
