#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "raven2_trainer/core/record.h"

// The session log, session.rlog: append-only, the record of truth. Each record: magic, type, version, payload
// length, record number, payload, CRC-32. The first record is a JSON description of every record's fields, so that
// a reader in any language needs nothing else (scripts/raven2_session.py is one). Records are written field by
// field, so the bytes depend on the values only. Format: doc/session.md.

namespace raven2_trainer::session {

/** A copy of a file that the session was configured by. */
struct ConfigurationFile {
  std::string path;   ///< below the session's directory
  std::string fnv1a;  ///< of its bytes, hex
};

/** The surgeon's hand on the master, as configured. */
struct HeaderHand {
  double mass{};       ///< [kg]
  double stiffness{};  ///< [N/m]
  double damping{};    ///< [Ns/m]
};

/** The lens through which the surgeon looks. */
struct HeaderCamera {
  std::string name;
  double vertical_fov{};  ///< [rad]
  double aspect{};        ///< [-] width / height of the picture
};

/** What one open log holds besides ticks. */
struct LogHeader {
  std::uint64_t seed{};
  std::vector<std::string> scenarios;                                        ///< names; Fault::id is the position + 1
  std::string hazard;                                                        ///< armed at the start, or "none"
  std::string robot_urdf_hash, scene_urdf_hash, config_hash;                 ///< FNV-1a, hex
  std::string exercise{"none"}, drill{"none"}, trainee, curriculum{"none"};  ///< as in trainer.yaml
  double motion_scale{};                                                     ///< [-] of the master, as configured
  HeaderHand hand{};
  HeaderCamera camera{};
  std::vector<std::vector<std::string>> step_names;  ///< of the exercise, by ExerciseEvent::track and ::step
  std::vector<std::string> object_names;             ///< of its scene, in the order of SceneRoles::objects
  std::string motion;                                ///< as the console was started (console/make_motion.h); "" unknown
  double d4{};                                       ///< [m] for conversions of joint coordinates
  double tolerance{};                                ///< [m] of the haptic cue
  int model_version{1};                              ///< kModelVersion of the program that recorded
  PerArm<bool> arm_contacts{};                       ///< the model's arm meets the scene, at the start
  std::vector<std::string> body_names;               ///< by the numbers of contact records
  std::vector<ConfigurationFile> configuration;      ///< copies next to the log, the root file first; empty: none
};

/** Where a log stands: all that is whole in the file. */
struct LogPosition {
  std::uint64_t size{};         ///< [bytes]
  std::uint64_t next_number{};  ///< of the record that comes next
};

/**
 * Writes one log. write() collects a batch, commit() puts it into the file in one piece: after a kill the file holds
 * whole batches and at most a part of one. Not for real-time threads. While it lives other processes cannot recover
 * the log. @throw SessionException on a file that cannot be opened or written, from the constructors and finish(), and
 * from write() for a batch beyond 16 MiB.
 */
class LogWriter {
 public:
  /** A new log, its header written. */
  LogWriter(const std::string& path, const LogHeader& header);
  /** Goes on behind `position` of an existing log; what stands behind it is cut off. */
  LogWriter(const std::string& path, const LogPosition& position);
  /** Commits. */
  ~LogWriter();
  LogWriter(const LogWriter&) = delete;
  LogWriter& operator=(const LogWriter&) = delete;

  template <typename T>
  void write(const T& record);
  /** Takes memory for a batch of so many bytes now, every page of it touched: none so large takes more later. */
  void reserve(std::size_t bytes);
  /**
   * Writes the batch. @return false if the disk refuses: then nothing of it is in the file, it is forgotten, and
   * error() says why. The next commit() tries the disk again.
   */
  bool commit() noexcept;
  /** Forces what was committed to the disk; may take long. @return false with error() set. */
  bool sync() noexcept;
  /** What was committed. */
  LogPosition position() const noexcept;
  /** errno of the last refusal; 0 none. */
  int error() const noexcept;
  /** The batch, and the counters as last record, into room kept free for them. A log without it ended uncleanly. */
  void finish(const SessionCounts& counts);
  /** The same, for a log whose writer was killed. */
  void finishRecovery(const RecoveryRecord& recovery);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/** Calls for each record in file order; leave out what you do not need. */
struct LogVisitor {
  std::function<void(const TickRecord&)> tick;
  std::function<void(const HapticRecord&)> haptic;
  std::function<void(const CommandRecord&)> command;
  std::function<void(const RequestRecord&)> request;
  std::function<void(const PlanRecord&)> plan;
  std::function<void(const FaultRecord&)> faults;
  std::function<void(const FaultChangeRecord&)> fault_change;
  std::function<void(const ExecutionRecord&)> execution;
  std::function<void(const ExerciseRecord&)> exercise;
  std::function<void(const ContactRecord&)> contact;
  std::function<void(const GapRecord&)> gap;
  std::function<void(const SessionCounts&)> counts;
  std::function<void(const RecoveryRecord&)> recovery;
  std::function<void(std::uint64_t bytes)> position;  ///< of the file read so far, after each record
};

struct LogSummary {
  LogHeader header;
  std::uint64_t records{};          ///< intact ones behind the header
  bool clean{};                     ///< the footer was found
  bool recovered{};                 ///< the writer was killed, and the log completed afterwards
  std::uint64_t bad_bytes{};        ///< skipped because a CRC, a length or a value was wrong
  std::uint64_t truncated_bytes{};  ///< of a last record that was cut short
};

/**
 * Reads a log from the start, one record at a time. A bad record is skipped by searching the next magic.
 * @throw SessionException if the file is missing or does not start with a readable header.
 */
LogSummary readLog(const std::string& path, const LogVisitor& visitor);

/** The ticks of a log alone, one at a time as they are asked for; else as readLog(). */
class TickReader {
 public:
  /** @throw SessionException as readLog(). */
  explicit TickReader(const std::string& path);
  ~TickReader();
  TickReader(const TickReader&) = delete;
  TickReader& operator=(const TickReader&) = delete;

  const LogHeader& header() const noexcept;
  /** @return false at the end of the file. @throw SessionException if it cannot be read. */
  bool next(TickRecord* record);
  /** [bytes] of the file read so far. */
  std::uint64_t position() const noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/** The first record alone. @throw SessionException as readLog(). */
LogHeader readLogHeader(const std::string& path);

}  // namespace raven2_trainer::session
