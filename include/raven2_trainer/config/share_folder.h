#pragma once

#include <string>

namespace raven2_trainer::config {

/**
 * Folder with the package's config/, urdf/ and meshes/: $RAVEN2_TRAINER_SHARE if set; else share/raven2_trainer next to
 * the program's lib folder (installed); else the source tree it was built from (devel space).
 * @throw ConfigException if none of them has a config/trainer.yaml.
 */
std::string shareFolder();

/** A file next to a configuration; absolute paths. */
struct Neighbour {
  std::string path;   ///< that is read
  std::string place;  ///< its place if the configuration had its own; mostly the same
};

/**
 * A file that a configuration names relative to `folder`. Where it is not there and leads out of the configuration
 * (../urdf/...), the package's: a copied config/ needs no copy of urdf/ and meshes/ next to it.
 * @param[in] packaged What `folder` is in the package: config, config/scenes.
 * @return the place itself if the package has no such file either.
 */
Neighbour neighbour(const std::string& folder, const std::string& file, const std::string& packaged);

}  // namespace raven2_trainer::config
