#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "raven2_trainer/core/config.h"
#include "raven2_trainer/core/shared_state.h"
#include "raven2_trainer/session/session_directory.h"
#include "raven2_trainer/session/session_log.h"
#include "raven2_trainer/training/session_metrics.h"

namespace raven2_trainer::runtime {

/** Body of the recorder thread: rings to the session log and the metrics. */
class Recorder {
 public:
  /** Opens the log in `paths`. `body_names`: PhysicsLoop::bodyNames(). @throw SessionException. */
  Recorder(const TrainerConfig& config,
           const std::vector<std::string>& body_names,
           const session::SessionPaths& paths,
           const std::string& motion,
           SharedState* shared);

  /** Writes all that is waiting. */
  void drain();

  /** After the loops stopped and drain(), so that `counts` are the last ones: the footer, metrics.json and faults.json.
   */
  void finish(const SessionCounts& counts);

  /** Newest session tick written; -1 before the first pedal down. */
  Tick sessionTick() const noexcept { return session_tick_; }

 private:
  template <typename Record>
  void write(const Record& record);
  template <typename Record, std::size_t Capacity>
  void drainRing(SpscRing<Record, Capacity>* ring);
  void drainInputs();

  SharedState& shared_;
  session::SessionPaths paths_;
  session::LogHeader header_;
  session::LogWriter log_;
  training::MetricsAccumulator metrics_;
  Tick session_tick_{-1};
};

/** Header of a session's log; copies the configuration's files beside it. */
session::LogHeader logHeader(const TrainerConfig& config,
                             const std::vector<std::string>& body_names,
                             const std::string& motion,
                             const session::SessionPaths& paths);

}  // namespace raven2_trainer::runtime
