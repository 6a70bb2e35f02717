#pragma once

namespace raven2_trainer::apps {

/** Blocks SIGINT and SIGTERM in this thread and all later ones, and ignores SIGPIPE: call first in main. */
void blockSignals();

/** Waits at most `seconds` for SIGINT or SIGTERM. @return true if one came. */
bool waitForSignal(double seconds);

}  // namespace raven2_trainer::apps
