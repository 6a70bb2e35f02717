#pragma once

#include <string>

#include "raven2_trainer/session/session_directory.h"

namespace raven2_trainer::recording {

/** meta.json's start: program, version, motion, and the wall clock's time now. */
session::SessionMeta startMeta(const std::string& program, const std::string& version, const std::string& motion);

}  // namespace raven2_trainer::recording
