#include "ros/node/exposure.h"

#include <netdb.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <memory>

namespace raven2_trainer::ros_bridge {
namespace {

constexpr const char* kMasterArgument = "__master:=";

std::string environment(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? "" : value;
}

bool startsWith(const std::string& text, const std::string& beginning) {
  return text.compare(0, beginning.size(), beginning) == 0;
}

/** A numeric address is our own if a socket can be bound to it. Names are not looked up: that can take seconds. */
bool isOwnAddress(const std::string& host) {
  addrinfo hints{};
  hints.ai_flags = AI_NUMERICHOST;
  hints.ai_socktype = SOCK_DGRAM;
  addrinfo* found = nullptr;
  if (getaddrinfo(host.c_str(), nullptr, &hints, &found) != 0) return false;
  const std::unique_ptr<addrinfo, decltype(&freeaddrinfo)> address(found, &freeaddrinfo);
  const int fd = socket(address->ai_family, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (fd < 0) return false;
  const bool is_own = bind(fd, address->ai_addr, address->ai_addrlen) == 0;
  close(fd);
  return is_own;
}

std::string hostName() {
  std::array<char, 256> name{};
  gethostname(name.data(), name.size() - 1);
  return name.data();
}

bool isThisComputer(const std::string& host) {
  return host == "localhost" || host == hostName() || isOwnAddress(host);
}

}  // namespace

std::string masterUri(int argc, char** argv) {
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (startsWith(argument, kMasterArgument)) return argument.substr(std::string(kMasterArgument).size());
  }
  const std::string uri = environment("ROS_MASTER_URI");
  return uri.empty() ? "http://localhost:11311" : uri;
}

void keepToLoopback(const std::string& host) {
  if (!environment("ROS_IP").empty() || !environment("ROS_HOSTNAME").empty() || !isThisComputer(host)) return;
  setenv("ROS_IP", "127.0.0.1", 1);
  unsetenv("ROS_HOSTNAME");  // empty, roscpp would complain
}

bool isLoopbackOnly() {
  const std::string ip = environment("ROS_IP");
  return environment("ROS_HOSTNAME") == "localhost" || startsWith(ip, "127.");
}

bool mayCommand(bool enable_remote_control) {
  return enable_remote_control || isLoopbackOnly();
}

}  // namespace raven2_trainer::ros_bridge
