#pragma once

#include <string>
#include <vector>

namespace raven2_trainer::model {

/** Path of a mesh as a URDF names it: `package://raven2_trainer/...` is beside the URDF's folder, anything else is
 *  relative to the file, but for `file://`. */
std::string meshPath(const std::string& urdf, const std::string& name);

/** The existing files that a URDF refers to, in its order, each once. Empty if it cannot be read. */
std::vector<std::string> meshFiles(const std::string& urdf);

}  // namespace raven2_trainer::model
