#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "raven2_trainer/core/types.h"

namespace raven2_trainer {

constexpr std::size_t kRavenChannels = 16;  ///< 8 a board: gold 0-7, green 8-15; 3 and 11 are not connected

/**
 * What the Raven's control software publishes of one cycle on /ravenstate (raven2.md 5.2), before its conversion to
 * that message's units: SI and radians here, degrees and micrometres at the wire. Channel order is the robot's own,
 * with the unconnected channels 3 and 11.
 */
struct RavenReport {
  std::uint64_t cycle{};                                  ///< control cycles since the program's start
  std::int32_t runlevel{}, sublevel{}, last_sequence{};   ///< last_seq; 111 before the first packet
  std::array<std::int32_t, kArmCount> board{};            ///< serial numbers: gold 49, green 22
  std::array<std::int32_t, 6> pos_um{};                   ///< [um] tip in each arm's base frame: gold xyz, green xyz
  std::array<std::int32_t, 6> pos_d_um{};                 ///< [um] wanted
  std::array<float, 18> ori{}, ori_d{};                   ///< [-] rotation matrices row by row: gold, green
  std::array<std::int32_t, kRavenChannels> encoder{};     ///< [counts] as the software reads them, after its negation
  std::array<std::int32_t, kRavenChannels> dac{};         ///< [counts] signed command after clipping
  std::array<double, kRavenChannels> tau{};               ///< [Nm] wanted torque at the capstan
  std::array<double, kRavenChannels> mpos{}, jpos{};      ///< [rad], [rad; m] motor and joint position
  std::array<double, kRavenChannels> mvel{}, jvel{};      ///< [rad/s], [rad/s; m/s]; jvel of tool joints stays 0 (2.6)
  std::array<double, kRavenChannels> mpos_d{}, jpos_d{};  ///< [rad], [rad; m] wanted
  std::array<double, kArmCount> grasp_d{};                ///< [rad] wanted opening
  std::array<float, kRavenChannels> encoder_offset{};     ///< [counts] found by homing
};
static_assert(std::is_trivially_copyable<RavenReport>::value, "crosses threads word by word");

}  // namespace raven2_trainer
