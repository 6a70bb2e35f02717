#include "ros/init_node.h"

#include <ros/init.h>
#include <ros/master.h>
#include <ros/network.h>
#include <ros/xmlrpc_manager.h>
#include <xmlrpcpp/XmlRpcException.h>

#include <cstdio>
#include <string>

#include "raven2_trainer/core/exceptions.h"
#include "ros/exposure.h"

namespace raven2_trainer::ros_bridge {
namespace {

constexpr double kRetryTimeout = 0.25;  // [s] roscpp's own calls to a master that just went: for ever is its default

void refuseShutdown(XmlRpc::XmlRpcValue& arguments, XmlRpc::XmlRpcValue& /*answer*/) {
  const bool has_reason = arguments.getType() == XmlRpc::XmlRpcValue::TypeArray && arguments.size() > 0;
  std::fprintf(stderr, "a ROS shutdown call is refused%s\n", has_reason ? "" : " (and malformed)");
  throw XmlRpc::XmlRpcException("shutdown is refused: end this node by a signal");
}

/** Throws now what roscpp would abort the process for. */
void checkUri(const std::string& uri, std::string* host) {
  std::uint32_t port = 0;
  if (ros::network::splitURI(uri, *host, port) && !host->empty() && port > 0 && port <= 65535) return;
  throw ConfigException("ROS master \"" + uri + "\": http://HOST:PORT is wanted (ROS_MASTER_URI)");
}

}  // namespace

void initNode(int argc, char** argv, const char* node) {
  if (ros::isInitialized()) return;
  std::string host;
  checkUri(masterUri(argc, argv), &host);
  keepToLoopback(host);
  ros::master::setRetryTimeout(ros::WallDuration(kRetryTimeout));  // ros::init, too, calls it for _parameter:=value
  // Our mains wait for signals themselves: the force goes to zero before anything else ends.
  ros::init(argc, argv, node, ros::init_options::NoSigintHandler | ros::init_options::NoRosout);
  // Before ros::start() binds its own: the first one holds, and there is no moment without.
  ros::XMLRPCManager::instance()->bind("shutdown", &refuseShutdown);
  if (!isLoopbackOnly())
    std::fprintf(stderr, "ROS serves the network (ROS_IP, ROS_HOSTNAME): whoever reaches this computer can call it\n");
}

}  // namespace raven2_trainer::ros_bridge
