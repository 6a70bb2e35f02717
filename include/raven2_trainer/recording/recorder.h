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
 * Body of the recorder thread: queues to the session log and the metrics. A record stays in its queue until the log has
 * taken it. So nothing is lost while a disk refuses, until the queues are full. Then lost records are counted. A gap
 * record in the log has their number, as soon as the disk takes records again.
 */
class Recorder {
 public:
  /**
   * Opens the log in `paths`. `body_names`: PhysicsLoop::bodyNames().
   * @param flight the file that `shared` has its record queues in; null: they do not outlive the process.
   * @throw SessionException.
   */
  Recorder(const TrainerConfig& config,
           const std::vector<std::string>& body_names,
           const session::SessionPaths& paths,
           const std::string& motion,
           SharedState* shared,
           session::FlightRecorder* flight = nullptr);

  /** Takes the memory for a batch of all that the queues hold, some 10 MiB: a recorder that comes late needs no more
   *  then. For one that has its own thread; in lockstep no batch is large. @throw std::bad_alloc. */
  void takeMemory();

  /** Writes all that is waiting. @throw SessionException if the disk refuses. */
  void drain();

  /**
   * The same with patience: if the disk refuses, the records stay in their queues and the disk is tried again every
   * 0.5 s; a line on stderr reports the first refusal and its end. Forces the log to the disk once a second.
   */
  void drain(std::int64_t now_ns);

  /**
   * After the loops stopped: the rest, the footer, metrics.json and faults.json. Records that the disk does not take
   * become a gap record. @throw SessionException if even the footer does not fit; the queues' file is then left for a
   * recovery.
   */
  void finish(SessionCounts counts);

  /** Newest session tick written; -1 before the first pedal down. */
  Tick sessionTick() const noexcept { return session_tick_; }

 private:
  /** A batch: the queues up to `tails`. */
  struct Batch {
    RecordTally tails{}, dropped{};
    Tick tick{-1};
  };

  Batch collect();
  void writeGap(GapReason reason, const RecordTally& lost, Tick tick);
  void settle(const Batch& batch);
  void release(const RecordTally& tails);
  bool tryDrain();
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
  RecordTally reported_{};  ///< lost records that gap records in the log report
  RecorderStatus status_{};
  int refused_since_gap_{0};  ///< errno
  Tick tick_{-1}, session_tick_{-1};
  std::int64_t retry_ns_{0}, sync_ns_{0};
};

/** Header of a session's log; copies the configuration's files next to it. */
session::LogHeader logHeader(const TrainerConfig& config,
                             const std::vector<std::string>& body_names,
                             const std::string& motion,
                             const session::SessionPaths& paths);

}  // namespace raven2_trainer::recording
