#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <type_traits>
#include <vector>

#include "raven2_trainer/core/axis_map.h"
#include "raven2_trainer/core/state_cell.h"
#include "raven2_trainer/core/types.h"

// Haptic devices as masters: how a file of config/masters describes them, their messages, and the messages to them.

namespace raven2_trainer {

/** The driver: determines the message of forces. */
enum class DeviceFamily : std::uint8_t {
  kOmni,      ///< omni_msgs
  kGeomagic,  ///< geomagic_control of WPI
  kCrtk,      ///< CRTK: sawSensablePhantom, the dVRK's MTM
  kJoy,       ///< a gamepad: its axes are velocities; it feels nothing
};
/** Properties of a family: a row for each, in the order of DeviceFamily. Its forces' messages: kForceForms in
 * ros/devices/master_devices.cpp. */
struct FamilyTraits {
  const char* name;
  bool has_axes;            ///< a gamepad: velocities instead of poses; it feels nothing
  bool stamps_samples;      ///< a sample without a time is not valid
  bool holds_device;        ///< a force takes the device from the controller that holds it: not before a hand has it
  bool subtracts_velocity;  ///< its driver subtracts 0.001 N s/mm times the velocity, at each message
};
constexpr std::array<FamilyTraits, 4> kFamilies{{
    {"omni", false, false, false, true},
    {"geomagic", false, false, false, true},
    {"crtk", false, true, true, false},
    {"joy", true, false, false, false},
}};
constexpr const FamilyTraits& traitsOf(DeviceFamily family) noexcept {
  return kFamilies[static_cast<std::size_t>(family)];
}

/** Source of the pedal that engages. */
enum class PedalFrom : std::uint8_t {
  kLeft,   ///< a button of the left device
  kRight,  ///< of the right one
  kAny,    ///< of either
  kAll,    ///< of both at once
  kTopic,  ///< of a separate sensor_msgs/Joy
};
constexpr std::array<const char*, 5> kPedalFromNames{"left", "right", "any", "all", "topic"};

/** Source of the jaws' opening. */
enum class GripperFrom : std::uint8_t {
  kNone,
  kToggles,  ///< a button: each press, open or closed
  kHolds,    ///< a button: closed while it is held
  kJoint,    ///< the gripper's joint
  kAxis,     ///< an axis of a Joy
};
constexpr std::array<const char*, 5> kGripperFromNames{"none", "button_toggles", "button_holds", "joint", "axis"};

/** One device, by its topics; an empty one is not there. */
struct DeviceTopics {
  bool is_used{false};
  std::string pose;                  ///< with a gamepad: its sensor_msgs/Joy
  std::vector<std::string> buttons;  ///< one topic: its buttons; several: the first of each
  std::string gripper;               ///< sensor_msgs/JointState, its first joint
  std::string operating_state;       ///< crtk_msgs/OperatingState
  std::string force;
  std::string force_absolute;        ///< std_msgs/Bool: sent true once, for forces in the axes of the base
  std::string gravity_compensation;  ///< std_msgs/Bool: sent true once: a device that only feels forces does not sink
  std::array<int, 3> sticks{};       ///< axes of a Joy that are velocities along x, y, z
  int gripper_input{-1};             ///< number of the button or of the Joy's axis; -1 none
};

/** A file of config/masters. */
struct MasterConfig {
  std::string name;
  DeviceFamily family{DeviceFamily::kOmni};
  PerArm<DeviceTopics> devices;       ///< left is gold, right is green
  double scale{};                     ///< [-] motion of the tool to that of the device
  double metres_per_unit{1.0};        ///< [m] of the positions that the driver publishes
  AxisMap axes{};                     ///< of positions and forces
  bool orientation{false};            ///< turns count, too
  AxisMap turn_axes{};                ///< of orientations
  Vec3 workspace{};                   ///< [m] size of the device's workspace along its x, y, z
  double reach{};                     ///< [m] no position is farther from the device's origin
  double max_speed{}, max_jump{};     ///< [m/s], [m] more than both together from one pose to the next is a jump
  double max_turn_rate{};             ///< [rad/s] the same of orientations
  double max_turn_jump{};             ///< [rad]
  double watch{};                     ///< [s] poses are looked at before the first pedal-down counts
  double silent_after{};              ///< [s]
  double frozen_after{};              ///< [s] with the same pose, engaged; 0 never
  double stick_speed{}, dead_band{};  ///< [m/s] of the hand at an axis' end, [-] of an axis
  PedalFrom pedal_from{PedalFrom::kAny};
  int pedal_button{};
  std::string pedal_topic;
  double pedal_silent_after{};  ///< [s] of its topic, held; 0 never: it sends changes alone
  GripperFrom gripper_from{GripperFrom::kNone};
  double jaws_open{}, jaws_closed{};        ///< [rad] of the tool's jaws
  double jaw_speed{};                       ///< [rad/s]
  double reading_open{}, reading_closed{};  ///< of the gripper's joint or axis
  double max_force{};                       ///< [N]
  double force_per_newton{1.0};             ///< what the driver takes for 1 N
  double force_rate{};                      ///< [1/s] messages
};

/** The last data of a device, as published. */
struct DeviceSample {
  std::uint32_t poses{};  ///< messages so far
  Vec3 position{};        ///< the device's units and axes
  Quat orientation{kIdentityQuat};
  std::uint32_t buttons{};       ///< bit i: button i is held
  std::uint32_t axis_count{};    ///< of a Joy
  std::array<double, 8> axes{};  ///< of a Joy
  double gripper{};              ///< reading of the gripper's joint
  std::uint8_t has_gripper{};    ///< 1: one has come
  std::uint8_t is_ready{1};      ///< 0: its operating state does not say that it is enabled and homed
  std::uint8_t is_stateless{};   ///< 1: nor anything else: it has one, and none has come
  std::uint8_t is_locked{};      ///< 1: the driver holds it where it is
};

/** A pedal with its own topic. */
struct FootPedal {
  std::uint8_t is_held{};
};

/** Force of a device on the hand. */
struct DeviceForce {
  Vec3 force{};              ///< the driver's units, the device's axes
  Vec3 position{};           ///< where the device was last, in its units and axes; always finite
  std::uint8_t is_placed{};  ///< 1: it was somewhere
  std::uint8_t has_begun{};  ///< 1: the pedal has counted once
};

enum class DeviceTrouble : std::uint8_t {
  kNone,
  kNeverHeard,     ///< no pose has come
  kSilent,         ///< [s] none comes any more
  kNoState,        ///< no operating state has come
  kNotReady,       ///< the operating state is not enabled and homed
  kLocked,         ///< the driver says that it holds the device; only reported
  kNotFinite,      ///< a number of the pose is NaN or infinite
  kNotUnit,        ///< [-] norm of the quaternion
  kMillimetres,    ///< [m] positions so large that they must be millimetres
  kOutOfReach,     ///< [m] beyond the device's reach
  kTooWide,        ///< [m] moved through more than five times the workspace
  kMetres,         ///< [m] positions so small that they must be metres
  kJump,           ///< [m] from one pose to the next
  kTurnJump,       ///< [rad] the same of the orientation
  kNeverMoved,     ///< the pose has not changed since the start
  kFrozen,         ///< [s] it has not changed while engaged; only reported: one of two devices may rest
  kTooSoon,        ///< poses were not looked at for long enough
  kRobotNotReady,  ///< nobody to move
};

/** Whether the pedal counts as up with it. */
constexpr bool liftsPedal(DeviceTrouble trouble) noexcept {
  return trouble != DeviceTrouble::kNone && trouble != DeviceTrouble::kLocked && trouble != DeviceTrouble::kFrozen;
}

/** A finding, with its figure. */
struct DeviceFinding {
  DeviceTrouble trouble{DeviceTrouble::kNone};
  double value{};
};

/** Report of the hands on the devices. */
struct MasterReport {
  std::uint8_t pedal{};            ///< 1: it is held
  std::uint8_t engaged{};          ///< 1: and it counts
  std::uint32_t engagements{};     ///< pedal-downs so far that counted
  PerArm<std::uint32_t> found{};   ///< new findings so far, and those that a pedal-down met
  PerArm<DeviceFinding> newest{};  ///< of these
  PerArm<DeviceFinding> now{};
  PerArm<double> hand_force{};  ///< [N] that each device gets
};
static_assert(std::is_trivially_copyable<DeviceSample>::value && std::is_trivially_copyable<MasterReport>::value,
              "cross threads");

/** Between the thread that hears the devices and the one that moves the hands. */
struct MasterLink {
  // written by the thread of the devices' messages
  PerArm<StateCell<DeviceSample>> samples;
  // written by the thread that publishes forces
  StateCell<FootPedal> pedal;
  // written by the console
  PerArm<StateCell<DeviceForce>> forces;
  // written by the console
  StateCell<MasterReport> report;
};

/** "left" or "right". */
constexpr const char* deviceName(Arm arm) noexcept {
  return arm == Arm::kGold ? "left" : "right";
}

/** A line for an operator: which device, what is wrong, and what it most likely is. Empty for kNone. */
std::string words(const MasterConfig& config, Arm arm, const DeviceFinding& finding);

/**
 * A line for an operator whose master moves the tool by another scale than `console_scale`, which is what a daemon of
 * the same configuration takes for it. Empty if they are the same.
 */
std::string wordsOfScale(const MasterConfig& config, double console_scale);

}  // namespace raven2_trainer
