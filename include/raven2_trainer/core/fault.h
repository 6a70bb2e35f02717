#pragma once

#include <array>
#include <cstdint>

#include "raven2_trainer/core/types.h"

// A fault as data: a row that crosses threads, the TCP link and the log. Whoever applies it is in module `faults`.

namespace raven2_trainer {

/** Where in the system a fault acts (paper, Table 1 column 4 and Figure 2). */
enum class FaultSite : std::uint8_t {
  kNone,
  kNetworkLayer,  ///< increments on their way to the robot: the relayed stream, or after the robot's recvfrom
  kGetUsbPacket,  ///< encoder counts, before the robot's control loop reads them
  kPutUsbPacket,  ///< DAC commands, after the robot's own safety checks
};
constexpr std::size_t kFaultSiteCount = 4;
constexpr std::array<const char*, kFaultSiteCount> kFaultSiteNames{"none", "network_layer", "get_usb_packet",
                                                                   "put_usb_packet"};

/** Whose process applies it. The relay corrupts what the robot gets while the model stays clean (paper, 3.2). */
enum class FaultHost : std::uint8_t { kRobot, kRelay };
constexpr std::array<const char*, 2> kFaultHostNames{"robot", "relay"};

/** What is done to the target variable (kinds of raven2_sim's generate_mfi2.py; more arrive with the library). */
enum class FaultKind : std::uint8_t {
  kNone,
  kStuckAt,   ///< overwrite with `value`
  kAdd,       ///< add `value`
  kScale,     ///< multiply by `value`
  kHoldLast,  ///< keep the value of the tick before the fault began
};
constexpr std::size_t kFaultKindCount = 5;
constexpr std::array<const char*, kFaultKindCount> kFaultKindNames{"none", "stuck_at", "add", "scale", "hold_last"};

/** Which variable at that site. */
enum class FaultTarget : std::uint8_t {
  kNone,
  kDac,        ///< [counts] of `joint`, at kPutUsbPacket
  kEncoder,    ///< [counts] of `joint`, at kGetUsbPacket
  kIncrement,  ///< [um] along ITP axis `joint` (0 x, 1 y, 2 z), at kNetworkLayer
  kPedal,      ///< surgeon_mode, at kNetworkLayer
};
constexpr std::size_t kFaultTargetCount = 5;
constexpr std::array<const char*, kFaultTargetCount> kFaultTargetNames{"none", "dac", "encoder", "increment", "pedal"};

/** One armed fault. Ticks count the host's own 1 ms cycles since the first pedal down that host saw. */
struct Fault {
  std::uint32_t id{};  ///< names the scenario across processes; 0 is "no fault"
  FaultSite site{FaultSite::kNone};
  FaultHost host{FaultHost::kRobot};
  FaultKind kind{FaultKind::kNone};
  FaultTarget target{FaultTarget::kNone};
  std::int8_t arm{-1};            ///< 0 gold, 1 green, -1 both
  std::int8_t joint{-1};          ///< Joint, or ITP axis; -1 all
  std::int64_t first_tick{};      ///< [1 ms] earliest start; waits for the next pedal-down tick
  std::int64_t duration_ticks{};  ///< [1 ms] length: 300 means 300 cycles
  std::int64_t period_ticks{};    ///< [1 ms] repeat every; 0 = once
  std::int64_t count{};           ///< number of times; 0 = for ever
  double value{};                 ///< [counts, um, -] by target and kind
};

constexpr std::size_t kMaxFaults = 8;

/** All faults armed now. `generation` changes whenever the list does. */
struct FaultPlan {
  std::uint64_t generation{};
  std::uint32_t count{};
  std::array<Fault, kMaxFaults> faults{};
};

}  // namespace raven2_trainer
