#pragma once

#include <string>
#include <vector>

#include "raven2_trainer/config/load_training.h"
#include "raven2_trainer/config/overrides.h"
#include "raven2_trainer/config/trainer_config.h"

namespace raven2_trainer::config {

/**
 * Reads the root file (config/trainer.yaml) and every file it names, relative to its folder.
 * @param[in] instead names that replace those of the file; an empty one does not.
 * @throw ConfigException with FILE:LINE for a missing file, a missing or unknown key, a value that is not of its type
 * or out of its range, or a hazard that is not in the library.
 * @param[in] overrides values in the place of the files', held to the same; messages name their source. Files that they
 * change are in TrainerConfig::overridden as they were read. @throw ConfigException as checkOverrides, too.
 */
TrainerConfig loadTrainerConfig(const std::string& path,
                                const TrainingNames& instead = {},
                                const Overrides& overrides = {});

/** The overlays of these names, or {"all"} of them, or {"none"}. @throw ConfigException listing the known names. */
OverlaySet overlaysOf(const std::vector<std::string>& names);

/** The arms' geometry with another tool. @throw ConfigException listing the known names. */
ArmGeometry toolGeometry(const ArmsConfig& arms, const std::string& name);

/** Replaces the virtual Raven's plant: a name of config/plants, or the path of a file ending in .yaml.
 *  @throw ConfigException. */
void selectPlant(TrainerConfig* config, const std::string& name);

/** Position + 1 of a scenario by name; 0 for "none". @throw ConfigException listing the known names. */
std::uint32_t faultId(const TrainerConfig& config, const std::string& name);

/** @throw ConfigException if config.hazard is not in the library, or may not be armed. */
void checkHazard(const TrainerConfig& config);

}  // namespace raven2_trainer::config
