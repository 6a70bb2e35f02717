#pragma once

#include "loop/answers.h"
#include "raven2_trainer/control/execution_tally.h"
#include "raven2_trainer/control/path_relay.h"
#include "raven2_trainer/control/trial_tape.h"
#include "raven2_trainer/loop/loop_config.h"
#include "raven2_trainer/loop/shared_state.h"
#include "raven2_trainer/planning/clearance_gauge.h"

namespace raven2_trainer::loop {

/**
 * A virtual trial and its repetition: the physics loop's memory from the trial's beginning to the end of what became of
 * it. Knows no modes and moves nothing, as PlanStore. The report of a repetition has plan 0; both arms move, and in
 * each tick the one that is farther from where it was in the trial counts. All methods but the constructor are
 * real-time safe; one thread.
 */
class TrialStore {
 public:
  /** @param[in] limit [s] longest trial that is kept. @throw ModelException for a collision shape that is a mesh. */
  TrialStore(const LoopConfig& config,
             const model::RavenModel& raven,
             const model::SceneModel& scene,
             Answers* answers,
             SharedState* shared,
             double limit);

  // ---- the trial
  /** Begins one from `now` [rad; m]; forgets the one before. */
  void open(const PerArm<JointArray>& now) noexcept;
  /** Deletes it; a client that waits for its repetition has had its answer. */
  void close() noexcept { is_open_ = false; }
  bool isOpen() const noexcept { return is_open_; }
  /** The surgeon's pedal went down: what comes need not go on from what is there. */
  void mark() noexcept { tape_.mark(); }
  /** A tick of it, as it was; nothing once it is full. */
  void keep(const PerArm<ArmState>& arms) noexcept;
  bool isFull() const noexcept { return tape_.isFull(); }
  /** [ticks] kept of the open one. */
  std::uint32_t ticks() const noexcept { return is_open_ ? static_cast<std::uint32_t>(tape_.size()) : 0; }
  /** [rad; m] where it began. */
  const PerArm<JointArray>& start() const noexcept { return start_; }

  // ---- repeating it
  /** Arms at `q` [rad; m] are farther from where it began than start_tolerance. */
  bool hasMoved(const PerArm<JointArray>& q) const noexcept;
  /** It will be repeated. */
  void arm(const Request& request) noexcept;
  /** A report is due. */
  bool isUnderWay() const noexcept { return under_way_; }
  /** Whether the repetition under way moves the robot. */
  bool onRobot() const noexcept { return under_way_ && on_robot_; }
  /** A tick of waiting for the pedal. @return false once it was waited for too long. */
  bool waitForPedal() noexcept;
  /** The pedal is down. @param[in] from [rad; m] what the arms are asked for. */
  void begin(const PerArm<JointArray>& from, Tick tick) noexcept;
  /** The robot's joints [rad; m] before it applies increments: the relays start from there. */
  void follow(const PerArm<RobotArmState>& robot) noexcept;
  /** [rad; m] What both arms are asked for in this tick. */
  const PerArm<JointArray>& advance(bool may_move) noexcept;
  /** The increment for the robot in this tick. */
  control::TipIncrement tipIncrement(Arm arm) noexcept;
  /** [rad] The same for its jaws, whole milliradians, positive closes. */
  double graspIncrement(Arm arm) noexcept;
  /** After a tick of repeating. @return why it ends; kNone if it does not. */
  ExecutionEnd supervise(const ModelState& model, const RobotState& robot) noexcept;
  /** Closes what is under way, if anything is. @param[in] tick first one that no longer moves anything. */
  void end(ExecutionEnd end, Tick tick) noexcept;

  /** `state` with the repetition that is under way. */
  PlanningState overlay(PlanningState state) const noexcept;

 private:
  control::ExecutionSample sample(Arm arm, const ModelState& model, const RobotState& robot) const noexcept;

  const ExecutionConfig config_;
  const ArmGeometry geometry_;
  Answers& answers_;
  SharedState& shared_;
  control::TrialTape tape_;
  control::TapeExecution execution_;
  PerArm<control::PathRelay> relays_;
  control::ExecutionTally tally_;
  planning::ClearanceGauge gauge_;
  PerArm<JointArray> start_{};
  PerArm<double> sent_opening_{};  ///< [rad] that the robot's jaws were asked for
  bool is_open_{false}, under_way_{false}, on_robot_{false}, has_begun_{false};
  Tick armed_ticks_{0};
};

}  // namespace raven2_trainer::loop
