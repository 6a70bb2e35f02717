#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace raven2_trainer {

/** Mode of the daemon. The table of events is in control/mode_table.h. */
enum class Mode : std::uint8_t {
  kWaiting,        ///< no pedal packet yet, or the robot is not ready
  kPedalUp,        ///< disengaged: the model follows the robot's joints, or holds without a robot
  kTeleoperating,  ///< pedal down: increments move model and robot
  kPlanning,       ///< pedal up, a plan is being computed; the model holds
  kTracking,       ///< the model follows a planned path; the robot holds
  kStopped,        ///< the robot is in E-STOP; the model holds
  kPaused,         ///< simulated time was lost: the model holds and the session's clock stops until pedal-down
  kChoosing,   ///< planning mode: pedal down moves one arm of the model through objects to a goal; the robot holds
  kArmed,      ///< pedal up: the model is at the plan's start and waits for the pedal
  kExecuting,  ///< pedal held: the model follows the plan's path; so does the robot if requested
  kSimulating,      ///< pure simulation, pedal down: increments move only the model; the robot is disengaged
  kSimulationHeld,  ///< the same, pedal up: the model holds
  kTrial,           ///< virtual trial, pedal down: as kSimulating, and the motion is recorded
  kTrialHeld,       ///< the same, pedal up: the model holds
  kTrialReady,      ///< the trial has ended and waits: repeat or discard
  kReturning,       ///< pedal up: the model glides to the robot's joints, through objects
  kReplaying,       ///< pedal up: the model shows a recorded session, the world is paused; the robot holds
  kCameraMoving,    ///< camera pedal held: the masters move the camera; model and robot hold
};
constexpr std::size_t kModeCount = 18;
constexpr std::array<const char*, kModeCount> kModeNames{
    "waiting", "pedal_up",   "teleoperating", "planning",  "tracking",   "stopped",
    "paused",  "choosing",   "armed",         "executing", "simulating", "simulation_held",
    "trial",   "trial_held", "trial_ready",   "returning", "replaying",  "camera_moving"};

/** Part of the physics loop that carries out a mode. */
enum class ActivityKind : std::uint8_t {
  kHold,
  kTeleoperation,
  kPlanning,
  kGoalSelection,
  kExecution,
  kTrial,
  kReturning,
  kReplay,
  kCamera,
};
constexpr std::size_t kActivityCount = 9;

/** Arms that a mode can move. */
enum class Moves : std::uint8_t {
  kNothing,
  kModel,       ///< the model, apart from the robot; the robot does not move
  kBoth,        ///< model and robot from a common pose, or only the model without a robot
  kBothIfAsked  ///< the same, if the request includes the robot
};

/** Motion of the world. */
enum class WorldMotion : std::uint8_t {
  kMeets,   ///< the world is stepped, and the arms collide with it
  kPasses,  ///< the world is stepped, and the arms pass through it
  kStill,   ///< the world is not stepped: bodies are placed without physics
};

/** Properties of a mode: a row of traitsOf(). doc/modes.md shows them; a test compares both. */
struct ModeTraits {
  ActivityKind activity{};
  Moves moves{};
  WorldMotion world{};
  bool hands{};         ///< the masters move an arm of the model
  bool keeps_plan{};    ///< a plan may be kept
  bool keeps_trial{};   ///< a virtual trial may be kept
  bool keeps_repeat{};  ///< a requested or running repetition of a trial may be kept
  bool clients_hold{};  ///< a CRTK client may hold the pedal
  bool begins{};        ///< the session's clock starts with this mode
  bool timed{};         ///< an exercise's timer runs
  bool judged{};        ///< contacts of arms and motion of objects count in an exercise
  bool follows_plan{};  ///< the model follows a plan's path
  bool may_replay{};    ///< a replay may start from this mode
};

constexpr bool kYes = true, kNo = false;

