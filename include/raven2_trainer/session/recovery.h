#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "raven2_trainer/core/record.h"
#include "raven2_trainer/session/session_directory.h"

namespace raven2_trainer::session {

enum class RecoveryStatus : std::uint8_t {
  kNothingToDo,  ///< the log ended cleanly, or was recovered before
  kRunning,      ///< a process writes the log, or another recovery works on it
  kRecovered,    ///< the log is complete and ends with a recovery record
  kNoLog,        ///< the process was killed before the first record: nothing to save
  kNotWritable,  ///< the log cannot be written; it is unchanged
  kCancelled,    ///< cancelled before anything was changed
};

struct Recovery {
  RecoveryStatus status{};
  RecordTally recovered{};      ///< records taken from the flight recorder, by kind
  RecordTally lost{};           ///< records that a gap record at the log's end reports as lost, by kind
  std::uint64_t cut_bytes{};    ///< cut off the end of the log
  std::string flight_recorder;  ///< "used", or why not
};

/** Whether the directory contains a log that did not end cleanly and was not recovered. Reads the log's last 8 KiB. */
bool isUnclean(const SessionPaths& paths);

/** Whether a running process writes or recovers the log. */
bool isBeingWritten(const SessionPaths& paths);

/** Whether the log ended cleanly or was recovered, and no process writes it, but its metrics are missing. */
bool lacksMetrics(const SessionPaths& paths);

/** Whether the log is complete, but its flight recorder's file still exists: a recovery was killed before removing it.
 */
bool leavesFlightFile(const SessionPaths& paths);

/**
 * Completes the log of a killed process: cuts off an incomplete record, appends the flight recorder's remaining
 * records and a recovery record, writes recovered.json and removes the flight recorder's file. A killed recovery can be
 * repeated. A log that ended cleanly or is being written stays unchanged.
 * Reads the whole log if there is no flight recorder. @throw SessionException for a log that cannot be read.
 * @param cancelled polled while the log is read; may be empty.
 */
Recovery recoverSession(const SessionPaths& paths, const std::function<bool()>& cancelled = {});

/** Session directories directly below `parent` that are unclean or lack metrics and that no process writes, newest
 * first, at most `limit`. Reads the last 8 KiB of every log there. */
std::vector<std::string> findUnfinishedSessions(const std::string& parent, std::size_t limit);

}  // namespace raven2_trainer::session
