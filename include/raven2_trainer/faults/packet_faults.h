#pragma once

#include <array>
#include <cstdint>

#include "raven2_trainer/core/command.h"
#include "raven2_trainer/faults/fault_engine.h"

// Faults on what one packet says, in the units of the wire. Real-time safe.

namespace raven2_trainer::faults {

/** [um] [@frame I] */
std::array<std::int32_t, 3> faultedIncrement(FaultEngine* engine, Arm arm, std::array<std::int32_t, 3> um) noexcept;

/** Elements as they come (`quaternion`), then the rotation as a rotation vector (`turn`): any four numbers in and out.
 * */
Quat faultedRotation(FaultEngine* engine, Arm arm, const Quat& q) noexcept;

std::uint32_t faultedSequence(FaultEngine* engine, std::uint32_t sequence) noexcept;

/** Everything in a command that is a number. Increments become whole micrometres, the grasp whole milliradians. A
 *  rotation may become invalid: the receiver judges it. */
void applyToCommand(FaultEngine* engine, MasterCommand* command) noexcept;

}  // namespace raven2_trainer::faults
