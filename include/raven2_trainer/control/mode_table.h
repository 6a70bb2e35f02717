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
  kEmergencyStop,   ///< the robot's run level fell to E-STOP, or the model's simulation failed
  kStopCleared,     ///< the robot left E-STOP
  kTimeSlip,        ///< simulated time was lost: a backlog too long to catch up
  kGoalWanted,      ///< the surgeon wants to show the model's goal
  kPlanArmed,       ///< the plan that is there shall be executed
  kPlanCancelled,   ///< choosing, planning or executing was given up
  kExecutionEnded,  ///< model and robot hold where they are
  kTrialEnded,      ///< the same of the model alone
  kSimulationWanted,
  kSimulationEnded,  ///< the model goes back to the robot
  kTrialWanted,      ///< a virtual trial, whose motion is kept
  kTrialDone,        ///< nothing more is kept
  kTrialDiscarded,
  kRepeatWanted,      ///< the trial shall be repeated: first back to where it began
  kRepeatArmed,       ///< there
  kRepeatShown,       ///< the model repeated it alone and holds
  kReturnWanted,      ///< the model is away from a robot that is there
  kReturned,          ///< no longer
  kCameraPressed,     ///< the camera's pedal
  kCameraLeft,        ///< it is up again, and was pressed with model and robot together,
  kCameraLeftAlone,   ///< in pure simulation,
  kCameraLeftOnTape,  ///< in a virtual trial
  kReplayWanted,      ///< a recorded session shall be shown
  kReplayEnded,       ///< no longer, for whatever reason: everything is again as it was
};
constexpr std::size_t kEventCount = 30;

/** The mode after an event; the mode itself if the table has no row for it. Real-time safe. */
Mode nextMode(Mode mode, Event event) noexcept;

}  // namespace raven2_trainer::control
