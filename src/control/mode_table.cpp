#include "raven2_trainer/control/mode_table.h"

namespace raven2_trainer::control {
namespace {

struct Row {
  Mode from;
  Event event;
  Mode to;
};

constexpr Row kRows[] = {
    // clang-format off
    // from                event                  to
    {Mode::kWaiting,       Event::kRobotReady,    Mode::kPedalUp},
    {Mode::kWaiting,       Event::kPedalPressed,  Mode::kTeleoperating},  // no robot: the model alone
    {Mode::kPedalUp,       Event::kPedalPressed,  Mode::kTeleoperating},
    {Mode::kTeleoperating, Event::kPedalReleased, Mode::kPedalUp},
    {Mode::kWaiting,       Event::kPlanRequested, Mode::kPlanning},
    {Mode::kPedalUp,       Event::kPlanRequested, Mode::kPlanning},
    {Mode::kTracking,      Event::kPlanRequested, Mode::kPlanning},
    {Mode::kPlanning,      Event::kPlanReady,     Mode::kTracking},
    {Mode::kPlanning,      Event::kPlanFailed,    Mode::kPedalUp},
    {Mode::kPlanning,      Event::kPedalPressed,  Mode::kTeleoperating},
    {Mode::kTracking,      Event::kPedalPressed,  Mode::kTeleoperating},
    {Mode::kStopped,       Event::kStopCleared,   Mode::kPedalUp},
    {Mode::kTeleoperating, Event::kTimeSlip,      Mode::kPaused},
    {Mode::kPlanning,      Event::kTimeSlip,      Mode::kPaused},
    {Mode::kTracking,      Event::kTimeSlip,      Mode::kPaused},
    {Mode::kPaused,        Event::kPedalPressed,  Mode::kTeleoperating},
    {Mode::kWaiting,       Event::kGoalWanted,    Mode::kChoosing},
    {Mode::kPedalUp,       Event::kGoalWanted,    Mode::kChoosing},
    {Mode::kTracking,      Event::kGoalWanted,    Mode::kChoosing},
    {Mode::kArmed,         Event::kGoalWanted,    Mode::kChoosing},
    {Mode::kChoosing,      Event::kPlanRequested, Mode::kPlanning},       // the goal is recorded
    {Mode::kChoosing,      Event::kPlanCancelled, Mode::kPedalUp},
    {Mode::kChoosing,      Event::kTimeSlip,      Mode::kPaused},
    {Mode::kPlanning,      Event::kPlanCancelled, Mode::kPedalUp},
    {Mode::kPedalUp,       Event::kPlanArmed,     Mode::kArmed},
    {Mode::kTracking,      Event::kPlanArmed,     Mode::kArmed},
    {Mode::kArmed,         Event::kPlanRequested, Mode::kPlanning},
    {Mode::kArmed,         Event::kPlanCancelled, Mode::kPedalUp},
    {Mode::kArmed,         Event::kTimeSlip,      Mode::kPaused},
    {Mode::kArmed,         Event::kPedalPressed,  Mode::kExecuting},
    {Mode::kExecuting,     Event::kPedalReleased, Mode::kPedalUp},        // the dead-man switch
    {Mode::kExecuting,     Event::kPlanCancelled, Mode::kPedalUp},
    {Mode::kExecuting,     Event::kExecutionEnded, Mode::kPedalUp},
    {Mode::kExecuting,     Event::kTrialEnded,    Mode::kTracking},       // the model holds away from the robot
    {Mode::kExecuting,     Event::kTimeSlip,      Mode::kPaused},
    // pure simulation: the model alone
    {Mode::kWaiting,        Event::kSimulationWanted, Mode::kSimulationHeld},
    {Mode::kPedalUp,        Event::kSimulationWanted, Mode::kSimulationHeld},
    {Mode::kTracking,       Event::kSimulationWanted, Mode::kSimulationHeld},
    {Mode::kSimulationHeld, Event::kPedalPressed,     Mode::kSimulating},
    {Mode::kSimulating,     Event::kPedalReleased,    Mode::kSimulationHeld},
    {Mode::kSimulating,     Event::kTimeSlip,         Mode::kSimulationHeld},  // never to the robot by a pause
    {Mode::kSimulationHeld, Event::kSimulationEnded,  Mode::kReturning},
    // a virtual trial: the same, kept
    {Mode::kWaiting,        Event::kTrialWanted,      Mode::kTrialHeld},
    {Mode::kPedalUp,        Event::kTrialWanted,      Mode::kTrialHeld},
    {Mode::kTrialHeld,      Event::kPedalPressed,     Mode::kTrial},
    {Mode::kTrial,          Event::kPedalReleased,    Mode::kTrialHeld},
    {Mode::kTrial,          Event::kTimeSlip,         Mode::kTrialHeld},
    {Mode::kTrial,          Event::kTrialDone,        Mode::kTrialReady},
    {Mode::kTrialHeld,      Event::kTrialDone,        Mode::kTrialReady},
    {Mode::kTrialHeld,      Event::kTrialDiscarded,   Mode::kReturning},
    {Mode::kTrialReady,     Event::kTrialDiscarded,   Mode::kReturning},
    {Mode::kTrialReady,     Event::kRepeatWanted,     Mode::kReturning},
    {Mode::kReturning,      Event::kRepeatArmed,      Mode::kArmed},
    {Mode::kExecuting,      Event::kRepeatShown,      Mode::kTrialReady},
    // back to the robot, at any time
    {Mode::kPedalUp,        Event::kReturnWanted,     Mode::kReturning},
    {Mode::kPlanning,       Event::kReturnWanted,     Mode::kReturning},
    {Mode::kTracking,       Event::kReturnWanted,     Mode::kReturning},
    {Mode::kPaused,         Event::kReturnWanted,     Mode::kReturning},
    {Mode::kReturning,      Event::kReturned,         Mode::kPedalUp},
    // the camera's pedal, in addition to all that the masters move
    {Mode::kTeleoperating,  Event::kCameraPressed,    Mode::kCameraMoving},
    {Mode::kPedalUp,        Event::kCameraPressed,    Mode::kCameraMoving},
    {Mode::kSimulating,     Event::kCameraPressed,    Mode::kCameraMoving},
    {Mode::kSimulationHeld, Event::kCameraPressed,    Mode::kCameraMoving},
    {Mode::kTrial,          Event::kCameraPressed,    Mode::kCameraMoving},
    {Mode::kTrialHeld,      Event::kCameraPressed,    Mode::kCameraMoving},
    {Mode::kCameraMoving,   Event::kCameraLeft,       Mode::kPedalUp},
    {Mode::kCameraMoving,   Event::kCameraLeftAlone,  Mode::kSimulationHeld},
    {Mode::kCameraMoving,   Event::kCameraLeftOnTape, Mode::kTrialHeld},
    // a recorded session, with the pedal up
    {Mode::kWaiting,        Event::kReplayWanted,     Mode::kReplaying},
    {Mode::kPedalUp,        Event::kReplayWanted,     Mode::kReplaying},
    {Mode::kReplaying,      Event::kReplayEnded,      Mode::kPedalUp},
    // clang-format on
};

}  // namespace

Mode nextMode(Mode mode, Event event) noexcept {
  if (event == Event::kEmergencyStop) return Mode::kStopped;
  for (const Row& row : kRows) {
    if (row.from == mode && row.event == event) return row.to;
  }
  return mode;
}

}  // namespace raven2_trainer::control
