#pragma once

#include <memory>
#include <string>

#include "raven2_trainer/console/console.h"
#include "raven2_trainer/core/config.h"
#include "raven2_trainer/session/session_directory.h"

namespace raven2_trainer::runtime {

/** Motion of the console by its name: "scripted" or "recording:FILE". @throw ConfigException for anything else. */
std::unique_ptr<console::MotionSource> makeMotion(const TrainerConfig& config, const std::string& motion);

/** meta.json's start: program, version, motion, and the wall clock's time now. */
session::SessionMeta startMeta(const std::string& program, const std::string& version, const std::string& motion);

}  // namespace raven2_trainer::runtime
