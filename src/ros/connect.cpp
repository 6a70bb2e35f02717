#include <netdb.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <ros/init.h>
#include <ros/master.h>

#include <memory>
#include <string>

#include "raven2_trainer/ros/ros_bridge.h"

namespace raven2_trainer::ros_bridge {
namespace {

constexpr int kProbeMs = 1000;

/** Does anything accept connections there? ros::master::check() alone can block for minutes on a silent host. */
bool accepts(const std::string& host, std::uint32_t port) {
  addrinfo hints{};
  hints.ai_family = AF_INET;
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  if (getaddrinfo(host.c_str(), std::to_string(port).c_str(), &hints, &found) != 0) return false;
  const std::unique_ptr<addrinfo, decltype(&freeaddrinfo)> address(found, &freeaddrinfo);
  const int fd = socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (fd < 0) return false;
  ::connect(fd, address->ai_addr, address->ai_addrlen);
  pollfd ready{fd, POLLOUT, 0};
  int error = 1;
  socklen_t size = sizeof(error);
  const bool answered = poll(&ready, 1, kProbeMs) == 1 && getsockopt(fd, SOL_SOCKET, SO_ERROR, &error, &size) == 0;
  close(fd);
  return answered && error == 0;
}

}  // namespace

bool connect(int argc, char** argv, const char* node) {
  // Our mains wait for signals themselves: the force goes to zero before anything else ends.
  ros::init(argc, argv, node, ros::init_options::NoSigintHandler | ros::init_options::NoRosout);
  return accepts(ros::master::getHost(), ros::master::getPort()) && ros::master::check();
}

}  // namespace raven2_trainer::ros_bridge
