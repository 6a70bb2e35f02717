#pragma once

#include <cstdint>

#include "loop/answers.h"
#include "raven2_trainer/control/execution_tally.h"
#include "raven2_trainer/control/path_execution.h"
#include "raven2_trainer/control/path_relay.h"
#include "raven2_trainer/loop/loop_config.h"
#include "raven2_trainer/loop/shared_state.h"
#include "raven2_trainer/planning/clearance_gauge.h"

namespace raven2_trainer::loop {

/**
 * Requests to the planner, its answers and their execution: the physics loop's memory between a request and the end of
 * an execution. Knows no modes and moves nothing: the loop asks it and raises the events.
 *
 * A plan that succeeded is kept until another is wanted, it is cancelled, the robot executed it or was lost, an E-stop
 * or a time slip. All methods are real-time safe; one thread.
 */
class PlanStore {
 public:
  /** @throw ModelException for a collision shape that is a mesh. */
  PlanStore(const LoopConfig& config,
            const model::RavenModel& raven,
            const model::SceneModel& scene,
            Answers* answers,
            SharedState* shared);

  const PlanningState& state() const noexcept { return state_; }
  /** Id of the plan along whose path the hand may be guided; 0 none. */
  std::uint32_t guidePlan() const noexcept;

  // ---- choosing and planning
  /** The surgeon moves `arm`, which was at `q` with rates `dq`. Forgets the plan that was kept. */
  void choose(Arm arm, const JointArray& q, const JointArray& dq) noexcept;
  const JointArray& chosenFrom() const noexcept { return chosen_q_; }
  const JointArray& ratesBefore() const noexcept { return chosen_dq_; }

  /** As many are under way as the rings hold. */
  bool isFull() const noexcept { return plans_under_way_ >= kMaxPlansUnderWay; }
  /** @param[in] now [rad; m] both arms. @param[in] tick in which it is asked for. */
  void ask(const Request& request, const PerArm<JointArray>& now) noexcept;
  /** Notes for the record that a request got no plan; the client learns it from answer(). An earlier plan stays. */
  void refuse(std::uint32_t id, Tick tick) noexcept;
  /** An answer came. @return it, cancelled if nobody waits for it any more; what was awaited is kept if it succeeded.
   */
  const PlanResult& take(const PlanResult& result, Tick tick) noexcept;
  bool isAwaited(const PlanResult& result) const noexcept;
  /** Nobody will follow what is asked for, kept or executed; the planner learns it within a tick. */
  void forget() noexcept;

  // ---- executing
  const PlanResult& plan() const noexcept { return plan_; }
  /** @return why the plan that is kept cannot be executed; kAccepted if it can. @param[in] robot_joins [-] the robot is
   *  there to follow. */
  PlanningAnswer check(const Request& request, bool robot_joins) const noexcept;
  /** Whether an arm has moved since the plan was requested. For the arm of the plan: farther than start_tolerance, or
   * with an obstacle between it and the start of the path. For the other arm: farther than the path keeps away from it.
   *  @param[in] q [rad; m]. */
  bool hasMoved(Arm arm, const JointArray& q) noexcept;
  void arm(const Request& request) noexcept;
  /** A tick of waiting for the pedal. @return false once it was waited for too long. */
  bool waitForPedal() noexcept;
  /** The pedal is down. @param[in] from [rad; m] the model's arm. */
  void begin(const JointArray& from, Tick tick) noexcept;
  /** The robot's joints [rad; m] before it applies increments: the relay starts from there. */
  void follow(const JointArray& robot_q) noexcept { relay_.start(plan_.arm, robot_q); }
  /** Where the arm shall be in this tick, and how fast it shall move there. */
  const control::JointTarget& advance(bool may_move) noexcept;
  /** The increment for the robot in this tick, to the joints `q` [rad; m]. */
  control::TipIncrement increment(const JointArray& q) noexcept { return relay_.advance(q); }
  /** After a tick of executing. @return why it ends; kNone if it does not. */
  ExecutionEnd supervise(const ModelState& model, const RobotState& robot) noexcept;
  /** A report is due: armed or executing. */
  bool isUnderWay() const noexcept { return under_way_; }
  /** Closes what is under way, if anything is. @param[in] tick first one that no longer moves anything. */
  void end(ExecutionEnd end, Tick tick) noexcept;

 private:
  bool isNear(const JointArray& q, const JointArray& before) const noexcept;
  bool isWayFree(const JointArray& from) noexcept;
  double tipDistance(Arm arm, const JointArray& a, const JointArray& b) const noexcept;

  const ExecutionConfig config_;
  const ArmGeometry geometry_;
  Answers& answers_;
  SharedState& shared_;
  PlanningState state_{};
  control::PathExecution execution_;
  control::PathRelay relay_;
  control::ExecutionTally tally_;
  planning::ClearanceGauge gauge_;
  JointArray chosen_q_{}, chosen_dq_{};
  PlanResult plan_{};              ///< that is kept
  PlanResult newest_{};            ///< newest answer
  PerArm<JointArray> at_request_{};  ///< [rad; m] the arms when plan_ was requested
  std::uint32_t serial_{0};
  std::uint32_t plans_under_way_{0};  ///< requested and not answered yet, cancelled ones included
  bool under_way_{false};
  Tick armed_ticks_{0};
};

}  // namespace raven2_trainer::loop
