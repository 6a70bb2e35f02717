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
  kRunning,      ///< its writer lives, or another recovery is at it
  kRecovered,    ///< the log is complete and ends with a recovery record
  kNoLog,        ///< killed before its first record: nothing to save
  kNotWritable,  ///< the log cannot be written; left as it is
  kCancelled,    ///< given up before anything was changed
};

struct Recovery {
  RecoveryStatus status{};
  RecordTally recovered{};      ///< records taken from the flight recorder, by kind
  RecordTally lost{};           ///< records that a gap record at the end tells of, by kind
  std::uint64_t cut_bytes{};    ///< cut off the end of the log
  std::string flight_recorder;  ///< "used", or why not
};

/** Whether the directory holds a log that did not end cleanly and was not recovered. Reads the log's last 8 KiB. */
bool isUnclean(const SessionPaths& paths);

/** Whether a living process writes the log, or recovers it. */
bool isBeingWritten(const SessionPaths& paths);

/** Whether the log was recovered by somebody who was stopped before the metrics were written, or had none to write. */
bool lacksMetrics(const SessionPaths& paths);

/** Whether the log has an end, but its flight recorder still exists: a recovery was killed before it removed the file. */
bool leavesFlightFile(const SessionPaths& paths);

/**
 * Completes the log of a killed process: cuts off what is half written, appends what the flight recorder still holds,
 * ends it with a recovery record, writes recovered.json, removes the flight recorder's file. May be killed itself and
 * begun again at any moment. Does nothing to a log that ended cleanly or is being written.
 * Reads the whole log if there is no flight recorder. @throw SessionException for a log that cannot be read.
 * @param cancelled asked now and then while it reads; may be empty.
 */
Recovery recoverSession(const SessionPaths& paths, const std::function<bool()>& cancelled = {});

/** Directories directly below `parent` of sessions that are unclean or lack their metrics and that nobody writes,
 * newest first, at most `limit`. Reads the last 8 KiB of every log there. */
std::vector<std::string> findUnfinishedSessions(const std::string& parent, std::size_t limit);

}  // namespace raven2_trainer::session
