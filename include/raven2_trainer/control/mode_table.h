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
  kEmergencyStop,  ///< the robot's run level fell to E-STOP, or the model broke down
  kStopCleared,    ///< the robot left E-STOP
  kTimeSlip,       ///< simulated time was lost: a backlog too long to catch up
};

/** The mode after an event; the mode itself if the table has no row for it. Real-time safe. */
Mode nextMode(Mode mode, Event event) noexcept;

}  // namespace raven2_trainer::control
