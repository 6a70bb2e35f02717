#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "raven2_trainer/core/record.h"
#include "raven2_trainer/session/session_log.h"
#include "raven2_trainer/training/exercise_tally.h"

namespace raven2_trainer::training {

/** Mean, deviation and maximum of a stream of numbers (Welford). */
class RunningStats {
 public:
  void add(double x) noexcept;
  std::uint64_t count() const noexcept { return count_; }
  double mean() const noexcept { return mean_; }
  double deviation() const noexcept;  ///< sample deviation; 0 with fewer than two
  double max() const noexcept { return max_; }

 private:
  std::uint64_t count_{0};
  double mean_{0.0}, m2_{0.0}, max_{0.0};
};

/** One activation of a fault as it showed. Ticks are session ticks (from the first pedal down). */
struct FaultEvent {
  std::string name;
  Tick first_tick{}, last_tick{};             ///< [1 ms] model clock
  std::uint64_t first_cycle{}, last_cycle{};  ///< [1 ms] robot clock
  double max_error{};                         ///< [m] largest tip error from the start until the cue is over
  double max_force{};                         ///< [N]
  Tick onset_tick{-1};                        ///< first tick that the haptic loop saw above the tolerance; -1 never
  Tick force_tick{-1};                        ///< first tick from then on with a force; -1 never
  Tick end_tick{-1};                          ///< last tick of its aftermath; -1 while it lasts

  /** [ms] from the error passing the tolerance to the force; -1 if either never came. */
  Tick errorToForce() const noexcept { return force_tick < 0 ? -1 : force_tick - onset_tick; }
};

/** One row of a fault plan from when it began to act until it ended: the ground truth, as its host reported it. */
struct Injection {
  Fault fault{};  ///< id 0: not in the record
  std::string name;
  Tick inject_tick{};            ///< [1 ms] session ticks, -1 before the first pedal down; in which the daemon knew
  Tick clear_tick{-1};           ///< in which it knew the end, or lost the robot; -1 it lasts to the end
  std::uint64_t inject_cycle{};  ///< [1 ms] robot's clock; a robot's own fault: exactly the first cycle with it
  std::uint64_t clear_cycle{};   ///< exactly the first without it; 0: it lasts to the end
  bool is_assumed{};             ///< the end is only the loss of the robot's link
  Tick observe_tick{-1};         ///< first session tick with the tips parted by more than the tolerance; -1 never
};

/** A plan that was to be executed. */
struct Execution {
  ExecutionReport report{};
  Tick start_tick{-1};  ///< [1 ms] session tick of the pedal-down; -1 it never came, or is not in the log
};

constexpr std::size_t kMaxInjections = 100'000;  ///< of a session: 40 MB
constexpr std::size_t kMaxExecutions = 10'000;   ///< of a session, a second each for three hours: 1 MB

struct SessionMetrics {
  double duration{};         ///< [s] from the first pedal down
  std::uint64_t ticks{};     ///< of the same span
  RunningStats error;        ///< [m] tip distance, larger arm, while both follow the surgeon, outside faults
  double error_max_force{};  ///< [N] largest force outside faults and their aftermath
  std::vector<FaultEvent> faults;
  std::vector<Injection> injections;
  double max_force{};  ///< [N]
  double tolerance{};  ///< [m]
  PlanResult plan{};   ///< newest, status kNone if none was asked for
  std::vector<Execution> executions;
  std::uint64_t executions_beyond{};  ///< beyond the longest list, kMaxExecutions
  std::string exercise{"none"}, drill{"none"};
  std::vector<ExerciseAttempt> attempts;  ///< at the exercise
  std::uint64_t attempts_beyond{};        ///< beyond the longest list, kMaxAttempts
  SessionCounts counts{};
  std::uint64_t frames{};             ///< of video.mp4; 0 before it is rendered
  std::uint64_t injections_beyond{};  ///< beginnings beyond the longest list, kMaxInjections
  bool complete{};                    ///< the log has its last record, the counters
};

/**
 * Feeds on the records of a session and gives the metrics. The aftermath of a fault belongs to it: from its first
 * tick until the error has stayed below the tolerance for 500 ms after its last. The error is looked at while model and
 * robot follow the surgeon, or a plan, from a common pose (mode teleoperating or executing, `linked`) and the robot's
 * state is fresh. A stale robot stops the 500 ms; without a common pose they run on, because the next pedal down makes
 * a new one.
 *
 * Records of one kind come in order, changes of faults and events of the exercise before the tick that they belong to;
 * haptic records may come before or after theirs (two threads write them), so each waits for its tick.
 */
class MetricsAccumulator {
 public:
  explicit MetricsAccumulator(const session::LogHeader& header);
  void add(const TickRecord& record);
  void add(const HapticRecord& record);
  void add(const PlanRecord& record);
  void add(const FaultRecord& record);
  void add(const FaultChangeRecord& record);
  void add(const ExecutionRecord& record);
  void add(const ExerciseRecord& record) { exercise_.add(record); }
  void add(const SessionCounts& counts);
  SessionMetrics result() const;

