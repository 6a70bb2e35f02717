#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "raven2_trainer/config/trainer_config.h"
#include "raven2_trainer/loop/shared_state.h"
#include "raven2_trainer/session/flight_recorder.h"
#include "raven2_trainer/session/session_directory.h"
#include "raven2_trainer/session/session_log.h"
#include "raven2_trainer/training/session_metrics.h"

namespace raven2_trainer::recording {

/**
 * Recorder thread's body: moves records from queues to session log and metrics. It writes half a second at a time,
 * which compresses better. A record stays in its queue until the log has taken it. So nothing is lost while a disk
 * refuses, until the queues are full. Then lost records are counted. A gap record in the log has their number, as soon
 * as the disk takes records again.
 */
class Recorder {
 public:
  /**
   * Creates the log in `paths`. `body_names`: PhysicsLoop::bodyNames().
   * @param flight the file that `shared` has its record queues in; null: they do not outlive the process.
   * @throw SessionException.
   */
  Recorder(const TrainerConfig& config,
           const std::vector<std::string>& body_names,
           const session::SessionPaths& paths,
           const std::string& motion,
           SharedState* shared,
           session::FlightRecorder* flight = nullptr);

  /** Allocates some 30 MiB for a batch of full queues, so that a late recorder allocates nothing. Call it for a
   * recorder thread; lockstep allocates on demand. @throw std::bad_alloc. */
  void takeMemory();

  /** Writes all that is waiting. @throw SessionException if the disk refuses. */
  void drain();

  /** Collects waiting records; writes them at half a second or a third-full queue. @throw SessionException if the disk
   * refuses. */
  void follow();

  /**
   * As follow(), with patience: if the disk refuses, the records stay in their queues and the disk is tried again every
   * 0.5 s; lines on stderr report the first refusal and its end. Forces the log to the disk once a second. Where the
   * queues do not survive the process, it writes at once.
   * @param[in] now_ns CLOCK_MONOTONIC.
   * @param[in] at_once Writes what waits, as at the session's end, unless the next try is still to come.
   */
  void drain(std::int64_t now_ns, bool at_once = false);

  /**
   * After the loops stopped: writes remaining records, counts, metrics.json and faults.json. Call drain() before you
   * take the counts: they must count waiting records as written. Records that the disk does not take become a gap
   * record. @throw SessionException if counts or JSON files do not fit; without counts, the queues' file stays for a
   * recovery.
   */
  void finish(SessionCounts counts);

 private:
  /** The log has the queues' records up to `tails`. */
  struct Progress {
    RecordTally tails{}, dropped{};
    Tick tick{-1};
  };

  void collect();
  bool isDue() const;
  void writeGap(GapReason reason, const RecordTally& lost, Tick tick);
  void settle();
  void release(const RecordTally& tails);
  bool write();
  bool tryDrain(bool at_once);
  [[noreturn]] void refuse() const;
  void reportRefusal();
  void reportReturn();
  void writeEnd(SessionCounts* counts);
  void giveUp(SessionCounts* counts);

  SharedState& shared_;
  session::SessionPaths paths_;
  session::LogHeader header_;
  session::LogWriter log_;
  session::FlightRecorder* flight_;
  training::MetricsAccumulator metrics_;
  Progress written_;                ///< in the file; `dropped`: lost records that gap records report
  Progress collected_;              ///< in file or batch
  std::vector<RecordTally> order_;  ///< tails after each collect(): the metrics get records in the log's order
  RecorderStatus status_{};
  int refused_since_gap_{0};  ///< errno
  std::int64_t retry_ns_{0}, sync_ns_{0};
};

/** Header of a session's log; copies the configuration's files next to it. */
session::LogHeader logHeader(const TrainerConfig& config,
                             const std::vector<std::string>& body_names,
                             const std::string& motion,
                             const session::SessionPaths& paths);

}  // namespace raven2_trainer::recording
