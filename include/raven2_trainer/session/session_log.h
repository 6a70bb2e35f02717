#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "raven2_trainer/core/record.h"

// The session log, session.rlog, is append-only: the authoritative record of a session. Each record has magic, type,
// version, payload length, record number, payload and CRC-32. The first record describes every record's fields in JSON,
// so that a reader in any language needs only doc/session.md (example: scripts/raven2_session.py). Records are written
// field by field, so the bytes depend only on the values. A large batch is compressed to records of type `chunk`;
// readers give the records in it as if they were in the file.

namespace raven2_trainer::session {

/** A copy of one of the session's configuration files. */
struct ConfigurationFile {
  std::string path;   ///< relative to the session's directory
  std::string fnv1a;  ///< hash of its bytes, hex
};

/** The surgeon's hand on the master, as configured. */
struct HeaderHand {
  double mass{};       ///< [kg]
  double stiffness{};  ///< [N/m]
  double damping{};    ///< [Ns/m]
};

/** The lens of the surgeon's camera. */
struct HeaderCamera {
  std::string name;
  double vertical_fov{};  ///< [rad]
  double aspect{};        ///< [-] width / height of the picture
};

/** Contents of a log's header. */
struct LogHeader {
  std::uint64_t seed{};
  std::vector<std::string> scenarios;                                        ///< names; Fault::id is the position + 1
  std::string hazard;                                                        ///< armed at the start, or "none"
  std::string robot_urdf_hash, scene_urdf_hash, config_hash;                 ///< FNV-1a, hex
  std::string exercise{"none"}, drill{"none"}, trainee, curriculum{"none"};  ///< names; drill: the scenario's
  double motion_scale{};                                                     ///< [-] of the master, as configured
  HeaderHand hand{};
  HeaderCamera camera{};
  std::vector<std::vector<std::string>> step_names;  ///< of the exercise, by ExerciseEvent::track and ::step
  std::vector<std::string> object_names;             ///< of the exercise's scene, in the order of SceneRoles::objects
  std::string motion;                                ///< the console's motion (console/make_motion.h); "" if unknown
  double d4{};                                       ///< [m] ArmGeometry::d4, to convert joint coordinates
  double tolerance{};                                ///< [m] tip error above which the force cue acts
  int model_version{1};                              ///< kModelVersion of the program that recorded
  PerArm<bool> arm_contacts{};                       ///< setting at the start: the model's arm can touch the scene
  std::vector<std::string> body_names;               ///< indexed by the body numbers of contact records
  std::vector<ConfigurationFile> configuration;      ///< copied files, root file first; empty: no copies
};

/** Gains of a control law, each [Nm; N] per [rad; m]: of the error, its rate and its integral over time. */
struct ControlGains {
  JointArray kp{}, kd{}, ki{};
};

/**
 * Constants of the log's formulas (doc/session.md, Formulas). Good ones make a session of moving arms two fifths
 * smaller; with any others, the same records are read.
 */
struct TickConstants {
  double d4{}, lw{};  ///< [m] ArmGeometry
  PerArm<std::array<JointArray, kJointCount>>
      joint_of_motor{};          ///< rows of the matrix from the robot's motors to its joints
  PerArm<ControlGains> gains{};  ///< of the model's joints
};

/** Position after the last complete record of a log. */
struct LogPosition {
  std::uint64_t size{};         ///< [bytes]
  std::uint64_t next_number{};  ///< number of the next record
};

/**
 * Writes one log. write() adds a record to a batch. commit() appends the batch to the file (compressed from 32 KiB
 * on). A killed process leaves complete batches and at most one incomplete batch. Not for real-time
 * threads. While a LogWriter exists, other processes cannot recover the log. @throw SessionException if the file cannot
 * be opened or written: from the constructors and finish(), and from write(), which commits a batch over 16 MiB.
 */
class LogWriter {
 public:
  /** Creates a log and writes its header. @param[in] constants Empty: chunks without formulas. */
  LogWriter(const std::string& path,
            const LogHeader& header,
            const std::optional<TickConstants>& constants = std::nullopt);
  /** Truncates an existing log at `position` and continues it. */
  LogWriter(const std::string& path, const LogPosition& position);
  /** Commits the batch. */
  ~LogWriter();
  LogWriter(const LogWriter&) = delete;
  LogWriter& operator=(const LogWriter&) = delete;

  template <typename T>
  void write(const T& record);
  /** Allocates a batch of `bytes` and touches every page: write() then allocates nothing, commit() almost nothing. */
  void reserve(std::size_t bytes);
  /**
   * Appends the batch. @return false if the write fails: the file is unchanged, the batch is discarded, and error()
   * gives the reason. The next commit() tries the disk again.
   */
  bool commit() noexcept;
  /** Forces committed records to the disk; may take long. @return false with error() set. */
  bool sync() noexcept;
  /** Position after the last committed record. */
  LogPosition position() const noexcept;
  /** errno of the last failed write or sync(); 0: no failure. */
  int error() const noexcept;
  /** Writes the batch and the counters, which mark a clean end, into reserved disk space. */
  void finish(const SessionCounts& counts);
  /** As finish(), for a log whose writer was killed: `recovery` is the last record. */
  void finishRecovery(const RecoveryRecord& recovery);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/** Callbacks for the records, in file order; each may be empty. */
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
  std::function<void(std::uint64_t bytes)> position;  ///< after each record: bytes read so far
};

struct LogSummary {
  LogHeader header;
  std::uint64_t records{};          ///< intact records after the header
  bool clean{};                     ///< the log ends with the counters
  bool recovered{};                 ///< the writer was killed; a recovery completed the log
  std::uint64_t bad_bytes{};        ///< skipped because of a wrong CRC, length or value
  std::uint64_t truncated_bytes{};  ///< bytes of an incomplete last record
};

/**
 * Reads a log from the start, one record at a time. After a bad record it searches for the next magic.
 * @throw SessionException if the file is missing or does not start with a readable header.
 */
LogSummary readLog(const std::string& path, const LogVisitor& visitor);

/** Like readLog(), but reads only tick records, one per call of next(). */
class TickReader {
 public:
  /** @throw SessionException as readLog(). */
  explicit TickReader(const std::string& path);
  ~TickReader();
  TickReader(const TickReader&) = delete;
  TickReader& operator=(const TickReader&) = delete;

  const LogHeader& header() const noexcept;
  /** @return false at the end of the file. @throw SessionException if the file cannot be read. */
  bool next(TickRecord* record);
  /** [bytes] read so far. */
  std::uint64_t position() const noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/** Reads only the header. @throw SessionException as readLog(). */
LogHeader readLogHeader(const std::string& path);

}  // namespace raven2_trainer::session
