#include "raven2_trainer/ros/parameters.h"

#include <ros/master.h>
#include <ros/this_node.h>

#include <algorithm>
#include <cstdio>
#include <string>

#include "raven2_trainer/core/exceptions.h"
#include "ros/node/exposure.h"
#include "ros/node/init_node.h"
#include "ros/node/parameter_text.h"
#include "ros/node/registration.h"
#include "ros/node/xmlrpc_call.h"

namespace raven2_trainer::ros_bridge {
namespace {

using Value = XmlRpc::XmlRpcValue;

bool speaksOfRos(int argc, char** argv) {
  const auto is_remapping = [](const std::string& word) { return word.find(":=") != std::string::npos; };
  return std::any_of(argv + 1, argv + argc, is_remapping);
}

/** Of the master's parameter server, about everything under this node's name. */
Value ask(const char* method) {
  const std::string node = ros::this_node::getName();
  const auto answer = call(ros::master::getHost(), ros::master::getPort(), method, {Value(node), Value(node)});
  if (answer) return *answer;
  throw ConfigException("ROS master " + ros::master::getURI() + " does not answer for the parameters below " + node);
}

}  // namespace

config::Overrides nodeParameters(int argc, char** argv, const char* node) {
  const bool is_asked_for = speaksOfRos(argc, argv);  // of argv, before ros::init takes it out
  initNode(argc, argv, node);
  if (masterPid() == 0) {
    if (is_asked_for)
      std::fprintf(stderr, "no ROS master at %s: no parameter overrides the configuration\n",
                   ros::master::getURI().c_str());
    return {};
  }
  Value has_some = ask("hasParam");
  if (has_some.getType() != Value::TypeBoolean || !static_cast<bool>(has_some)) return {};
  config::Overrides overrides = parameterOverrides(ask("getParam"), ros::this_node::getName());
  for (const config::Override& each : overrides)
    std::fprintf(stderr, "%s overrides %s: %s\n", each.source.c_str(), each.key.c_str(), each.value.c_str());
  return overrides;
}

void checkParameters(const config::Overrides& overrides, bool enable_remote_control) {
  if (overrides.empty() || mayCommand(enable_remote_control)) return;
  throw ConfigException(overrides.front().source +
                        " on a node that is open to a network (ROS_IP, ROS_HOSTNAME): parameters override the "
                        "configuration there only with enable_remote_control: true in its file runtime");
}

}  // namespace raven2_trainer::ros_bridge
