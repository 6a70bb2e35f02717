#pragma once

#include <optional>
#include <set>
#include <string>
#include <vector>

#include "ros/node/xmlrpc_call.h"

namespace raven2_trainer::ros_bridge {

/** This node, as the master and its slave API see it, by calls that give up. After ros::init(). */

/** Process id of the master; 0 if none answers. @param[in] patience [s] for its answer. */
int masterPid(double patience = kPatience);

/** Does the master know this node at its address? Nothing if it gave no answer. */
std::optional<bool> isRegistered();

/** URI of another living node with this node's name; empty without one. */
std::string rival();

/** XML-RPC addresses of the nodes from which this node receives these topics (resolved names). */
std::set<std::string> publishersOf(const std::set<std::string>& topics);

/** Registers all topics and subscriptions of this node, and `services`, with the master. @return false if a call got no
 * answer.
 */
bool registerAll(const std::vector<std::string>& services);

}  // namespace raven2_trainer::ros_bridge
