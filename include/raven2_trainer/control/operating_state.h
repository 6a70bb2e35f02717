#pragma once

#include <optional>

#include "raven2_trainer/control/servo.h"

namespace raven2_trainer::control {

/**
 * CRTK's table of operating states (collaborative-robotics/documentation, api-operating-state). Real-time safe.
 * @return the state after a command, which may be `state` itself; nothing where the table calls the command invalid,
 * and for kHome and kUnhome, which it does not hold.
 */
std::optional<OperatingState> nextState(OperatingState state, StateCommand command) noexcept;

}  // namespace raven2_trainer::control
