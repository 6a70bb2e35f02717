#pragma once

#include <functional>

#include "raven2_trainer/session/session_directory.h"

namespace raven2_trainer::recording {

/**
 * Recovers the log of a session whose process was killed and writes the metrics, the faults and, with an exercise, the
 * score that the process did not come to; one line on stderr says what was done. Does nothing, silently, to a session
 * that ended well. Reads the whole log; not for real-time threads. Reports errors on stderr, throws nothing.
 * @param cancelled asked now and then; metrics are given up once it says true. May be empty.
 * @return false if the session needed it and could not be recovered.
 */
bool recoverAndReport(const session::SessionPaths& paths, const std::function<bool()>& cancelled);

}  // namespace raven2_trainer::recording
