#pragma once

#include <array>
#include <cstddef>

#include "raven2_trainer/core/fault.h"

// The table of all variables that faults can change. The loader checks scenarios against it, the engine looks up sites
// in it, and doc/hazards.md shows it.

namespace raven2_trainer {

/** Names of a variable's elements. */
enum class FaultChannels : std::uint8_t { kOne, kJoints, kAxes, kQuaternion, kMatrix, kBytes };

struct FaultChannelNames {
  std::size_t count;
  std::array<const char*, 9> names;  ///< empty: numbers from 0
};

constexpr std::array<FaultChannelNames, 6> kFaultChannelNames{{
    {1, {}},
    {kJointCount, {"shoulder", "elbow", "insertion", "tool_rotation", "wrist", "grasp1", "grasp2"}},
    {3, {"x", "y", "z"}},
    {4, {"x", "y", "z", "w"}},
    {9, {"xx", "xy", "xz", "yx", "yy", "yz", "zx", "zy", "zz"}},
    {24, {}},
}};
constexpr std::size_t kMaxFaultChannels = 24;  ///< per arm

struct FaultVariableInfo {
  FaultVariable variable;
  FaultSite site;
  const char* name;
  const char* unit;
  FaultChannels channels;
  bool per_arm;
  double low, high;     ///< range of all kinds with a number except scale, in `unit`
  bool is_stream;       ///< packets or frames: accepts the kinds for streams
  const char* meaning;  ///< with its name in the robot's program
};

namespace fault_table {
using V = FaultVariable;
using S = FaultSite;
using C = FaultChannels;
constexpr double kInt32 = 2147483647.0;
constexpr double kBig = 1e9;
constexpr std::array<FaultVariableInfo, kFaultVariableCount> kFaultVariables{{
    {V::kNone, S::kNone, "none", "", C::kOne, false, 0, 0, false, "nothing"},
    {V::kIncrement, S::kNetworkLayer, "increment", "um", C::kAxes, true, -kInt32, kInt32, false,
     "delx, dely, delz of a packet, in the masters' axes"},
    {V::kQuaternion, S::kNetworkLayer, "quaternion", "-", C::kQuaternion, true, -kBig, kBig, false,
     "Qx, Qy, Qz, Qw of a packet, as they come"},
    {V::kTurn, S::kNetworkLayer, "turn", "rad", C::kAxes, true, -3.2, 3.2, false,
     "rotation vector of a packet's quaternion, in the masters' axes"},
    {V::kGrasp, S::kNetworkLayer, "grasp", "mrad", C::kOne, true, -kInt32, kInt32, false,
     "grasp of a packet; positive closes"},
    {V::kPedal, S::kNetworkLayer, "pedal", "-", C::kOne, false, -256, 256, false,
     "surgeon_mode of a packet; any other than 0 engages"},
    {V::kSequence, S::kNetworkLayer, "sequence", "-", C::kOne, false, 0, 4294967295.0, false, "number of a packet"},
    {V::kPacket, S::kNetworkLayer, "packet", "-", C::kAxes, true, 0, 0, true, "the packets themselves"},
    {V::kGetBoardCount, S::kGetUsbPacket, "board_count", "-", C::kOne, false, -100, 100, false,
     "activeAtStart: boards that are read; 2 is right"},
    {V::kGetBoardIndex, S::kGetUsbPacket, "board_index", "-", C::kOne, true, -100, 100, false,
     "boards[i]: which board is read for an arm; 0 gold and 1 green are right"},
    {V::kReadResult, S::kGetUsbPacket, "read_result", "-", C::kOne, true, -200, 27, false,
     "what read() returned; anything but 27 is an error"},
    {V::kBuffer, S::kGetUsbPacket, "buffer", "-", C::kBytes, true, -128, 255, false,
     "the 24 bytes of counts in a board's packet"},
    {V::kEncoder, S::kGetUsbPacket, "encoder", "counts", C::kJoints, true, -8388608, 8388607, false,
     "encoder counts as the board sent them"},
    {V::kInputs, S::kAtmelInputs, "inputs", "-", C::kOne, true, 0, 255, false,
     "mech.inputs: the pins that carry the PLC's run level in bits 6 and 7"},
    {V::kPlcState, S::kAtmelInputs, "plc_state", "-", C::kOne, false, 0, 3, false,
     "PLCState as it is shown; nothing acts on it"},
    {V::kRunLevelDesired, S::kStateMachine, "run_level_desired", "-", C::kOne, false, 0, 3, false,
     "rlDesired: the level that the boards' pins ask for"},
    {V::kMpos, S::kStateEstimate, "mpos", "rad", C::kJoints, true, -1e6, 1e6, false, "motor position"},
    {V::kMvel, S::kStateEstimate, "mvel", "rad/s", C::kJoints, true, -1e6, 1e6, false, "motor velocity"},
    {V::kJpos, S::kForwardCoupling, "jpos", "rad, m", C::kJoints, true, -1e6, 1e6, false, "joint position"},
    {V::kJvel, S::kForwardCoupling, "jvel", "rad/s, m/s", C::kJoints, true, -1e6, 1e6, false,
     "joint velocity, which is only shown"},
    {V::kPos, S::kForwardKinematics, "pos", "um", C::kAxes, true, -kInt32, kInt32, false,
     "tip position, arm base frame"},
    {V::kOri, S::kForwardKinematics, "ori", "-", C::kMatrix, true, -kBig, kBig, false,
     "elements of the tip's rotation matrix"},
    {V::kPosD, S::kInverseKinematics, "pos_d", "um", C::kAxes, true, -kInt32, kInt32, false,
     "wanted tip position, arm base frame"},
    {V::kJposD, S::kInverseKinematics, "jpos_d", "rad, m", C::kJoints, true, -1e6, 1e6, false, "wanted joint position"},
    {V::kMposD, S::kCableCoupling, "mpos_d", "rad", C::kJoints, true, -1e6, 1e6, false, "wanted motor position"},
    {V::kTauD, S::kController, "tau_d", "Nm", C::kJoints, true, -1e6, 1e6, false, "torque at the capstan"},
    {V::kGain, S::kController, "gain", "-", C::kJoints, true, -1e3, 1e3, false,
     "factor on the controller's kp, kd and ki; 1 is right"},
    {V::kCurrentCmd, S::kTorqueToDac, "current_cmd", "counts", C::kJoints, true, -1e6, 1e6, false,
     "DAC command, before the robot checks it"},
    {V::kSurgeonMode, S::kAtmelOutputs, "surgeon_mode", "-", C::kOne, false, 0, 1, false,
     "the pedal as sent to the PLC"},
    {V::kRunLevel, S::kAtmelOutputs, "run_level", "-", C::kOne, false, 0, 3, false,
     "run level as sent to the PLC; it sets the PLC's pins"},
    {V::kInitialized, S::kAtmelOutputs, "initialized", "-", C::kOne, false, 0, 1, false, "READY as sent to the PLC"},
    {V::kPutBoardCount, S::kPutUsbPacket, "board_count", "-", C::kOne, false, -100, 100, false,
     "activeAtStart: boards that are written; 2 is right, more reach beyond the array"},
    {V::kPutBoardIndex, S::kPutUsbPacket, "board_index", "-", C::kOne, true, -100, 100, false,
     "boards[i]: which board is written for an arm; 0 gold and 1 green are right"},
    {V::kOutputs, S::kPutUsbPacket, "outputs", "-", C::kOne, true, -20000, 20000, false,
     "mech.outputs: all pins for the PLC, watchdog among them; the low 8 bits are sent"},
    {V::kDac, S::kPutUsbPacket, "dac", "counts", C::kJoints, true, -1e6, 1e6, false,
     "DAC command after all checks; the low 16 bits are sent"},
    {V::kReturnedJpos, S::kStateReturn, "jpos", "rad, m", C::kJoints, true, -1e6, 1e6, false,
     "joint positions as sent to the daemon"},
    {V::kReturnedRunLevel, S::kStateReturn, "run_level", "-", C::kOne, false, 0, 3, false,
     "run level as sent to the daemon"},
    {V::kFrame, S::kStateReturn, "frame", "-", C::kOne, false, 0, 0, true, "the state frames themselves"},
    {V::kForceGain, S::kHaptic, "force_gain", "-", C::kOne, true, -10, 10, false,
     "factor on the force before the limits of size and slew; 1 is right"},
    {V::kForceOffset, S::kHaptic, "force_offset", "N", C::kAxes, true, -3.3, 3.3, false,
     "added to the force before these limits, arm base frame; 0 is right"},
    {V::kPicture, S::kVideo, "picture", "-", C::kOne, false, 0, kPictureFaultCount - 1, false,
     "the surgeon's picture: 0 is right, 1 black, 2 frozen, 3 the eyes swapped"},
    {V::kPictureDelay, S::kVideo, "picture_delay", "ms", C::kOne, false, 0, 5000, false,
     "by which the surgeon's picture is late; 0 is right"},
    {V::kProgram, S::kProcess, "program", "-", C::kOne, false, 0, 0, false,
     "the emulated control program: it ends, or stops where it is"},
}};

}  // namespace fault_table

using fault_table::kFaultVariables;

constexpr const FaultVariableInfo& infoOf(FaultVariable variable) noexcept {
  return kFaultVariables[static_cast<std::size_t>(variable)];
}

constexpr const FaultChannelNames& channelsOf(FaultVariable variable) noexcept {
  return kFaultChannelNames[static_cast<std::size_t>(infoOf(variable).channels)];
}

/** Whether the table is in the order of the enumeration. */
constexpr bool isFaultTableInOrder() noexcept {
  for (std::size_t i = 0; i < kFaultVariableCount; ++i) {
    if (static_cast<std::size_t>(kFaultVariables[i].variable) != i) return false;
  }
  return true;
}
static_assert(isFaultTableInOrder(), "infoOf() finds a variable by its number");

/** Whether a variable is a whole number in the robot's program or on the wire. */
constexpr bool isWhole(FaultVariable variable) noexcept {
  switch (variable) {
    case FaultVariable::kQuaternion:
    case FaultVariable::kTurn:
    case FaultVariable::kMpos:
    case FaultVariable::kMvel:
    case FaultVariable::kJpos:
    case FaultVariable::kJvel:
    case FaultVariable::kOri:
    case FaultVariable::kJposD:
    case FaultVariable::kMposD:
    case FaultVariable::kTauD:
    case FaultVariable::kGain:
    case FaultVariable::kReturnedJpos:
    case FaultVariable::kForceGain:
    case FaultVariable::kForceOffset:
      return false;
    default:
      return true;
  }
}

/** Whether a fault's duration counts packets, not cycles: a packet triggers it and carries its variable. */
constexpr bool lastsForPackets(const Fault& fault) noexcept {
  return fault.trigger == FaultTrigger::kPacket && infoOf(fault.variable).site == FaultSite::kNetworkLayer;
}

/** Whether a variable accepts a kind. */
bool takes(FaultVariable variable, FaultKind kind) noexcept;

/** Whether all fields are valid, from any sender: finite numbers, known enumerations and channels, matching site,
 *  variable and kind, times up to 2^42 ticks, and stream counts within the limits below. */
bool isSound(const Fault& fault) noexcept;

constexpr double kMaxStreamDelay = 500;  ///< [ticks] longest delay of a stream; [packets] longest replay
constexpr double kMaxFaultFactor = 1e6;  ///< for kScale
constexpr double kMaxDuplicates = 8;
constexpr double kMaxReordered = 64;
constexpr double kMaxForgedAhead = 1e6;

/** Whether a host applies faults at a site. */
constexpr bool serves(FaultHost host, FaultSite site) noexcept {
  if (site == FaultSite::kHaptic || site == FaultSite::kVideo) return host == FaultHost::kConsole;
  if (site == FaultSite::kNetworkLayer) return host != FaultHost::kConsole;
  return host == FaultHost::kRobot;
}

}  // namespace raven2_trainer
