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

/** One activation of a fault and its effects. Ticks are session ticks: [1 ms] since the first pedal-down. */
struct FaultEvent {
  std::string name;
  Tick first_tick{}, last_tick{};             ///< ticks in which it acted
  std::uint64_t first_cycle{}, last_cycle{};  ///< [1 ms] the robot's newest cycles in these ticks
  double max_error{};                         ///< [m] largest tip error, to the end of the aftermath
  double max_force{};                         ///< [N] largest force in the same time
  Tick onset_tick{-1};                        ///< first haptic tick with an error above the tolerance; -1: never
  Tick force_tick{-1};                        ///< first tick from then on with a force; -1: never
  Tick end_tick{-1};                          ///< last tick of its aftermath; -1: not in the log

  /** [ms] from the error passing the tolerance to the force; -1 if either never came. */
  Tick errorToForce() const noexcept { return force_tick < 0 ? -1 : force_tick - onset_tick; }
};

/** One period in which a row of a fault plan acted: the ground truth, as the program that applied it reported. */
struct Injection {
  Fault fault{};  ///< id 0: the log does not have the row
  std::string name;
  Tick inject_tick{};   ///< [1 ms] session tick of the report that it began; -1: before the first pedal-down
  Tick clear_tick{-1};  ///< session tick of the report that it ended, or of the robot's loss; -1: neither, or as above
  std::uint64_t inject_cycle{};  ///< [1 ms] robot's clock: first cycle with a fault of the robot, else its newest cycle
  std::uint64_t clear_cycle{};   ///< the same, first cycle without the fault; 0: it did not end
  bool is_merged{};              ///< from usb_truth.json: both cycles are counts of the library, not the robot's clock
  bool is_assumed{};             ///< the end was not reported: the robot was lost
  Tick observe_tick{-1};         ///< onset_tick of the first event from inject_tick to clear_tick with one; -1: never
};

/** An armed plan or a trial. */
struct Execution {
  ExecutionReport report{};
  Tick start_tick{-1};  ///< [1 ms] session tick of the pedal-down; -1: it never came, or is not in the log
};

constexpr std::size_t kMaxInjections = 100'000;  ///< of a session: 40 MB
constexpr std::size_t kMaxExecutions = 10'000;   ///< of a session: 1 MB, one a second for 2.8 hours

struct SessionMetrics {
  double duration{};         ///< [s] from the first pedal-down
  std::uint64_t ticks{};     ///< tick records of this time
  RunningStats error;        ///< [m] tip error, larger arm, where it counts (see below), outside faults and aftermaths
  double error_max_force{};  ///< [N] largest force outside faults and their aftermath
  std::vector<FaultEvent> faults;
  std::vector<Injection> injections;
  double max_force{};  ///< [N] largest force of the session
  double tolerance{};  ///< [m] tip error up to which there is no force
  PlanResult plan{};   ///< newest; status kNone: no plan was requested
  std::vector<Execution> executions;
  std::uint64_t executions_beyond{};  ///< number of those after kMaxExecutions
  std::string exercise{"none"}, drill{"none"};
  std::vector<ExerciseAttempt> attempts;  ///< at the exercise
  std::uint64_t attempts_beyond{};        ///< number of those after kMaxAttempts
  SessionCounts counts{};
  std::uint64_t frames{};             ///< of video.mp4; 0 before it is rendered
  std::uint64_t injections_beyond{};  ///< number of those after kMaxInjections
  bool complete{};                    ///< the log has its last record, the counters
};

/**
 * Computes the metrics of a session from its records. A fault event includes the fault's aftermath, which ends when the
 * tip error has been within the tolerance for 500 ms after the fault's last tick, or with the next fault. The tip error
 * counts while model and robot follow the surgeon or a plan from a common pose (mode teleoperating or executing,
 * `linked`) and the robot's state is fresh. A stale state restarts the 500 ms. Without a common pose they continue,
 * because the next pedal-down makes a new one.
 *
 * Add records of one kind in order, and changes of faults and events of the exercise before their tick. Haptic records
 * may come before or after their tick, because another thread writes them: each waits for its tick.
 */
class MetricsAccumulator {
 public:
  explicit MetricsAccumulator(const session::LogHeader& header);
  void add(const TickRecord& record);
  void add(const HapticRecord& record);
  void add(const PlanRecord& record);
  void add(const FaultRecord& record);
  void add(const FaultChangeRecord& record) { addChange({record, /*is_merged=*/false}); }
  void addMerged(const FaultChangeRecord& record) { addChange({record, /*is_merged=*/true}); }  ///< of usb_truth.json
  void add(const ExecutionRecord& record);
  void add(const ExerciseRecord& record) { exercise_.add(record); }
  void add(const SessionCounts& counts);
  SessionMetrics result() const;

 private:
  /** A haptic record that waits for its tick. */
  struct Force {
    Tick model_tick{};
    double newton{};  ///< [N] larger of both arms
    double error{};   ///< [m] larger tip error of both arms in the haptic loop; 0 while forces may not act
  };

  /** A change that waits for its tick. */
  struct Change {
    FaultChangeRecord record;
    bool is_merged{};
  };

  /** An injection and the change that began it; its Fault is in plans_. */
  struct Span {
    FaultChange begin{};
    Tick model_tick{};
    Injection injection;
  };

  void followExecution(const ModelState& model);
  std::vector<Execution> executions() const;
  void addChange(const Change& change);
  void followChanges(const TickRecord& record);
  void open(const Change& change, const TickRecord& record);
  void take(const Change& change, const TickRecord& record);
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
  std::vector<std::pair<Tick, Tick>> begun_;  ///< model and session tick in which each execution began
  bool executes_{false};
  std::vector<FaultRecord> plans_;
  std::deque<Change> changes_;  ///< by tick
  std::vector<Span> spans_;
  std::vector<std::size_t> open_;  ///< indices in spans_ of those that act
  bool was_connected_{false};
  Tick first_{-1};      ///< first session tick in the log; -1: not yet
  Tick now_{-1};        ///< session tick of the newest tick record
  Tick model_now_{-1};  ///< model tick of the same record
  std::uint32_t active_fault_{0};
  Tick calm_since_{-1};  ///< session tick in which the 500 ms began; -1: they do not run
};

/** Metrics of a finished log. The faults of usb_truth.json next to it (training/usb_truth.h) are added, if it exists.
 *  @param[in] on_tick Called for every tick record; its exception ends the computation and passes on. May be empty.
 *  @throw SessionException. */
SessionMetrics computeMetrics(const std::string& log_path, const std::function<void()>& on_tick = {});

/** Writes metrics.json; doc/session.md lists its fields. @throw SessionException. */
void writeMetrics(const std::string& path, const SessionMetrics& metrics);

/** Writes faults.json: when each fault event and injection acted, by session tick and robot cycle.
 *  @throw SessionException. */
void writeFaults(const std::string& path, const SessionMetrics& metrics);

/** Sets `frames` in an existing metrics.json. @throw SessionException. */
void setFrames(const std::string& path, std::uint64_t frames);

}  // namespace raven2_trainer::training
