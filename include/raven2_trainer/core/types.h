#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

// Types that every module shares: arms, joints, ticks and the plain arrays that cross threads. Eigen types are not
// trivially copyable (Eigen 3.4), so shared structs use std::array; maths uses kinematics/eigen.h.

namespace raven2_trainer {

/** Count of 1 ms control periods. A session clock is negative before the first pedal-down. */
using Tick = std::int64_t;

constexpr double kTickSeconds = 0.001;                ///< [s] period of every 1 kHz loop
constexpr std::int64_t kTickNanoseconds = 1'000'000;  ///< [ns] the same
constexpr double kPi = 3.14159265358979323846;
constexpr double kDegree = kPi / 180.0;  ///< [rad]

/** The two arms. Index 0 is gold (left), 1 is green (right), as in an ITP packet (raven2: include/itp_teleoperation.h).
 */
enum class Arm : std::uint8_t { kGold = 0, kGreen = 1 };
constexpr std::size_t kArmCount = 2;
constexpr std::array<Arm, kArmCount> kArms{Arm::kGold, Arm::kGreen};
constexpr std::array<const char*, kArmCount> kArmNames{"gold", "green"};

/** The seven driven joints of an arm, in the order of all joint arrays. The robot's arrays have an eighth, unconnected
 *  slot at index 3, which ours omit. */
enum Joint : std::size_t { kShoulder, kElbow, kInsertion, kToolRotation, kWrist, kGrasp1, kGrasp2 };
constexpr std::size_t kJointCount = 7;
constexpr std::array<const char*, kJointCount> kJointNames{"shoulder", "elbow",  "insertion", "tool_rotation",
                                                           "wrist",    "grasp1", "grasp2"};

using JointArray = std::array<double, kJointCount>;  ///< one number per joint; rad or m (kInsertion) unless stated
using Vec3 = std::array<double, 3>;                  ///< x, y, z
using Quat = std::array<double, 4>;                  ///< unit quaternion, order x, y, z, w (ROS order)

constexpr Quat kIdentityQuat{0.0, 0.0, 0.0, 1.0};

/** One value for each arm, indexed with `at(values, Arm::kGold)`. */
template <typename T>
using PerArm = std::array<T, kArmCount>;

constexpr std::size_t index(Arm arm) noexcept {
  return static_cast<std::size_t>(arm);
}
constexpr Arm otherArm(Arm arm) noexcept {
  return arm == Arm::kGold ? Arm::kGreen : Arm::kGold;
}

template <typename T>
constexpr T& at(PerArm<T>& values, Arm arm) noexcept {
  return values[index(arm)];
}

template <typename T>
constexpr const T& at(const PerArm<T>& values, Arm arm) noexcept {
  return values[index(arm)];
}

constexpr const char* name(Arm arm) noexcept {
  return kArmNames[index(arm)];
}

/** Position and orientation of one frame in another; the variable's name names both. */
struct RigidPose {
  Vec3 p{};               ///< [m]
  Quat q{kIdentityQuat};  ///< unit, x y z w
};

/** The names of a table's rows. */
template <typename Row, std::size_t N>
constexpr std::array<const char*, N> namesOf(const std::array<Row, N>& rows) noexcept {
  std::array<const char*, N> names{};
  for (std::size_t i = 0; i < N; ++i)
    names[i] = rows[i].name;
  return names;
}

}  // namespace raven2_trainer
