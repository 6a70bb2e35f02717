#pragma once

#include "raven2_trainer/core/state.h"

namespace raven2_trainer::control {

/** Events that can change the mode. */
enum class Event : std::uint8_t {
  kRobotReady,  ///< homed and disengaged, seen for the first time
  kPedalPressed,
  kPedalReleased,
  kPlanRequested,
  kPlanReady,
  kPlanFailed,
  kEmergencyStop,   ///< the robot's E-STOP, a request, a pedal, or a failure of the model
  kStopCleared,     ///< by the robot, or by request
  kTimeSlip,        ///< simulated time was lost, or a pause was requested
  kGoalWanted,      ///< the surgeon wants to show the model's goal
  kPlanArmed,       ///< execution of the plan was requested
  kPlanCancelled,   ///< choosing, planning or executing was given up
  kExecutionEnded,  ///< model and robot hold where they are
  kTrialEnded,      ///< the execution by the model alone has ended, and the model holds
  kSimulationWanted,
  kSimulationEnded,  ///< the model goes back to the robot
  kTrialWanted,      ///< a virtual trial, whose motion is kept
  kTrialDone,        ///< recording has ended
  kTrialDiscarded,
  kRepeatWanted,      ///< the trial shall be repeated: first back to where it began
  kRepeatArmed,       ///< the model is where the trial began
  kRepeatShown,       ///< the model repeated it alone and holds
  kReturnWanted,      ///< the model is away from a connected robot
  kReturned,          ///< the model is back at the robot, or at the start of the trial
  kCameraPressed,     ///< the camera's pedal
  kCameraLeft,        ///< the camera pedal went up, outside practice
  kCameraLeftAlone,   ///< the same after pure simulation
  kCameraLeftOnTape,  ///< the same after a virtual trial
  kReplayWanted,      ///< a recorded session shall be shown
  kReplayEnded,       ///< the replay ended, for whatever reason; everything is set back
};
constexpr std::size_t kEventCount = 30;

/** The mode after an event; the mode itself if the table has no row for it. Real-time safe. */
Mode nextMode(Mode mode, Event event) noexcept;

}  // namespace raven2_trainer::control
