#include "ros/node/registration.h"

#include <ros/connection_manager.h>
#include <ros/master.h>
#include <ros/names.h>
#include <ros/network.h>
#include <ros/this_node.h>
#include <ros/xmlrpc_manager.h>
#include <xmlrpcpp/XmlRpcException.h>

#include "ros/node/xmlrpc_call.h"

namespace raven2_trainer::ros_bridge {
namespace {

using Value = XmlRpc::XmlRpcValue;

/** Every call of the master begins with the caller's name. */
std::optional<Value> callMaster(const std::string& method,
                                std::vector<Value> arguments = {},
                                double patience = kPatience) {
  arguments.insert(arguments.begin(), Value(ros::this_node::getName()));
  return call(ros::master::getHost(), ros::master::getPort(), method, arguments, patience);
}

/** Our own slave API: the public way to roscpp's lists. */
std::optional<Value> callSelf(const std::string& method, std::vector<Value> arguments = {}) {
  arguments.insert(arguments.begin(), Value(ros::this_node::getName()));
  return call("127.0.0.1", ros::XMLRPCManager::instance()->getServerPort(), method, arguments);
}

Value ownUri() {
  return ros::XMLRPCManager::instance()->getServerURI();
}

/** @return where the master says that this node is; empty if it does not know it. */
std::string lookedUp() {
  const std::optional<Value> uri = callMaster("lookupNode", {Value(ros::this_node::getName())});
  return uri && uri->getType() == Value::TypeString ? std::string(Value(*uri)) : std::string();
}

bool registerTopics() {
  std::optional<Value> topics = callSelf("getPublications");
  bool good = topics.has_value();
  for (int i = 0; good && i < topics->size(); ++i)
    good = callMaster("registerPublisher", {(*topics)[i][0], (*topics)[i][1], ownUri()}).has_value();
  return good;
}

/** The master answers with the list of publishers. We pass it on to ourselves, as the master does for later publishers.
 * An empty list is not
 *  passed on: a publisher that did not register again still sends over the existing connection. */
bool registerSubscription(const Value& topic, const Value& type) {
  const std::optional<Value> publishers = callMaster("registerSubscriber", {topic, type, ownUri()});
  if (!publishers) return false;
  if (publishers->getType() == Value::TypeArray && publishers->size() > 0)
    callSelf("publisherUpdate", {topic, *publishers});
  return true;
}

bool registerSubscriptions() {
  std::optional<Value> topics = callSelf("getSubscriptions");
  bool good = topics.has_value();
  for (int i = 0; good && i < topics->size(); ++i)
    good = registerSubscription((*topics)[i][0], (*topics)[i][1]);
  return good;
}

bool registerServices(std::vector<std::string> services) {
  for (const char* own : {"~get_loggers", "~set_logger_level"})  // roscpp's, of every node
    services.push_back(ros::names::resolve(own));
  const std::string api =
      "rosrpc://" + ros::network::getHost() + ":" + std::to_string(ros::ConnectionManager::instance()->getTCPPort());
  bool good = true;
  for (const std::string& service : services)
    good = good && callMaster("registerService", {Value(service), Value(api), ownUri()}).has_value();
  return good;
}

}  // namespace

int masterPid(double patience) {
  const std::optional<Value> pid = callMaster("getPid", {}, patience);
  return pid && pid->getType() == Value::TypeInt ? static_cast<int>(Value(*pid)) : 0;
}

/** A master that does not know the node says no to lookupNode, which is no answer of call(): so it is asked whether it
 * still answers. */
std::optional<bool> isRegistered() {
  const std::string uri = lookedUp();
  if (uri == std::string(ownUri())) return true;
  if (uri.empty() && masterPid() == 0) return {};
  return false;
}

std::string rival() {
  const std::string uri = lookedUp();
  std::string host;
  std::uint32_t port = 0;
  if (uri.empty() || uri == std::string(ownUri()) || !ros::network::splitURI(uri, host, port)) return "";
  return call(host, port, "getPid", {Value(ros::this_node::getName())}) ? uri : "";
}

bool registerAll(const std::vector<std::string>& services) {
  try {
    return registerTopics() && registerSubscriptions() && registerServices(services);
  } catch (const XmlRpc::XmlRpcException&) {  // an answer of another shape
    return false;
  }
}

}  // namespace raven2_trainer::ros_bridge
