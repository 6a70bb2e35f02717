#include "ros/crtk/crtk_age.h"

#include <ros/master.h>
#include <ros/this_node.h>
#include <xmlrpcpp/XmlRpcException.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "ros/node/name_of.h"
#include "ros/node/seconds_between.h"

namespace raven2_trainer::ros_bridge {
namespace {

// [s] Below what a person takes for "now", above what a network that stutters adds; an arm at the default max_speed
// goes 5 cm meanwhile. Ours.
constexpr double kOldest = 0.5;

std::string valueOf(const ros::M_string& header, const std::string& key) {
  const auto found = header.find(key);
  return found == header.end() ? "" : found->second;
}

CrtkAsked refuse(const ServoCommand& command, const std::string& why) {
  return {std::nullopt, std::string(nameOf(kServoKindNames, command.kind)) + ": " + why};
}

}  // namespace

std::optional<CrtkPublishers> publishersNow() {
  XmlRpc::XmlRpcValue caller, response, state;
  caller[0] = ros::this_node::getName();
  if (!ros::master::execute("getSystemState", caller, response, state, /*wait_for_master=*/false)) return {};
  return publishersIn(state);
}

/** [publishers, subscribers, services], each a list of [topic, [node, ...]]. */
std::optional<CrtkPublishers> publishersIn(XmlRpc::XmlRpcValue state) {
  CrtkPublishers publishers;
  try {
    XmlRpc::XmlRpcValue& topics = state[0];
    for (int i = 0; i < topics.size(); ++i) {
      XmlRpc::XmlRpcValue& nodes = topics[i][1];
      for (int j = 0; j < nodes.size(); ++j)
        publishers[static_cast<std::string&>(topics[i][0])].insert(static_cast<std::string&>(nodes[j]));
    }
  } catch (const XmlRpc::XmlRpcException&) {
    return {};
  }
  return publishers;
}

CrtkStorage CrtkStored::storageOf(const ros::M_stringPtr& connection, const ros::Time& stamp) {
  if (!connection || valueOf(*connection, "latching") != "1") return CrtkStorage::kNew;
  const std::string publisher = valueOf(*connection, "callerid");
  Latching& known = latching_[publisher];
  const bool is_new = !known.connection, is_first = known.connection != connection;
  const bool is_repeated = !stamp.isZero() && stamp <= known.newest;
  known = {connection, std::max(known.newest, stamp)};
  if (!is_first || (is_new && !wasBefore(publisher))) return CrtkStorage::kNew;
  return is_repeated ? CrtkStorage::kStored : CrtkStorage::kUnknown;
}

bool isSafer(const ServoCommand& command) noexcept {
  switch (command.kind) {
    case ServoKind::kHold:
    case ServoKind::kFree:
      return true;
    case ServoKind::kState:
      return command.state == StateCommand::kPause || command.state == StateCommand::kDisable;
    default:
      return false;
  }
}

CrtkAsked unlessOld(const CrtkAsked& asked, const CrtkOrigin& origin) {
  if (!asked.command || isSafer(*asked.command)) return asked;
  const double age = origin.stamp.isZero() ? 0.0 : secondsBetween(origin.stamp, origin.now);
  const bool is_fresh = !origin.stamp.isZero() && std::abs(age) <= kOldest;
  if (origin.storage == CrtkStorage::kStored || (origin.storage == CrtkStorage::kUnknown && !is_fresh))
    return refuse(*asked.command, origin.publisher + " latches its topic, so the message may be old; send it again");
  if (age <= kOldest) return asked;
  char text[128];
  std::snprintf(text, sizeof text, "stamped %.4g s ago, at most %.4g s; clocks must agree, or leave the stamp out", age,
                kOldest);
  return refuse(*asked.command, text);
}

}  // namespace raven2_trainer::ros_bridge
