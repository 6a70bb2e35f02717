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

/** A node has some 300 topics and services: few messages with many calls, or single calls if the master knows no such
 * messages. @return the payloads; nothing if a call failed. */
std::optional<std::vector<Value>> askMaster(std::vector<MasterCall> requests) {
  for (MasterCall& request : requests)
    request.arguments.insert(request.arguments.begin(), Value(ros::this_node::getName()));
  std::optional<std::vector<Value>> all = callAll(ros::master::getHost(), ros::master::getPort(), requests);
  if (all) return all;
  std::vector<Value> payloads;
  for (const MasterCall& request : requests) {
    const std::optional<Value> one =
        call(ros::master::getHost(), ros::master::getPort(), request.method, request.arguments);
    if (!one) return {};
    payloads.push_back(*one);
  }
  return payloads;
}

/** @return a request for each topic of a list of [topic, type]. */
std::vector<MasterCall> requestsFor(Value& topics, const std::string& method) {
  std::vector<MasterCall> requests;
  for (int i = 0; i < topics.size(); ++i)
    requests.push_back({method, {topics[i][0], topics[i][1], ownUri()}});
  return requests;
}

bool registerTopics() {
  std::optional<Value> topics = callSelf("getPublications");
  return topics && askMaster(requestsFor(*topics, "registerPublisher")).has_value();
}

/** The master answers each registration with the list of publishers. We pass it on to ourselves, as the master does for
 * later publishers. An empty list is not passed on: a publisher that did not register again still sends over the
 * existing connection. */
bool registerSubscriptions() {
  std::optional<Value> topics = callSelf("getSubscriptions");
  if (!topics) return false;
  const std::vector<MasterCall> requests = requestsFor(*topics, "registerSubscriber");
  std::optional<std::vector<Value>> publishers = askMaster(requests);
  for (std::size_t i = 0; publishers && i < publishers->size(); ++i) {
    if ((*publishers)[i].getType() == Value::TypeArray && (*publishers)[i].size() > 0)
      callSelf("publisherUpdate", {requests[i].arguments[0], (*publishers)[i]});
  }
  return publishers.has_value();
}

bool registerServices(std::vector<std::string> services) {
  for (const char* own : {"~get_loggers", "~set_logger_level"})  // roscpp's, of every node
    services.push_back(ros::names::resolve(own));
  const std::string api =
      "rosrpc://" + ros::network::getHost() + ":" + std::to_string(ros::ConnectionManager::instance()->getTCPPort());
  std::vector<MasterCall> requests;
  for (const std::string& service : services)
    requests.push_back({"registerService", {Value(service), Value(api), ownUri()}});
  return askMaster(requests).has_value();
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

std::set<std::string> publishersOf(const std::set<std::string>& topics) {
  std::set<std::string> found;
  std::optional<Value> connections = callSelf("getBusInfo");  // each: number, address, direction, transport, topic, ...
  for (int k = 0; connections && k < connections->size(); ++k) {
    Value& one = (*connections)[k];
    const bool is_received = std::string(one[2]) == "i" && topics.count(std::string(one[4])) > 0;
    if (is_received) found.insert(std::string(one[1]));
  }
  return found;
}

bool registerAll(const std::vector<std::string>& services) {
  try {
    return registerTopics() && registerSubscriptions() && registerServices(services);
  } catch (const XmlRpc::XmlRpcException&) {  // an answer of another shape
    return false;
  }
}

}  // namespace raven2_trainer::ros_bridge
