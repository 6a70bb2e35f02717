#pragma once

#include <string>

namespace raven2_trainer::apps {

/**
 * Simulates a session again from its log, compares every tick, bit for bit, and prints what came of it: `resimulate
 * DIR` and `simulate --from-log DIR`.
 * @param[in] output directory of the session that the re-simulation becomes; empty: none.
 * @return the exit code: 0 equal, 1 different.
 * @throw SessionException if it cannot be simulated again.
 */
int resimulateSession(const std::string& directory, const std::string& output);

}  // namespace raven2_trainer::apps
