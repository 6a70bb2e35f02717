#include "ros/node/init_node.h"

#include <ros/init.h>
#include <ros/master.h>
#include <ros/network.h>
#include <ros/xmlrpc_manager.h>
#include <xmlrpcpp/XmlRpcException.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <string>

#include "raven2_trainer/core/exceptions.h"
#include "ros/node/exposure.h"
#include "ros/node/xmlrpc_call.h"

namespace raven2_trainer::ros_bridge {
namespace {

constexpr double kRetryTimeout = 0.25;  // [s] roscpp's own calls to a master that just went: for ever is its default

void refuseShutdown(XmlRpc::XmlRpcValue& arguments, XmlRpc::XmlRpcValue& /*answer*/) {
  const bool has_reason = arguments.getType() == XmlRpc::XmlRpcValue::TypeArray && arguments.size() > 0;
  std::fprintf(stderr, "a ROS shutdown call is refused%s\n", has_reason ? "" : " (and malformed)");
  throw XmlRpc::XmlRpcException("shutdown is refused: end this node by a signal");
}

/** Throws now what roscpp would abort the process for. */
void checkUri(const std::string& uri, std::string* host, std::uint32_t* port) {
  if (ros::network::splitURI(uri, *host, *port) && !host->empty() && *port > 0 && *port <= 65535) return;
  throw ConfigException("ROS master \"" + uri + "\": http://HOST:PORT is wanted (ROS_MASTER_URI)");
}

/** Takes _parameter:=value out, which without a master has nowhere to go: roscpp would try for a while and complain.
 *  @return how many arguments are left. */
int withoutParameters(int argc, char** argv) {
  const auto is_parameter = [](const std::string& word) {
    return word.size() > 1 && word[0] == '_' && word[1] != '_' && word.find(":=") != std::string::npos;
  };
  return static_cast<int>(std::remove_if(argv + 1, argv + argc, is_parameter) - argv);
}

}  // namespace

void initNode(int argc, char** argv, const char* node) {
  if (ros::isInitialized()) return;
  std::string host;
  std::uint32_t port = 0;
  checkUri(masterUri(argc, argv), &host, &port);
  keepToLoopback(host);
  if (!call(host, port, "getPid", {XmlRpc::XmlRpcValue(node)})) argc = withoutParameters(argc, argv);
  ros::master::setRetryTimeout(ros::WallDuration(kRetryTimeout));  // ros::init, too, calls it for _parameter:=value
  // Our mains wait for signals themselves: the force goes to zero before anything else ends.
  ros::init(argc, argv, node, ros::init_options::NoSigintHandler | ros::init_options::NoRosout);
  // Before ros::start() binds its own: the first one holds, and there is no moment without.
  ros::XMLRPCManager::instance()->bind("shutdown", &refuseShutdown);
  if (!isLoopbackOnly())
    std::fprintf(stderr,
                 "ROS serves the network (ROS_IP, ROS_HOSTNAME): every computer that reaches this one can call it\n");
}

}  // namespace raven2_trainer::ros_bridge
