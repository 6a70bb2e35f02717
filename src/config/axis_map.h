#pragma once

#include <string>

#include "raven2_trainer/config/section.h"
#include "raven2_trainer/core/axis_map.h"

namespace raven2_trainer::config {

/** ITP's axes `forward`, `right`, `down` in those of a device or a console. @throw ConfigException with FILE:LINE. */
AxisMap readAxes(Section& root, const std::string& key, bool may_mirror);

}  // namespace raven2_trainer::config
