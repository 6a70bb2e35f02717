#pragma once

#include "raven2_trainer/core/state.h"

namespace raven2_trainer::control {

/** What can change the mode. */
enum class Event : std::uint8_t {
  kRobotReady,  ///< homed and disengaged, seen for the first time
  kPedalPressed,
  kPedalReleased,
  kPlanRequested,
  kPlanReady,
  kPlanFailed,
  kEmergencyStop,   ///< the robot's run level fell to E-STOP, or the model broke down
  kStopCleared,     ///< the robot left E-STOP
  kTimeSlip,        ///< simulated time was lost: a backlog too long to catch up
  kGoalWanted,      ///< the surgeon wants to show the model's goal
  kPlanArmed,       ///< the plan that is there shall be executed
  kPlanCancelled,   ///< choosing, planning or executing was given up
  kExecutionEnded,  ///< model and robot hold where they are
  kTrialEnded,      ///< the same of the model alone
};

/** The mode after an event; the mode itself if the table has no row for it. Real-time safe. */
Mode nextMode(Mode mode, Event event) noexcept;

}  // namespace raven2_trainer::control