/** Real-time safe. A mode without a row does not compile (-Wswitch). */
constexpr ModeTraits traitsOf(Mode mode) noexcept {
  using A = ActivityKind;
  using M = Moves;
  using W = WorldMotion;
  switch (mode) {
      // clang-format off
                                    //                                                hands plan   trial  repeat clients
                                    // begins timed judged follows replay
    case Mode::kWaiting:        return {A::kHold,          M::kNothing,    W::kPasses, kNo,  kNo,  kNo,  kNo,  kNo,  kNo,  kNo,  kNo,  kNo,  kYes};
    case Mode::kPedalUp:        return {A::kHold,          M::kNothing,    W::kMeets,  kNo,  kYes, kNo,  kNo,  kNo,  kNo,  kYes, kYes, kNo,  kYes};
    case Mode::kTeleoperating:  return {A::kTeleoperation, M::kBoth,       W::kMeets,  kYes, kYes, kNo,  kNo,  kYes, kYes, kYes, kYes, kNo,  kNo};
    case Mode::kPlanning:       return {A::kPlanning,      M::kNothing,    W::kMeets,  kNo,  kNo,  kNo,  kNo,  kNo,  kNo,  kYes, kYes, kNo,  kNo};
    case Mode::kTracking:       return {A::kPlanning,      M::kModel,      W::kMeets,  kNo,  kYes, kNo,  kNo,  kNo,  kNo,  kYes, kNo,  kYes, kNo};
    case Mode::kStopped:        return {A::kHold,          M::kNothing,    W::kMeets,  kNo,  kNo,  kNo,  kNo,  kNo,  kNo,  kYes, kYes, kNo,  kNo};
    case Mode::kPaused:         return {A::kHold,          M::kNothing,    W::kMeets,  kNo,  kNo,  kNo,  kNo,  kNo,  kNo,  kNo,  kNo,  kNo,  kNo};
    case Mode::kChoosing:       return {A::kGoalSelection, M::kNothing,    W::kStill,  kYes, kNo,  kNo,  kNo,  kNo,  kNo,  kYes, kNo,  kNo,  kNo};
    case Mode::kArmed:          return {A::kExecution,     M::kNothing,    W::kMeets,  kNo,  kYes, kYes, kYes, kNo,  kNo,  kYes, kYes, kNo,  kNo};
    case Mode::kExecuting:      return {A::kExecution,     M::kBothIfAsked, W::kMeets,  kNo,  kYes, kYes, kYes, kNo,  kYes, kYes, kYes, kYes, kNo};
    case Mode::kSimulating:     return {A::kTeleoperation, M::kModel,      W::kMeets,  kYes, kNo,  kNo,  kNo,  kNo,  kYes, kYes, kYes, kNo,  kNo};
    case Mode::kSimulationHeld: return {A::kHold,          M::kModel,      W::kMeets,  kNo,  kNo,  kNo,  kNo,  kNo,  kNo,  kYes, kYes, kNo,  kNo};
    case Mode::kTrial:          return {A::kTrial,         M::kModel,      W::kMeets,  kYes, kNo,  kYes, kNo,  kNo,  kYes, kYes, kYes, kNo,  kNo};
    case Mode::kTrialHeld:      return {A::kTrial,         M::kModel,      W::kMeets,  kNo,  kNo,  kYes, kNo,  kNo,  kNo,  kYes, kYes, kNo,  kNo};
    case Mode::kTrialReady:     return {A::kTrial,         M::kNothing,    W::kMeets,  kNo,  kNo,  kYes, kNo,  kNo,  kNo,  kYes, kYes, kNo,  kNo};
    case Mode::kReturning:      return {A::kReturning,     M::kNothing,    W::kPasses, kNo,  kYes, kYes, kYes, kNo,  kNo,  kYes, kNo,  kNo,  kNo};
    case Mode::kReplaying:      return {A::kReplay,        M::kNothing,    W::kStill,  kNo,  kNo,  kNo,  kNo,  kNo,  kNo,  kNo,  kNo,  kNo,  kNo};
    case Mode::kCameraMoving:   return {A::kCamera,        M::kNothing,    W::kMeets,  kNo,  kYes, kYes, kNo,  kYes, kNo,  kYes, kYes, kNo,  kNo};
      // clang-format on
  }
  return {};  // not a mode
}

}  // namespace raven2_trainer
