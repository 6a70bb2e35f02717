#pragma once

#include <memory>
#include <string>
#include <vector>

#include "raven2_trainer/daemon/render_loop.h"
#include "raven2_trainer/loop/plan_counts.h"
#include "raven2_trainer/loop/shared_state.h"
#include "raven2_trainer/model/raven_model.h"
#include "raven2_trainer/session/session_directory.h"

namespace raven2_trainer {
struct TrainerConfig;
}

namespace raven2_trainer::daemon {

struct SimulatorOptions {
  std::string output;  ///< session directory; empty: `sessions/<UTC stamp>`
  std::string motion;  ///< what the console plays, for the record only
  std::string version;
  double duration{0.0};  ///< [s] of session time, from the first pedal down; 0: until stopped
  bool strict{false};    ///< refuse to start where real time cannot be trusted (realtime_check.h)
  bool render{true};     ///< live picture
};

/** State of the daemon, for a caller that waits for its end. */
enum class SimulatorState : std::uint8_t {
  kRunning,
  kComplete,  ///< the wanted session time is reached
  kNoPedal,   ///< no pedal-down within runtime.start_timeout, and a duration was asked for
};

/**
 * The daemon: owns the shared state, the loops and their threads. Construct, start(), poll state(), stop().
 * Threads and what they own: doc/architecture.md.
 */
class Simulator {
 public:
  /** @throw ConfigException, ModelException, NetworkException, SessionException. Opens the sockets and the log.
   *  RealtimeException with `strict`, before anything is opened. */
  Simulator(const TrainerConfig& config, const SimulatorOptions& options);
  ~Simulator();
  Simulator(const Simulator&) = delete;
  Simulator& operator=(const Simulator&) = delete;

  /** Receiver of the live pictures from now on, on the render thread; {}: nobody. Any thread, at any time. When this
   *  returns, the sink before is not called any more. */
  void setImageSink(ImageSink sink);

  /** @throw RealtimeException if a thread cannot be created. */
  void start();

  SimulatorState state() const;

  /** Zero force first, pedal up to the robot, then the other threads, then the session's files. Safe to call twice. */
  void stop();

  /** After stop(): whether the session's files were written to their end. A write error ends no session. */
  bool recorded() const noexcept;

  /** For RequestKind::kBeginReplay: SessionPlayer::open(). Any thread but the real-time ones. @throw SessionException
   *  with the reason why it cannot be shown. */
  std::uint32_t openReplay(const std::string& path);

  SharedState& shared() const noexcept;
  const TrainerConfig& config() const noexcept;
  const model::RavenModel& raven() const noexcept;
  const session::SessionPaths& paths() const noexcept;
  /** By the numbers of contact records and of an exercise's events. */
  const std::vector<std::string>& bodyNames() const noexcept;
  SessionCounts counts() const;
  /** Of the plan under way, or of the newest. Any thread. */
  PlanCounts planCounts() const noexcept;
  /** The granted scheduling and memory locking, in words. */
  std::string realtimeStatus() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace raven2_trainer::daemon