 private:
  /** A haptic record that waits for its tick. */
  struct Force {
    Tick model_tick{};
    double newton{};  ///< [N] larger of both arms
    double error{};   ///< [m] the same, of model and robot as the haptic loop saw them; 0 while it may give no force
  };

  /** A row that acts, or acted; the plans have the rest of it. */
  struct Span {
    FaultChange begin{};
    Tick model_tick{};
    Injection injection;
  };

  void followExecution(const ModelState& model);
  std::vector<Execution> executions() const;
  void followChanges(const TickRecord& record);
  void open(const FaultChange& change, const TickRecord& record);
  void take(const FaultChange& change, const TickRecord& record);
  void close(const FaultChange& change, const TickRecord& record);
  Span* spanOf(const FaultChange& change);
  void loseRobot(const TickRecord& record);
  std::uint32_t actingFault(Tick model_tick) const;
  Fault faultOf(const Span& span) const;
  Tick onsetOf(const Injection& injection) const;
  std::vector<Injection> injections() const;
  void followFault(const TickRecord& record);
  std::string nameOf(std::uint32_t id) const;
  void beginFault(std::uint32_t id, const RobotState& robot);
  void followAftermath(double error, bool comparable, bool follows);
  void useForces();
  void useForce(const Force& force);
  FaultEvent* eventAt(Tick tick);
  bool inFault() const { return !metrics_.faults.empty() && metrics_.faults.back().end_tick < 0; }

  session::LogHeader header_;
  SessionMetrics metrics_;
  std::deque<Force> waiting_;
  ExerciseTally exercise_;
  std::vector<std::pair<Tick, Tick>> begun_;  ///< model and session tick with which the model began to execute a plan
  bool executes_{false};
  std::vector<FaultRecord> plans_;
  std::deque<FaultChangeRecord> changes_;  ///< that wait for their tick
  std::vector<Span> spans_;
  std::vector<std::size_t> open_;  ///< of them, those that act
  bool was_connected_{false};
  Tick first_{-1};      ///< session tick of the first tick seen in the session; -1 before
  Tick now_{-1};        ///< session tick being looked at
  Tick model_now_{-1};  ///< its model tick
  std::uint32_t active_fault_{0};
  Tick calm_since_{-1};  ///< session tick from which the error has been below the tolerance; -1 it is not
};

/** Metrics of a finished log. @param[in] on_tick called with every tick; what it throws ends it. May be empty.
 *  @throw SessionException. */
SessionMetrics computeMetrics(const std::string& log_path, const std::function<void()>& on_tick = {});

/** metrics.json; the fields are listed in doc/session.md. @throw SessionException. */
void writeMetrics(const std::string& path, const SessionMetrics& metrics);

/** faults.json: ground truth of every fault event on both clocks. @throw SessionException. */
void writeFaults(const std::string& path, const SessionMetrics& metrics);

/** Sets `frames` in an existing metrics.json. @throw SessionException. */
void setFrames(const std::string& path, std::uint64_t frames);

}  // namespace raven2_trainer::training
