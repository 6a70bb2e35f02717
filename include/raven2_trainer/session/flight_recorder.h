#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "raven2_trainer/core/record_rings.h"
#include "raven2_trainer/session/session_directory.h"
#include "raven2_trainer/session/session_log.h"

namespace raven2_trainer::session {

struct FlightFile;

/** What is safe in the log: the elements below `heads` of each queue, in its first `log.size` bytes. */
struct FlightCheckpoint {
  LogPosition log{};
  RecordTally heads{};    ///< number of the first element that is not in the log, by RecordKind
  RecordTally dropped{};  ///< records lost that a gap record in the log tells of, by RecordKind
};

/**
 * The record queues in a file of a tmpfs, mapped and locked: what the loops have pushed survives a SIGKILL of the
 * process, without a system call or page fault of theirs. (On a disk a page being written back would stall the loop
 * that writes to it.) Until it is attached to a session, and where no such file can be had, it is plain memory.
 *
 *   file: head, two checkpoints written in turn, a description of the rest in JSON, the queues
 *
 * The checkpoints tie the queues to the log, so that a recovery neither misses nor doubles a record wherever the
 * process was killed: it cuts the log to the newer whole checkpoint and appends what the queues hold from there on.
 */
class FlightRecorder {
 public:
  /** @param folder on a tmpfs, e.g. /dev/shm; "none": plain memory. Does not throw: see description(). */
  explicit FlightRecorder(const std::string& folder);
  /** Removes the file, unless keep() or remove() was called. */
  ~FlightRecorder();
  FlightRecorder(const FlightRecorder&) = delete;
  FlightRecorder& operator=(const FlightRecorder&) = delete;

  RecordRings* rings() noexcept;
  /** Links the file from the session's directory, whose log exists; before the loops start. */
  void attach(const SessionPaths& paths);
  /** After the log has taken a batch, before the queues give back its room. The recorder's thread. */
  void checkpoint(const FlightCheckpoint& checkpoint) noexcept;
  /** The log could not be finished: leaves the file for a recovery. */
  void keep() noexcept { keep_ = true; }
  /** The log is whole: removes the file, however the process ends from here on. The queues stay usable. */
  void remove() noexcept;
  /** Path of the file, or "none: REASON". */
  const std::string& description() const noexcept { return description_; }

 private:
  bool map(const std::string& folder);
  bool giveUp(const std::string& reason);

  FlightFile* file_{nullptr};  ///< mapped; null without one
  std::unique_ptr<RecordRings> memory_;
  std::string path_, link_, description_;
  std::uint64_t sequence_{0};
  bool keep_{false};
};

}  // namespace raven2_trainer::session
