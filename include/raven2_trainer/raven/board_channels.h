#pragma once

#include <cstddef>
#include <cstdint>

#include "raven2_trainer/core/types.h"

// How joints are wired to the channels of a USB board, with the signs of the tool style `raven` and OPPOSE_GRIP
// (raven2.md 2.3, 3.1, 3.4). The emulated boards of `plant` need the same facts.

namespace raven2_trainer::raven {

/** Channel of a joint: slot 3 of a board is not connected. */
constexpr std::size_t channelOf(std::size_t joint) noexcept {
  return joint <= kInsertion ? joint : joint + 1;
}

/** Gear ratio between motor and capstan: maxon GP42 49/4, tools GP32 26/7. */
constexpr double gearRatio(std::size_t joint) noexcept {
  return joint <= kInsertion ? 49.0 / 4.0 : 26.0 / 7.0;
}

/** Sign of the torque at the capstan for a positive DAC command. */
constexpr double torqueSign(Arm arm, std::size_t joint) noexcept {
  if (joint == kGrasp1) return 1.0;
  if (joint > kInsertion) return -1.0;
  return arm == Arm::kGold ? -1.0 : 1.0;
}

/** Sign of the motor position for a positive count on the wire. The software negates what it reads, negates all gold
 *  joints and green's tool joints once more, and grasp1 a third time (raven2 dof.cpp, state_estimate.cpp). */
constexpr std::int32_t encoderSign(Arm arm, std::size_t joint) noexcept {
  if (joint == kGrasp1) return -1;
  return arm == Arm::kGold || joint > kInsertion ? 1 : -1;
}

/** [rad] of the motor shaft per encoder count: 4000 counts a revolution. */
constexpr double kMotorRadPerCount = 2.0 * kPi / 4000.0;

/** Bits of the output byte, software to PLC (raven2.md 4.3). */
namespace pins {
constexpr std::uint8_t kLevelMask = 0x03;  ///< run level echo
constexpr std::uint8_t kFootPedal = 0x04;
constexpr std::uint8_t kReady = 0x08;
constexpr std::uint8_t kWatchdog = 0x10;
constexpr unsigned kLevelShift = 6;  ///< of the input byte: PLC run level in bits 6 and 7
}  // namespace pins

}  // namespace raven2_trainer::raven
