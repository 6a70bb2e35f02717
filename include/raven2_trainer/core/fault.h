#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <type_traits>

#include "raven2_trainer/core/types.h"

// Faults as data: for threads (a StateCell copies them word by word), the TCP link from daemon to virtual Raven, and
// the log. core/fault_variables.h has the table of the variables: site, name, unit, elements, range, meaning. Module
// `faults` applies faults.

namespace raven2_trainer {

/** Where a fault is applied. */
enum class FaultHost : std::uint8_t {
  kRobot,    ///< the robot's control software: affects the robot, not the model
  kRelay,    ///< the daemon, on the stream to the robot: affects the robot, not the model (Li et al. 2017, 3.2)
  kMaster,   ///< the daemon, on the masters' stream: affects model and robot
  kConsole,  ///< the daemon, on force and image: affects only the surgeon
};
constexpr std::size_t kFaultHostCount = 4;
constexpr std::array<const char*, kFaultHostCount> kFaultHostNames{"robot", "relay", "master", "console"};

/** Where a fault acts: in a function of the robot's control program (raven2.md 4.2), or around that program. */
enum class FaultSite : std::uint8_t {
  kNone,
  kNetworkLayer,       ///< packets: after the robot's recvfrom, on the stream to the robot, or on the masters' stream
  kGetUsbPacket,       ///< the boards' packets, before the control loop reads them
  kAtmelInputs,        ///< the PLC's pins as the control program sees them
  kStateMachine,       ///< the run level that the control program uses
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

/** How a fault changes its variable. */
enum class FaultKind : std::uint8_t {
  kNone,
  // numbers
  kStuckAt,     ///< overwrite with `value`
  kAdd,         ///< add `value` to each number
  kAddAndHold,  ///< hold the number at onset plus `value`
  kScale,       ///< multiply by `value`
  kSignFlip,    ///< multiply by -1
  kRamp,        ///< from the number at onset to `value` in `ramp_ticks`, then hold `value`
  kDrift,       ///< add an offset that grows to `value` in `ramp_ticks`, then stays
  kRandom,      ///< overwrite with a number from [low, high), uniform, drawn each time
  kRandomOnce,  ///< the same, drawn once per occurrence, then held
  kHoldLast,    ///< the number before onset; streams: repeat the last content, sequence numbers continue
  // streams (packets, state frames)
  kDrop,       ///< each is lost with probability `value`
  kDelay,      ///< each arrives [low, high] ticks later, in order
  kDuplicate,  ///< each arrives 1 + `value` times
  kReorder,    ///< blocks of `value` arrive in reverse order
  kReplay,     ///< motion of the last `value` packets before onset, repeated; sequence numbers continue
  kForge,      ///< each gets a forged successor: sequence number + `low`, motion `value` [um] along `channel`
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

/** Kinds for variables that are numbers, kHoldLast included. */
constexpr bool isNumberKind(FaultKind kind) noexcept {
  return kind >= FaultKind::kStuckAt && kind <= FaultKind::kHoldLast;
}
/** Kinds for streams alone. Streams also take kHoldLast. */
constexpr bool isStreamKind(FaultKind kind) noexcept {
  return kind >= FaultKind::kDrop && kind <= FaultKind::kImpair;
}

/** Variable that a fault changes. Comments name its site. */
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

/** Event in the host that starts a fault's clock. */
enum class FaultTrigger : std::uint8_t {
  kPedalDown,       ///< first pedal-down cycle; a fault that is due waits while the pedal is up
  kPowerOn,         ///< first cycle
  kHand,            ///< first cycle in which the fault is armed
  kPacket,          ///< first pedal-down packet; from it on the clock counts packets, also pedal-up ones
  kRunLevel,        ///< run level `threshold` is reached
  kTissueDistance,  ///< a tip is at most `threshold` [m] from tissue
  kTargetDistance,  ///< a tip is at most `threshold` [m] from the exercise's target
  kStep,            ///< the exercise reaches step `threshold`; a fault that is due waits as with kPedalDown
  kToolChange,      ///< an operator reports a tool change
};
constexpr std::size_t kFaultTriggerCount = 9;
constexpr std::array<const char*, kFaultTriggerCount> kFaultTriggerNames{
    "pedal_down",      "power_on",        "hand", "packet",     "run_level",
    "tissue_distance", "target_distance", "step", "tool_change"};

/** One armed fault. A tick is the host's 1 ms cycle. With trigger kPacket, `first_tick` and `period_ticks` count
 *  packets. The other times then count packets, too, if lastsForPackets() (core/fault_variables.h), else cycles.
 *  Packets, before faults change them: kRobot: those that the robot receives; kRelay: those for the robot; kMaster:
 *  those that the physics loop takes from the masters and from CRTK clients. */
struct Fault {
  std::uint32_t id{};  ///< identifies the scenario in all processes; 0: no fault
  FaultHost host{FaultHost::kRobot};
  FaultSite site{FaultSite::kNone};
  FaultVariable variable{FaultVariable::kNone};
  FaultKind kind{FaultKind::kNone};
  FaultTrigger trigger{FaultTrigger::kPedalDown};
  std::int8_t arm{-1};               ///< 0 gold, 1 green, -1 both
  std::int8_t channel{-1};           ///< element of the variable; -1 all
  std::uint8_t row{};                ///< row of the scenario
  std::uint32_t arming{};            ///< changes if the scenario is armed again, so that it restarts
  std::int64_t first_tick{};         ///< [ticks] when it is due first, on the trigger's clock
  std::int64_t duration_ticks{};     ///< [ticks] of an occurrence; 0 = until cleared
  std::int64_t period_ticks{};       ///< [ticks] from one occurrence to the next; 0 = only once
  std::int64_t count{};              ///< with a period: number of occurrences; 0 = no limit
  std::int64_t half_period_ticks{};  ///< [ticks] it acts and rests in turn for this long; 0 = never rests
  std::int64_t ramp_ticks{};         ///< [ticks] of kRamp and kDrift
  double threshold{};                ///< by FaultTrigger
  double probability{1.0};           ///< [0, 1] that a due occurrence acts
  std::uint64_t seed{};              ///< of all draws: probability, kRandom, kRandomOnce, kDrop, kDelay
  double value{};                    ///< in the variable's unit, or by FaultKind
  double low{}, high{};              ///< likewise
};

constexpr std::size_t kMaxFaults = 8;

/** All faults armed now. `generation` changes whenever the list does. */
struct FaultPlan {
  std::uint64_t generation{};
  /** Run of the daemon that sent the plan. A new run restarts the robot's triggers except kPowerOn. */
  std::uint32_t session{};
  std::uint32_t count{};
  std::uint8_t is_suspended{};  ///< 1: the daemon is disconnected; no fault acts, but clocks run. Not transmitted.
  std::array<Fault, kMaxFaults> faults{};
};

/** A fault of the plan began or stopped acting. */
struct FaultChange {
  std::uint64_t number{};   ///< of the host's changes, from 1; a missing number is a lost change
  std::uint64_t cycle{};    ///< [1 ms] on the host's clock: first cycle with the fault, or first without it
  std::uint32_t session{};  ///< FaultPlan::session; not in the log
  std::uint32_t id{};       ///< Fault::id
  FaultHost host{FaultHost::kRobot};
  std::uint8_t row{};   ///< Fault::row
  std::uint8_t acts{};  ///< 1 began, 0 stopped
};

/** Inputs of kTissueDistance, kTargetDistance, kStep and kToolChange. */
struct FaultSignals {
  double tissue_distance{std::numeric_limits<double>::infinity()};  ///< [m] of the nearer tip
  double target_distance{std::numeric_limits<double>::infinity()};  ///< [m] of the nearer tip
  std::uint32_t step{};                                             ///< of the exercise; 0 before its timer starts
  std::uint32_t tool_changes{};                                     ///< tool changes reported so far
};
static_assert(std::is_trivially_copyable<FaultPlan>::value && std::is_trivially_copyable<FaultSignals>::value &&
                  std::is_trivially_copyable<FaultChange>::value,
              "cross threads word by word");

constexpr bool operator==(const FaultSignals& a, const FaultSignals& b) noexcept {
  return a.tissue_distance == b.tissue_distance && a.target_distance == b.target_distance && a.step == b.step &&
         a.tool_changes == b.tool_changes;
}

}  // namespace raven2_trainer
