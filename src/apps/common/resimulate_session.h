#pragma once

#include <string>

namespace raven2_trainer::apps {

/**
 * Simulates a session again from its log, compares each tick bit for bit, and prints the result: `resimulate DIR` and
 * `simulate --from-log DIR`.
 * @param[in] output directory for the new session; empty: writes no session.
 * @return the exit code: 0 equal, 1 different.
 * @throw SessionException if it cannot be simulated again.
 */
int resimulateSession(const std::string& directory, const std::string& output);

}  // namespace raven2_trainer::apps
