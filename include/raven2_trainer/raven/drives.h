#pragma once

#include "raven2_trainer/core/arms_config.h"
#include "raven2_trainer/core/virtual_raven_config.h"
#include "raven2_trainer/detector/anomaly_detector.h"

namespace raven2_trainer::raven {

/** What the control software knows of its drives, for the detector. @throw ConfigException as CableCoupling. */
detector::Drives drivesOf(const ArmsConfig& arms, const VirtualRavenConfig& config);

}  // namespace raven2_trainer::raven
