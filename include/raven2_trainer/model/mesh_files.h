#pragma once

#include <string>
#include <vector>

namespace raven2_trainer::model {

/** How a URDF names what lies in this package. */
inline const std::string kPackage = "package://raven2_trainer/";

/** The folder that the meshes of a URDF may not leave: above a folder urdf/, else the file's own. */
std::string modelFolder(const std::string& urdf);

/** Path of a mesh as a URDF names it: `package://raven2_trainer/...` is in modelFolder(), anything else is relative to
 *  the file. */
std::string meshPath(const std::string& urdf, const std::string& name);

/** The existing files that a URDF refers to, in its order, each once. Empty if it cannot be read. */
std::vector<std::string> meshFiles(const std::string& urdf);

}  // namespace raven2_trainer::model
