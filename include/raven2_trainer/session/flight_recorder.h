#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "raven2_trainer/core/record_rings.h"
#include "raven2_trainer/session/session_directory.h"
#include "raven2_trainer/session/session_log.h"

namespace raven2_trainer::session {

struct FlightFile;

/** The part that is complete in the log: each queue's elements below `heads`, in the log's first `log.size` bytes. */
struct FlightCheckpoint {
  LogPosition log{};
  RecordTally heads{};    ///< number of the first element that is not in the log, by RecordKind
  RecordTally dropped{};  ///< lost records that a gap record in the log reports, by RecordKind
};

/**
 * The record queues in a tmpfs file, mapped and locked. Pushed records survive a SIGKILL of the process, and the loops
 * need no system call and have no page fault. (On a disk, the write-back of a page would stall the loop that writes to
 * the page.) Before attach() nothing finds the file. If it cannot be created, the queues are in plain
 * memory.
 *
 *   file: head, two checkpoints written alternately, a JSON description of the rest, the queues
 *
 * The checkpoints connect the queues with the log, so a recovery neither misses nor repeats a record, whenever the
 * process was killed. It cuts the log to the newer complete checkpoint and appends the queues' later records.
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
  /** Whether records in the queues survive the process. */
  bool outlives() const noexcept { return !link_.empty(); }
  /** Links the file from the session's directory, whose log exists; before the loops start. */
  void attach(const SessionPaths& paths);
  /** Call after the log has accepted a batch and before the queues free its space; recorder thread only. */
  void checkpoint(const FlightCheckpoint& checkpoint) noexcept;
  /** The log could not be finished: leaves the file for a recovery. */
  void keep() noexcept { keep_ = true; }
  /** The log is complete: removes the file. The queues stay usable. */
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
