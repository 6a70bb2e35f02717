#pragma once

#include <xmlrpcpp/XmlRpcValue.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace raven2_trainer::ros_bridge {

/**
 * One call of a ROS master or slave API. Gives up after 0.25 s, unlike roscpp's own, which waits for ever for a peer
 * that accepts and says nothing. @return the payload; nothing if there was no answer or it said no.
 */
std::optional<XmlRpc::XmlRpcValue> call(const std::string& host,
                                        std::uint32_t port,
                                        const std::string& method,
                                        const std::vector<XmlRpc::XmlRpcValue>& arguments);

}  // namespace raven2_trainer::ros_bridge
