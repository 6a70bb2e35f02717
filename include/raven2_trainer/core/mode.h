#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace raven2_trainer {

/** Mode of the daemon. control/mode_table.h lists the events that change it. */
enum class Mode : std::uint8_t {
  kWaiting,        ///< the robot has not been ready yet; without a robot: no pedal-down yet
  kPedalUp,        ///< disengaged: the model follows the robot's joints or, without a robot, holds
  kTeleoperating,  ///< pedal down: the masters move model and robot
  kPlanning,       ///< pedal up, a plan is being computed; the model holds
  kTracking,       ///< pedal up: the model shows a planned path; the robot holds
  kStopped,        ///< emergency stop (robot, request or failed model): the model holds
  kPaused,      ///< after lost time or a pause request: the model holds and the session's clock stops until pedal-down
  kChoosing,    ///< pedal down: the masters move one arm of the model through objects to a goal; the robot holds
  kArmed,       ///< pedal up: the model is at the plan's start and waits for the pedal
  kExecuting,   ///< pedal down: the model follows the plan's path, and the robot too if requested
  kSimulating,  ///< pure simulation, pedal down: the masters move only the model; the robot is disengaged
  kSimulationHeld,  ///< pure simulation, pedal up: the model holds
  kTrial,           ///< virtual trial, pedal down: as kSimulating, and the motion is recorded
  kTrialHeld,       ///< virtual trial, pedal up: the model holds
  kTrialReady,      ///< the trial is over: a request repeats or discards it
  kReturning,       ///< the model moves smoothly to the robot's joints or, without a robot, to a trial's start; through
                    ///< objects
  kReplaying,       ///< pedal up: the model shows a recorded session without physics; the robot holds
  kCameraMoving,    ///< camera pedal down: the masters move the camera; model and robot hold
};
constexpr std::size_t kModeCount = 18;
constexpr std::array<const char*, kModeCount> kModeNames{
    "waiting", "pedal_up",   "teleoperating", "planning",  "tracking",   "stopped",
    "paused",  "choosing",   "armed",         "executing", "simulating", "simulation_held",
    "trial",   "trial_held", "trial_ready",   "returning", "replaying",  "camera_moving"};

/** Part of the physics loop that carries out a mode. A change of mode calls all in this order, a tick only
 * the mode's activity. */
enum class ActivityKind : std::uint8_t {
  kExecution,
  kTrial,
  kPlanning,
  kHold,
  kTeleoperation,
  kGoalSelection,
  kReturning,
  kReplay,
  kCamera,
};
constexpr std::size_t kActivityCount = 9;

/** How a mode ties model and robot. */
enum class Moves : std::uint8_t {
  kNothing,
  kModel,       ///< the model alone; the robot does not move
  kBoth,        ///< model and robot from a common pose; without a robot, only the model
  kBothIfAsked  ///< as kBoth if the request includes the robot, else as kModel
};

constexpr bool mayMoveRobot(Moves moves) noexcept {
  return moves == Moves::kBoth || moves == Moves::kBothIfAsked;
}

/** How physics treats the scene's objects. */
enum class WorldMotion : std::uint8_t {
  kMeets,   ///< objects move by physics and the arms collide with them
  kPasses,  ///< objects move by physics and the arms pass through them
  kStill,   ///< no physics: arms and objects are only placed
};

/** Practice with the model alone, to which a mode belongs. */
enum class Practice : std::uint8_t { kNone, kSimulation, kTrial };

/** The part of a plan that is missing: the goal, which the masters choose, or the path, which the planner computes. */
enum class Seeks : std::uint8_t { kNothing, kGoal, kPath };

/** Properties of a mode: a row of traitsOf(). A test compares them with the table in doc/modes.md. */
struct ModeTraits {
  ActivityKind activity{ActivityKind::kHold};
  Moves moves{};
  WorldMotion world{};
  bool hands{};         ///< the masters move an arm of the model
  bool keeps_plan{};    ///< a plan stays; else it is deleted
  bool keeps_trial{};   ///< a virtual trial stays
  bool keeps_repeat{};  ///< a requested or running repetition of a trial stays
  bool keeps_scene{};   ///< the scene stays as a virtual trial left it; else it goes back to the trial's start
  bool clients_hold{};  ///< a CRTK client may hold the pedal
  bool begins{};        ///< the session's clock starts with this mode
  bool timed{};         ///< an exercise's timer runs
  bool judged{};        ///< an exercise judges contacts and objects
  bool follows_plan{};  ///< the model follows a plan's path
  bool may_replay{};    ///< a replay may start from this mode
  bool may_restart{};   ///< the exercise may restart: no arm moves
  bool follows_robot{};  ///< the model follows a robot that is connected
  bool leaves_robot{};   ///< the model leaves the robot on purpose, without a fault, unless it moves the robot too
                         ///< (isApart)
  Practice practice{};
  Seeks seeks{};
};

constexpr bool kYes = true, kNo = false;

