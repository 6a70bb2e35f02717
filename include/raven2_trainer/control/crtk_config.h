#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>

#include "raven2_trainer/core/types.h"

namespace raven2_trainer {

/** Message types for CRTK clients. */
enum class CrtkDialect : std::uint8_t {
  kModern,     ///< crtk_msgs 1.3
  kRaven,      ///< the robot's own branch `crtk`: TransformStamped, messages of the retired package
  kTransform,  ///< as kModern, poses as TransformStamped: clients from before crtk_python_client 1.2 (2023)
};
constexpr std::array<const char*, 3> kCrtkDialectNames{"modern", "raven", "transform"};

/** config/crtk.yaml: the arms as CRTK devices (doc/crtk.md). */
struct CrtkConfig {
  bool enabled{};
  PerArm<std::string> names;  ///< namespace of each arm
  CrtkDialect dialect{};
  double period{};          ///< [s] between two states that are published
  double state_period{};    ///< [s] the operating state is repeated, changed or not
  double max_speed{};       ///< [m/s] of a tip after a servo command
  double max_turn_rate{};   ///< [rad/s] of it, and of a joint
  double max_step{};        ///< [m] a servo command may lead from the set point
  double max_step_turn{};   ///< [rad] the same
  double move_speed{};      ///< [m/s] highest of a move_*; at most max_speed
  double move_turn_rate{};  ///< [rad/s] the same
  double twist_timeout{};   ///< [s] servo_cv, servo_jv, servo_jf and servo_cf without another; see twistTimeout()
  double release_after{};   ///< [s] of silence after which the pedal goes up; 0 never
  double trim_time{};       ///< [s] constant in which a resting robot is brought nearer to the set point; 0 it is not
};

/** [s] The robot's own branch uses a velocity for one cycle (update_device_crtk_motion): the arm stops when its client does. Ours
 * bridges the pauses of a client at 10 Hz. */
constexpr double kRavenTwistTimeout = 0.1;

/** [s] After which a twist or a force ends without another. Clients of dialect `raven` end a twist by sending no more. */
inline double twistTimeout(const CrtkConfig& config) noexcept {
  const bool is_raven = config.dialect == CrtkDialect::kRaven;
  return is_raven ? std::min(config.twist_timeout, kRavenTwistTimeout) : config.twist_timeout;
}

}  // namespace raven2_trainer
