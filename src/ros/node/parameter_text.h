#pragma once

#include <xmlrpcpp/XmlRpcValue.h>

#include <string>

#include "raven2_trainer/config/overrides.h"

namespace raven2_trainer::ros_bridge {

/** A parameter as YAML in one line. A text that begins with [ is YAML already: roscpp makes a text of a list that is
 * given as an argument. @throw ConfigException, beginning with `source`, for a date or raw bytes. */
std::string parameterText(const XmlRpc::XmlRpcValue& value, const std::string& source);

/** One override for each parameter below `node` ("/raven2_simulator"), by its path there.
 * @param[in] tree what the master holds under that name. @throw ConfigException as above, or if that is no tree. */
config::Overrides parameterOverrides(const XmlRpc::XmlRpcValue& tree, const std::string& node);

}  // namespace raven2_trainer::ros_bridge
