#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <type_traits>
#include <vector>

#include "raven2_trainer/core/axis_map.h"
#include "raven2_trainer/core/state_cell.h"
#include "raven2_trainer/core/types.h"

// Haptic devices as masters: their files in config/masters, and the data from and to their drivers.

namespace raven2_trainer {

/** Driver of a device; determines the type of force messages. */
enum class DeviceFamily : std::uint8_t {
  kOmni,      ///< omni_msgs
  kGeomagic,  ///< geomagic_control of WPI
  kCrtk,      ///< CRTK: sawSensablePhantom, the dVRK's MTM
  kJoy,       ///< a gamepad (sensor_msgs/Joy), without force
};
/** Properties of a family, in the order of DeviceFamily. Types of force messages: kForceForms in
 * ros/devices/master_devices.cpp. */
struct FamilyTraits {
  const char* name;
  bool has_axes;        ///< its axes are velocities; it has no poses and no force
  bool stamps_samples;  ///< a pose without a time stamp is invalid
  bool holds_device;  ///< a force message takes the device from the controller that holds it, so it gets none before a
                      ///< pedal-down counts
  bool subtracts_velocity;  ///< from each force its driver subtracts 0.001 N s/mm times the device's velocity
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

/** Device whose button is the pedal. */
enum class PedalFrom : std::uint8_t {
  kLeft,
  kRight,
  kAny,    ///< either of them
  kAll,    ///< both at once
  kTopic,  ///< a separate sensor_msgs/Joy
};
constexpr std::array<const char*, 5> kPedalFromNames{"left", "right", "any", "all", "topic"};

/** Source of the jaws' opening. */
enum class GripperFrom : std::uint8_t {
  kNone,
  kToggles,  ///< a button: each press opens or closes, in turn
  kHolds,    ///< a button: closed while it is held
  kJoint,    ///< the gripper's joint
  kAxis,     ///< an axis of a Joy
};
constexpr std::array<const char*, 5> kGripperFromNames{"none", "button_toggles", "button_holds", "joint", "axis"};

/** Topics of one device; empty: no such topic. */
struct DeviceTopics {
  bool is_used{false};
  std::string pose;                  ///< of a gamepad: its Joy
  std::vector<std::string> buttons;  ///< one topic: all its buttons; several: the first button of each
  std::string gripper;               ///< sensor_msgs/JointState, its first joint
  std::string operating_state;       ///< crtk_msgs/OperatingState
  std::string force;
  std::string force_absolute;        ///< std_msgs/Bool, true sent once: forces are in the axes of the base
  std::string gravity_compensation;  ///< std_msgs/Bool, true sent once: the driver compensates the device's weight
  std::array<int, 3> sticks{};       ///< Joy axes for velocities along x, y, z
  int gripper_input{-1};             ///< number of the button or Joy axis; -1: no input
};

/** A file of config/masters. */
struct MasterConfig {
  std::string name;
  DeviceFamily family{DeviceFamily::kOmni};
  PerArm<DeviceTopics> devices;    ///< left moves gold, right green
  double scale{};                  ///< [-] tool motion divided by device motion
  double metres_per_unit{1.0};     ///< [m] unit of the driver's positions
  AxisMap axes{};                  ///< of positions and forces
  bool orientation{false};         ///< true: rotations of the device rotate the tool
  AxisMap turn_axes{};             ///< of orientations
  Vec3 workspace{};                ///< [m] size along the device's x, y, z
  double reach{};                  ///< [m] largest distance from the device's origin
  double max_speed{}, max_jump{};  ///< [m/s], [m] a step over max_jump + max_speed x time since the last pose is a jump
  double max_turn_rate{};          ///< [rad/s] as max_speed, for the orientation
  double max_turn_jump{};          ///< [rad] as max_jump, for the orientation
  double watch{};                  ///< [s] poses are checked for this long before the first pedal-down counts
  double silent_after{};           ///< [s] without a pose, after which the pedal counts as up
  double frozen_after{};           ///< [s] with an unchanged pose while engaged, after which this is reported; 0: never
  double stick_speed{}, dead_band{};  ///< [m/s] hand speed at full deflection; [-] share of an axis without effect
  PedalFrom pedal_from{PedalFrom::kAny};
  int pedal_button{};
  std::string pedal_topic;
  double pedal_silent_after{};  ///< [s] held without a message, after which it counts as up; 0: never, for pedals that
                                ///< send only changes
  GripperFrom gripper_from{GripperFrom::kNone};
  double jaws_open{}, jaws_closed{};        ///< [rad] of the tool's jaws
  double jaw_speed{};                       ///< [rad/s]
  double reading_open{}, reading_closed{};  ///< value of the gripper's joint or axis when open, when closed
  double max_force{};                       ///< [N]
  double force_per_newton{1.0};             ///< the driver's value for 1 N
  double force_rate{};                      ///< [1/s] force messages
};

/** Newest data that a driver published. */
struct DeviceSample {
  std::uint32_t poses{};  ///< pose messages so far
  Vec3 position{};        ///< the device's units and axes
  Quat orientation{kIdentityQuat};
  std::uint32_t buttons{};       ///< bit i: button i is held
  std::uint32_t axis_count{};    ///< of a Joy
  std::array<double, 8> axes{};  ///< of a Joy
  double gripper{};              ///< of its joint
  std::uint8_t has_gripper{};    ///< 1: `gripper` was received
  std::uint8_t is_ready{1};      ///< 0: operating state unknown, or not enabled and homed
  std::uint8_t is_stateless{};   ///< 1: no operating state received yet, though it has the topic
  std::uint8_t is_locked{};      ///< 1: the driver holds it in place
};

/** A pedal with a separate topic. */
struct FootPedal {
  std::uint8_t is_held{};
};

/** Force message to a device. */
struct DeviceForce {
  Vec3 force{};              ///< the driver's units, the device's axes
  Vec3 position{};           ///< last finite position, in the device's units and axes
  std::uint8_t is_placed{};  ///< 1: `position` is known
  std::uint8_t has_begun{};  ///< 1: a pedal-down has counted
};

/** A problem; [unit] of DeviceFinding::value. */
enum class DeviceTrouble : std::uint8_t {
  kNone,
  kNeverHeard,     ///< no pose received yet
  kSilent,         ///< [s] since the last pose
  kNoState,        ///< no operating state received yet
  kNotReady,       ///< the operating state is not enabled and homed
  kLocked,         ///< the driver reports that it holds the device; only a warning
  kNotFinite,      ///< NaN or infinity in the pose or the axes
  kNotUnit,        ///< [-] norm of the quaternion
  kMillimetres,    ///< [m] positions so large that they must be millimetres
  kOutOfReach,     ///< [m] beyond the device's reach
  kTooWide,        ///< [m] extent of all its positions along one axis, more than five times the workspace's
  kMetres,         ///< [m] positions so small that they must be metres
  kJump,           ///< [m] step from one pose to the next
  kTurnJump,       ///< [rad] rotation from one pose to the next
  kNeverMoved,     ///< the pose has not changed since the start
  kFrozen,         ///< [s] pose unchanged while engaged; only a warning, as one of two devices may rest
  kTooSoon,        ///< poses checked for less than `watch`
  kRobotNotReady,  ///< the robot is not ready
};

/** True if the pedal counts as up with this problem. */
constexpr bool liftsPedal(DeviceTrouble trouble) noexcept {
  return trouble != DeviceTrouble::kNone && trouble != DeviceTrouble::kLocked && trouble != DeviceTrouble::kFrozen;
}

/** A problem with its value. */
struct DeviceFinding {
  DeviceTrouble trouble{DeviceTrouble::kNone};
  double value{};
};

/** Pedal and devices, for the operator and /diagnostics. */
struct MasterReport {
  std::uint8_t pedal{};            ///< 1: it is held
  std::uint8_t engaged{};          ///< 1: it is held and counts
  std::uint32_t engagements{};     ///< pedal-downs that counted
  PerArm<std::uint32_t> found{};   ///< problems so far: new ones, and those that refused a pedal-down
  PerArm<DeviceFinding> newest{};  ///< the last of them
  PerArm<DeviceFinding> now{};     ///< problem in this tick
  PerArm<double> hand_force{};     ///< [N] sent to each device
};
static_assert(std::is_trivially_copyable<DeviceSample>::value && std::is_trivially_copyable<MasterReport>::value,
              "cross threads");

/** Data between the two ROS threads and the console's thread. */
struct MasterLink {
  // written by the thread that receives the devices' messages
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

/** A line for the operator: device, problem, likely cause. Empty for kNone. */
std::string words(const MasterConfig& config, Arm arm, const DeviceFinding& finding);

/** A warning for the operator if the scale is not `console_scale` (config/console.yaml), which the daemon assumes; else
 * empty. */
std::string wordsOfScale(const MasterConfig& config, double console_scale);

}  // namespace raven2_trainer
