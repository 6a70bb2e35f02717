#pragma once

#include "raven2_trainer/detector/anomaly_detector.h"
#include "raven2_trainer/kinematics/arms_config.h"
#include "raven2_trainer/raven/virtual_raven_config.h"

namespace raven2_trainer::raven {

/** The control software's parameters of its drives, for the detector. @throw ConfigException as CableCoupling. */
detector::Drives drivesOf(const ArmsConfig& arms, const VirtualRavenConfig& config);

}  // namespace raven2_trainer::raven
