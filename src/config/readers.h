#pragma once

#include "raven2_trainer/config/section.h"
#include "raven2_trainer/config/trainer_config.h"

// One reader for each file of config/ that the trainer's configuration is made of (config/load_config.h); ranges and
// conditions between keys are checked there. Its opener finds unknown keys of a file.

namespace raven2_trainer::config {

constexpr double kAny = 1e6;  ///< "[0, 1e6]" of the files: physical, not a typing error

/** @throw ConfigException, as of all below: FILE:LINE, the value and what was expected. */
void readArms(Section& root, ArmsConfig* c);
void readModel(Section& root, ModelConfig* c);
void readHaptics(Section& root, HapticGains* c);
/** @param[in] haptics How fast a force falls; it must have gone in time. */
void readNetwork(Section& root, const HapticGains& haptics, NetworkConfig* c);
void readRuntime(Section& root, RuntimeConfig* c);
void readPlanner(Section& root, PlannerConfig* c);
void readExecution(Section& root, ExecutionConfig* c);
void readCrtk(Section& root, CrtkConfig* c);
void readRender(Section& root, RenderConfig* c);
void readConsole(Section& root, ConsoleConfig* c);
/** The plant has its own file, which is read by its name. */
void readVirtualRaven(Section& root, VirtualRavenConfig* c);
void readPlant(Section& root, PlantConfig* c);
void readInjection(Section& root, InjectionConfig* c);
void readDetector(Section& root, DetectorConfig* c);

}  // namespace raven2_trainer::config
