#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <type_traits>

#include "raven2_trainer/core/types.h"

// A fault as data: a row that crosses threads, the TCP link and the log. The variables are in
// core/fault_variables.h; module `faults` applies faults.

namespace raven2_trainer {

/** Whose process applies it, and so who is deceived. */
enum class FaultHost : std::uint8_t {
  kRobot,    ///< the robot's control software: model and surgeon stay clean
  kRelay,    ///< the daemon, on the stream to the robot: the model stays clean (paper, 3.2)
  kMaster,   ///< the daemon, on the masters' stream: model and robot both follow it
  kConsole,  ///< the daemon, on what the surgeon feels and sees
};
constexpr std::size_t kFaultHostCount = 4;
constexpr std::array<const char*, kFaultHostCount> kFaultHostNames{"robot", "relay", "master", "console"};

/** Where in the system a fault acts: functions of the robot's control program (raven2.md 4.2), and what surrounds it.
 */
enum class FaultSite : std::uint8_t {
  kNone,
  kNetworkLayer,       ///< packets: behind the robot's recvfrom, on the relayed stream or on the masters' stream
  kGetUsbPacket,       ///< what the boards sent, before the control loop reads it
  kAtmelInputs,        ///< the PLC's pins as the control program sees them
  kStateMachine,       ///< the run level it goes by
  kStateEstimate,      ///< motor positions and velocities
  kForwardCoupling,    ///< joints from motors
  kForwardKinematics,  ///< the tip from joints
  kInverseKinematics,  ///< wanted tip and joints
  kCableCoupling,      ///< wanted motor positions
  kController,         ///< torques and gains
  kTorqueToDac,        ///< DAC commands, before the robot's own check of them
  kAtmelOutputs,       ///< pins for the PLC
  kPutUsbPacket,       ///< DAC commands and pins, after all of the robot's own checks
  kStateReturn,        ///< the state as it is sent to the daemon
  kHaptic,             ///< the force
  kVideo,              ///< the picture
  kProcess,            ///< the control program as a whole
};
constexpr std::size_t kFaultSiteCount = 18;
constexpr std::array<const char*, kFaultSiteCount> kFaultSiteNames{"none",
                                                                   "network_layer",
                                                                   "get_usb_packet",
                                                                   "atmel_inputs",
                                                                   "state_machine",
                                                                   "state_estimate",
                                                                   "forward_coupling",
                                                                   "forward_kinematics",
                                                                   "inverse_kinematics",
                                                                   "cable_coupling",
                                                                   "controller",
                                                                   "torque_to_dac",
                                                                   "atmel_outputs",
                                                                   "put_usb_packet",
                                                                   "state_return",
                                                                   "haptic",
                                                                   "video",
                                                                   "process"};

/** Change of the variable. */
enum class FaultKind : std::uint8_t {
  kNone,
  // numbers
  kStuckAt,     ///< overwrite with `value`
  kAdd,         ///< add `value` each time
  kAddAndHold,  ///< the number at onset plus `value`, held
  kScale,       ///< multiply by `value`
  kSignFlip,    ///< multiply by -1
  kRamp,        ///< from the number at onset to `value` in `ramp_ticks`, then stuck there
  kDrift,       ///< add what grows to `value` in `ramp_ticks`, then stays
  kRandom,      ///< uniform in [low, high), drawn each time
  kRandomOnce,  ///< the same, drawn once for each time the fault comes, then stuck
  kHoldLast,    ///< the number before onset: frozen
  // streams (packets, frames, pictures)
  kDrop,       ///< each is lost with probability `value`
  kDelay,      ///< each comes [low, high] ticks later; none overtakes
  kDuplicate,  ///< each comes 1 + `value` times
  kReorder,    ///< blocks of `value` come in reverse order
  kReplay,     ///< the motion of the last `value` before onset, over and over, under the true numbers
  kForge,      ///< another follows each, its number `low` ahead, moving `value` along `channel`
  kImpair,     ///< a bad network: preset number `value` of config/impairments
  // the whole program
  kCrash,  ///< it ends at once
  kHang,   ///< it stops where it is, the process stays
};
constexpr std::size_t kFaultKindCount = 20;
constexpr std::array<const char*, kFaultKindCount> kFaultKindNames{
    "none",    "stuck_at", "add",         "add_and_hold", "scale", "sign_flip", "ramp",
    "drift",   "random",   "random_once", "hold_last",    "drop",  "delay",     "duplicate",
    "reorder", "replay",   "forge",       "impair",       "crash", "hang"};

/** Kinds that work on numbers, as apply() does; the others are for streams and programs. */
constexpr bool isNumberKind(FaultKind kind) noexcept {
  return kind >= FaultKind::kStuckAt && kind <= FaultKind::kHoldLast;
}
constexpr bool isStreamKind(FaultKind kind) noexcept {
  return kind >= FaultKind::kDrop && kind <= FaultKind::kImpair;
}

/** The variable; each belongs to one site. */
enum class FaultVariable : std::uint8_t {
  kNone,
  // network_layer
  kIncrement,
  kQuaternion,
  kTurn,
  kGrasp,
  kPedal,
  kSequence,
  kPacket,
  // get_usb_packet
  kGetBoardCount,
  kGetBoardIndex,
  kReadResult,
  kBuffer,
  kEncoder,
  // atmel_inputs
  kInputs,
  kPlcState,
  // state_machine
  kRunLevelDesired,
  // state_estimate
  kMpos,
  kMvel,
  // forward_coupling
  kJpos,
  kJvel,
  // forward_kinematics
  kPos,
  kOri,
  // inverse_kinematics
  kPosD,
  kJposD,
  // cable_coupling
  kMposD,
  // controller
  kTauD,
  kGain,
  // torque_to_dac
  kCurrentCmd,
  // atmel_outputs
  kSurgeonMode,
  kRunLevel,
  kInitialized,
  // put_usb_packet
  kPutBoardCount,
  kPutBoardIndex,
  kOutputs,
  kDac,
  // state_return
  kReturnedJpos,
  kReturnedRunLevel,
  kFrame,
  // haptic
  kForceGain,
  kForceOffset,
  // video
  kPicture,
  kPictureDelay,
  // process
  kProgram,
};
constexpr std::size_t kFaultVariableCount = 43;

/** Values of kPicture: what is done to the surgeon's picture. States and logs hold the number, and a damaged log any.
 */
enum class PictureFault : std::uint8_t {
  kNone,
  kBlack,
  kFrozen,
  kEyesSwapped,  ///< each eye of a pair sees what the other should
};
constexpr std::size_t kPictureFaultCount = 4;

/** From when a fault's clock runs. */
enum class FaultTrigger : std::uint8_t {
  kPedalDown,       ///< the first pedal-down cycle its host saw; it then waits for the pedal to be down
  kPowerOn,         ///< the host's first cycle
  kHand,            ///< the cycle that saw it armed
  kPacket,          ///< the first pedal-down packet its host saw; it starts with a packet (lastsForPackets())
  kRunLevel,        ///< run level `threshold` is reached
  kTissueDistance,  ///< a tip is at most `threshold` [m] from tissue
  kTargetDistance,  ///< a tip is at most `threshold` [m] from the exercise's target
  kStep,            ///< the exercise has reached step `threshold`; it then waits for the pedal to be down
  kToolChange,      ///< the tool-change button
};
constexpr std::size_t kFaultTriggerCount = 9;
constexpr std::array<const char*, kFaultTriggerCount> kFaultTriggerNames{
    "pedal_down",      "power_on",        "hand", "packet",     "run_level",
    "tissue_distance", "target_distance", "step", "tool_change"};

/** One armed fault. A tick is the host's own 1 ms cycle. With trigger kPacket `first_tick` and `period_ticks` count
 *  packets; the other times do so too where the variable is of packets, else they count cycles. */
struct Fault {
  std::uint32_t id{};  ///< names the scenario across processes; 0 is "no fault"
  FaultHost host{FaultHost::kRobot};
  FaultSite site{FaultSite::kNone};
  FaultVariable variable{FaultVariable::kNone};
  FaultKind kind{FaultKind::kNone};
  FaultTrigger trigger{FaultTrigger::kPedalDown};
  std::int8_t arm{-1};               ///< 0 gold, 1 green, -1 both
  std::int8_t channel{-1};           ///< of the variable; -1 all
  std::uint8_t row{};                ///< which of its scenario's rows
  std::uint32_t arming{};            ///< counts what was armed: the same scenario armed again begins again
  std::int64_t first_tick{};         ///< [ticks] earliest start, on the trigger's clock
  std::int64_t duration_ticks{};     ///< [ticks] length: 300 means 300 cycles; 0 = until cleared
  std::int64_t period_ticks{};       ///< [ticks] repeat every; 0 = once
  std::int64_t count{};              ///< number of times; 0 = for ever
  std::int64_t half_period_ticks{};  ///< [ticks] acts so long, rests so long, while it lasts; 0 = never rests
  std::int64_t ramp_ticks{};         ///< [ticks] kRamp
  double threshold{};                ///< by trigger
  double probability{1.0};           ///< [0, 1] that it comes, drawn each time it is due
  std::uint64_t seed{};              ///< of probability, kRandom, kDrop, kDelay
  double value{};                    ///< in the variable's unit, or by kind
  double low{}, high{};              ///< the same
};

constexpr std::size_t kMaxFaults = 8;

/** All faults armed now. `generation` changes whenever the list does. */
struct FaultPlan {
  std::uint64_t generation{};
  /** Session of the sender: a robot's triggers start again with another session, and go on with the same one. */
  std::uint32_t session{};
  std::uint32_t count{};
  std::uint8_t is_suspended{};  ///< 1: the sender is gone; nothing acts, time goes on. Not sent.
  std::array<Fault, kMaxFaults> faults{};
};

/** A row of a plan began to act, or ended. */
struct FaultChange {
  std::uint64_t number{};   ///< counts the changes of its host from 1; one that is missing was lost
  std::uint64_t cycle{};    ///< [1 ms] on its host's clock: first that it acts in, or first that it no longer acts in
  std::uint32_t session{};  ///< FaultPlan::session; not on record
  std::uint32_t id{};       ///< Fault::id
  FaultHost host{FaultHost::kRobot};
  std::uint8_t row{};   ///< Fault::row
  std::uint8_t acts{};  ///< 1 began, 0 ended
};

/** Data for triggers in addition to cycles and pedals; the exercise's runner writes them. */
struct FaultSignals {
  double tissue_distance{std::numeric_limits<double>::infinity()};  ///< [m] of the nearer tip
  double target_distance{std::numeric_limits<double>::infinity()};  ///< [m] of the nearer tip
  std::uint32_t step{};                                             ///< of the exercise; 0 before its timer
  std::uint32_t tool_changes{};                                     ///< presses of the button so far
};
static_assert(std::is_trivially_copyable<FaultPlan>::value && std::is_trivially_copyable<FaultSignals>::value &&
                  std::is_trivially_copyable<FaultChange>::value,
              "cross threads word by word");

constexpr bool operator==(const FaultSignals& a, const FaultSignals& b) noexcept {
  return a.tissue_distance == b.tissue_distance && a.target_distance == b.target_distance && a.step == b.step &&
         a.tool_changes == b.tool_changes;
}

}  // namespace raven2_trainer
