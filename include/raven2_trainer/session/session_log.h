#pragma once

#include <cstdint>
#include <cstdio>
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

/** What one open log holds besides ticks. */
struct LogHeader {
  std::uint64_t seed{};
  std::vector<std::string> scenarios;                         ///< names; Fault::id is the position + 1
  std::string hazard;                                         ///< armed at the start, or "none"
  std::string robot_urdf_hash, scene_urdf_hash, config_hash;  ///< FNV-1a, hex
  std::string motion;                   ///< "scripted" or "recording:FILE", as the console was started; "" unknown
  double d4{};                          ///< [m] for conversions of joint coordinates
  double tolerance{};                   ///< [m] of the haptic cue
  PerArm<bool> arm_contacts{};          ///< the model's arm meets the scene, at the start
  std::vector<std::string> body_names;  ///< by the numbers of contact records
  std::vector<ConfigurationFile> configuration;  ///< copies beside the log, the root file first; empty: none
};

/**
 * Writes one log through a buffer of 64 KiB: a process that is killed loses at most its last 40 ticks or so. Not for
 * real-time threads. @throw SessionException on a file that cannot be opened or written.
 */
class LogWriter {
 public:
  LogWriter(const std::string& path, const LogHeader& header);
  ~LogWriter();
  LogWriter(const LogWriter&) = delete;
  LogWriter& operator=(const LogWriter&) = delete;

  void write(const TickRecord& record);
  void write(const HapticRecord& record);
  void write(const CommandRecord& record);
  void write(const RequestRecord& record);
  void write(const PlanRecord& record);
  void write(const FaultRecord& record);
  void write(const ContactRecord& record);
  /** Last record: the counters. A log without it ended uncleanly. Closes the file. */
  void finish(const SessionCounts& counts);

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
  std::function<void(const ContactRecord&)> contact;
  std::function<void(const SessionCounts&)> counts;
  std::function<void(std::uint64_t bytes)> position;  ///< of the file read so far, after each record
};

struct LogSummary {
  LogHeader header;
  std::uint64_t records{};          ///< intact ones behind the header
  bool clean{};                     ///< the footer was found
  std::uint64_t bad_bytes{};        ///< skipped because a CRC, a length or a value was wrong
  std::uint64_t truncated_bytes{};  ///< of a last record that was cut short
};

/**
 * Reads a log from the start, one record at a time. A bad record is skipped by searching the next magic.
 * @throw SessionException if the file is missing or does not start with a readable header.
 */
LogSummary readLog(const std::string& path, const LogVisitor& visitor);

/** The first record alone. @throw SessionException as readLog(). */
LogHeader readLogHeader(const std::string& path);

}  // namespace raven2_trainer::session
