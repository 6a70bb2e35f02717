#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <type_traits>

#include "raven2_trainer/core/types.h"

// A fault as data, for threads, the TCP link and the log. core/fault_variables.h has the variables; module `faults`
// applies faults.

namespace raven2_trainer {

/** Process that applies a fault; it decides which parts are deceived. */
enum class FaultHost : std::uint8_t {
  kRobot,    ///< the robot's control software: model and surgeon are not affected
  kRelay,    ///< the daemon, on the stream to the robot: the model is not affected (paper, 3.2)
  kMaster,   ///< the daemon, on the masters' stream: model and robot both follow it
  kConsole,  ///< the daemon, on the surgeon's force and image
};
constexpr std::size_t kFaultHostCount = 4;
constexpr std::array<const char*, kFaultHostCount> kFaultHostNames{"robot", "relay", "master", "console"};

/** Where a fault acts: in a function of the robot's control program (raven2.md 4.2), or around that program. */
enum class FaultSite : std::uint8_t {
  kNone,
  kNetworkLayer,       ///< packets: behind the robot's recvfrom, on the relayed stream or on the masters' stream
  kGetUsbPacket,       ///< the boards' packets, before the control loop reads them
  kAtmelInputs,        ///< the PLC's pins as the control program sees them
  kStateMachine,       ///< the run level that it uses
  kStateEstimate,      ///< motor positions and velocities
  kForwardCoupling,    ///< joints from motors
  kForwardKinematics,  ///< the tip from joints
  kInverseKinematics,  ///< desired tip and joints
  kCableCoupling,      ///< desired motor positions
  kController,         ///< torques and gains
  kTorqueToDac,        ///< DAC commands, before the robot checks them
  kAtmelOutputs,       ///< pins for the PLC
  kPutUsbPacket,       ///< DAC commands and pins, after all checks of the robot
  kStateReturn,        ///< the state as sent to the daemon
  kHaptic,             ///< the force
  kVideo,              ///< the image
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
  kDrift,       ///< add an offset that grows to `value` in `ramp_ticks`, then stays
  kRandom,      ///< uniform in [low, high), drawn each time
  kRandomOnce,  ///< the same, drawn once per occurrence of the fault, then stuck
  kHoldLast,    ///< the number before onset: frozen
  // streams (packets, frames, images)
  kDrop,       ///< each is lost with probability `value`
  kDelay,      ///< each arrives [low, high] ticks later, in order
  kDuplicate,  ///< each arrives 1 + `value` times
  kReorder,    ///< blocks of `value` arrive in reverse order
  kReplay,     ///< repeats the motion of the last `value` before onset, with the true sequence numbers
  kForge,      ///< a forged one follows each: sequence number `low` ahead, motion `value` along `channel`
  kImpair,     ///< a bad network: preset number `value` of config/impairments
  // the whole program
  kCrash,  ///< the program ends at once
  kHang,   ///< the program stops, its process remains
};
constexpr std::size_t kFaultKindCount = 20;
constexpr std::array<const char*, kFaultKindCount> kFaultKindNames{
    "none",    "stuck_at", "add",         "add_and_hold", "scale", "sign_flip", "ramp",
    "drift",   "random",   "random_once", "hold_last",    "drop",  "delay",     "duplicate",
    "reorder", "replay",   "forge",       "impair",       "crash", "hang"};

/** Kinds for numbers; the others are for streams and programs. */
constexpr bool isNumberKind(FaultKind kind) noexcept {
  return kind >= FaultKind::kStuckAt && kind <= FaultKind::kHoldLast;
}
constexpr bool isStreamKind(FaultKind kind) noexcept {
  return kind >= FaultKind::kDrop && kind <= FaultKind::kImpair;
}

/** Variable that a fault changes; each belongs to one site. */
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

/** Values of kPicture: faults of the surgeon's image. A damaged log can contain any other number. */
enum class PictureFault : std::uint8_t {
  kNone,
  kBlack,
  kFrozen,
  kEyesSwapped,  ///< each eye sees the other eye's image
};
constexpr std::size_t kPictureFaultCount = 4;

/** Start of a fault's clock. */
enum class FaultTrigger : std::uint8_t {
  kPedalDown,       ///< the host's first pedal-down cycle; the fault then waits until the pedal is down
  kPowerOn,         ///< the host's first cycle
  kHand,            ///< the host's first cycle with the armed fault
  kPacket,          ///< the host's first pedal-down packet; the fault starts with a packet (lastsForPackets())
  kRunLevel,        ///< run level `threshold` is reached
  kTissueDistance,  ///< a tip is at most `threshold` [m] from tissue
  kTargetDistance,  ///< a tip is at most `threshold` [m] from the exercise's target
  kStep,            ///< the exercise has reached step `threshold`; the fault then waits until the pedal is down
  kToolChange,      ///< the tool-change button
};
constexpr std::size_t kFaultTriggerCount = 9;
constexpr std::array<const char*, kFaultTriggerCount> kFaultTriggerNames{
    "pedal_down",      "power_on",        "hand", "packet",     "run_level",
    "tissue_distance", "target_distance", "step", "tool_change"};

/** One armed fault. A tick is the host's 1 ms cycle. With trigger kPacket, `first_tick` and `period_ticks` count
 *  packets. The other times then count packets too if lastsForPackets(), else cycles. */
struct Fault {
  std::uint32_t id{};  ///< identifies the scenario across processes; 0: no fault
  FaultHost host{FaultHost::kRobot};
  FaultSite site{FaultSite::kNone};
  FaultVariable variable{FaultVariable::kNone};
  FaultKind kind{FaultKind::kNone};
  FaultTrigger trigger{FaultTrigger::kPedalDown};
  std::int8_t arm{-1};               ///< 0 gold, 1 green, -1 both
  std::int8_t channel{-1};           ///< of the variable; -1 all
  std::uint8_t row{};                ///< row of its scenario
  std::uint32_t arming{};            ///< counts armings: the same scenario, armed again, starts again
  std::int64_t first_tick{};         ///< [ticks] earliest start, on the trigger's clock
  std::int64_t duration_ticks{};     ///< [ticks] length: 300 means 300 cycles; 0 = until cleared
  std::int64_t period_ticks{};       ///< [ticks] repeat every; 0 = once
  std::int64_t count{};              ///< number of occurrences; 0 = no limit
  std::int64_t half_period_ticks{};  ///< [ticks] acts and rests in turn for this long; 0 = never rests
  std::int64_t ramp_ticks{};         ///< [ticks] kRamp
  double threshold{};                ///< by trigger
  double probability{1.0};           ///< [0, 1] of each occurrence, drawn when it is due
  std::uint64_t seed{};              ///< of probability, kRandom, kDrop, kDelay
  double value{};                    ///< in the variable's unit, or by kind
  double low{}, high{};              ///< as `value`
};

constexpr std::size_t kMaxFaults = 8;

/** All faults armed now. `generation` changes whenever the list does. */
struct FaultPlan {
  std::uint64_t generation{};
  /** Session of the sender. A new session restarts a robot's triggers; the same session continues them. */
  std::uint32_t session{};
  std::uint32_t count{};
  std::uint8_t is_suspended{};  ///< 1: the sender is disconnected; faults pause, their clocks run. Not sent.
  std::array<Fault, kMaxFaults> faults{};
};

/** A row of a plan began or stopped acting. */
struct FaultChange {
  std::uint64_t number{};   ///< counts the host's changes from 1; a missing number is a lost change
  std::uint64_t cycle{};    ///< [1 ms] on the host's clock: first cycle in which it acts, or no longer acts
  std::uint32_t session{};  ///< FaultPlan::session; not recorded
  std::uint32_t id{};       ///< Fault::id
  FaultHost host{FaultHost::kRobot};
  std::uint8_t row{};   ///< Fault::row
  std::uint8_t acts{};  ///< 1 began, 0 stopped
};

/** Inputs of triggers other than cycles and pedals. */
struct FaultSignals {
  double tissue_distance{std::numeric_limits<double>::infinity()};  ///< [m] of the nearer tip
  double target_distance{std::numeric_limits<double>::infinity()};  ///< [m] of the nearer tip
  std::uint32_t step{};                                             ///< of the exercise; 0 before its timer starts
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
