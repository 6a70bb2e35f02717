#pragma once

#include <xmlrpcpp/XmlRpcValue.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace raven2_trainer::ros_bridge {

/** [s] A master on the same computer answers in 1 to 5 ms; a slow one, on another computer or a busy one, within a
 * second. */
constexpr double kPatience = 3.0;

/**
 * One call of a ROS master or slave API. Gives up after `patience`, unlike roscpp's own, which waits for ever for a
 * peer that accepts and says nothing; at once where nobody listens. @return the payload; nothing if there was no answer
 * or it said no.
 */
std::optional<XmlRpc::XmlRpcValue> call(const std::string& host,
                                        std::uint32_t port,
                                        const std::string& method,
                                        const std::vector<XmlRpc::XmlRpcValue>& arguments,
                                        double patience = kPatience);  // [s]

/** A call of callAll(). Not "Request": that is the physics loop's, in the namespace around this one. */
struct MasterCall {
  std::string method;
  std::vector<XmlRpc::XmlRpcValue> arguments;
};

/**
 * Many calls in few messages, by system.multicall, which rosmaster offers (rosgraph/xmlrpc.py): one connection and one
 * answer for 50 calls. `patience` is for each message. @return the payloads in order; nothing if a call had no answer
 * or the peer said no.
 */
std::optional<std::vector<XmlRpc::XmlRpcValue>> callAll(const std::string& host,
                                                        std::uint32_t port,
                                                        const std::vector<MasterCall>& requests,
                                                        double patience = kPatience);  // [s]

}  // namespace raven2_trainer::ros_bridge