/** Real-time safe. The compiler rejects a mode without a row (-Wswitch). */
constexpr ModeTraits traitsOf(Mode mode) noexcept {
  using A = ActivityKind;
  using M = Moves;
  using W = WorldMotion;
  using P = Practice;
  using S = Seeks;
  switch (mode) {
      // clang-format off
                                    //                                                hands plan   trial  repeat scene clients
                                    // begins timed judged follows replay restart follows_robot leaves_robot practice seeks
    case Mode::kWaiting:        return {A::kHold,          M::kNothing,    W::kPasses, kNo,  kNo,  kNo,  kNo,  kNo,  kNo,  kNo,  kNo,  kNo,  kNo,  kYes, kYes, kYes, kNo,  P::kNone,       S::kNothing};
    case Mode::kPedalUp:        return {A::kHold,          M::kNothing,    W::kMeets,  kNo,  kYes, kNo,  kNo,  kNo,  kNo,  kNo,  kYes, kYes, kNo,  kYes, kYes, kYes, kNo,  P::kNone,       S::kNothing};
    case Mode::kTeleoperating:  return {A::kTeleoperation, M::kBoth,       W::kMeets,  kYes, kYes, kNo,  kNo,  kNo,  kYes, kYes, kYes, kYes, kNo,  kNo,  kNo,  kNo,  kNo,  P::kNone,       S::kNothing};
    case Mode::kPlanning:       return {A::kPlanning,      M::kNothing,    W::kMeets,  kNo,  kNo,  kNo,  kNo,  kNo,  kNo,  kNo,  kYes, kYes, kNo,  kNo,  kNo,  kNo,  kYes, P::kNone,       S::kPath};
    case Mode::kTracking:       return {A::kPlanning,      M::kModel,      W::kMeets,  kNo,  kYes, kNo,  kNo,  kNo,  kNo,  kNo,  kYes, kNo,  kYes, kNo,  kNo,  kNo,  kYes, P::kNone,       S::kNothing};
    case Mode::kStopped:        return {A::kHold,          M::kNothing,    W::kMeets,  kNo,  kNo,  kNo,  kNo,  kYes, kNo,  kNo,  kYes, kYes, kNo,  kNo,  kNo,  kNo,  kNo,  P::kNone,       S::kNothing};
    case Mode::kPaused:         return {A::kHold,          M::kNothing,    W::kMeets,  kNo,  kNo,  kNo,  kNo,  kYes, kNo,  kNo,  kNo,  kNo,  kNo,  kNo,  kNo,  kNo,  kNo,  P::kNone,       S::kNothing};
    case Mode::kChoosing:       return {A::kGoalSelection, M::kNothing,    W::kStill,  kYes, kNo,  kNo,  kNo,  kNo,  kNo,  kNo,  kYes, kNo,  kNo,  kNo,  kNo,  kNo,  kYes, P::kNone,       S::kGoal};
    case Mode::kArmed:          return {A::kExecution,     M::kNothing,    W::kMeets,  kNo,  kYes, kYes, kYes, kYes, kNo,  kNo,  kYes, kYes, kNo,  kNo,  kNo,  kNo,  kYes, P::kNone,       S::kNothing};
    case Mode::kExecuting:      return {A::kExecution,     M::kBothIfAsked, W::kMeets,  kNo,  kYes, kYes, kYes, kYes, kNo,  kYes, kYes, kYes, kYes, kNo,  kNo,  kNo,  kYes, P::kNone,       S::kNothing};
    case Mode::kSimulating:     return {A::kTeleoperation, M::kModel,      W::kMeets,  kYes, kNo,  kNo,  kNo,  kNo,  kNo,  kYes, kYes, kYes, kNo,  kNo,  kNo,  kNo,  kYes, P::kSimulation, S::kNothing};
    case Mode::kSimulationHeld: return {A::kHold,          M::kModel,      W::kMeets,  kNo,  kNo,  kNo,  kNo,  kNo,  kNo,  kNo,  kYes, kYes, kNo,  kNo,  kYes, kNo,  kYes, P::kSimulation, S::kNothing};
    case Mode::kTrial:          return {A::kTrial,         M::kModel,      W::kMeets,  kYes, kNo,  kYes, kNo,  kYes, kNo,  kYes, kYes, kYes, kNo,  kNo,  kNo,  kNo,  kYes, P::kTrial,      S::kNothing};
    case Mode::kTrialHeld:      return {A::kTrial,         M::kModel,      W::kMeets,  kNo,  kNo,  kYes, kNo,  kYes, kNo,  kNo,  kYes, kYes, kNo,  kNo,  kNo,  kNo,  kYes, P::kTrial,      S::kNothing};
    case Mode::kTrialReady:     return {A::kTrial,         M::kNothing,    W::kMeets,  kNo,  kNo,  kYes, kNo,  kYes, kNo,  kNo,  kYes, kYes, kNo,  kNo,  kNo,  kNo,  kYes, P::kNone,       S::kNothing};
    case Mode::kReturning:      return {A::kReturning,     M::kNothing,    W::kPasses, kNo,  kYes, kYes, kYes, kYes, kNo,  kNo,  kYes, kNo,  kNo,  kNo,  kNo,  kNo,  kYes, P::kNone,       S::kNothing};
    case Mode::kReplaying:      return {A::kReplay,        M::kNothing,    W::kStill,  kNo,  kNo,  kNo,  kNo,  kNo,  kNo,  kNo,  kNo,  kNo,  kNo,  kNo,  kNo,  kNo,  kYes, P::kNone,       S::kNothing};
    case Mode::kCameraMoving:   return {A::kCamera,        M::kNothing,    W::kMeets,  kNo,  kYes, kYes, kNo,  kYes, kYes, kNo,  kYes, kYes, kNo,  kNo,  kNo,  kNo,  kNo,  P::kNone,       S::kNothing};
      // clang-format on
  }
  return {};  // invalid mode
}

/** Whether the model may be away from the robot without a fault. Real-time safe. @param[in] is_linked
 * ModelState::linked. */
constexpr bool isApart(Mode mode, bool is_linked) noexcept {
  const ModeTraits traits = traitsOf(mode);
  return traits.leaves_robot && !(is_linked && mayMoveRobot(traits.moves));
}

}  // namespace raven2_trainer
