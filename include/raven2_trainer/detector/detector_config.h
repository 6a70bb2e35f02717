#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "raven2_trainer/core/types.h"

namespace raven2_trainer {

constexpr std::size_t kDetectorAxes = 3;  ///< shoulder, elbow, insertion

/** Largest values of fault-free runs. */
struct DetectorThresholds {
  double acceleration{};    ///< [rad/s2] of the motor
  double motor_velocity{};  ///< [rad/s]
  double joint_velocity{};  ///< [rad/s; m/s]
};

/** What the detector believes of one motor axis, identified from commands and encoders alone. */
struct DetectorAxis {
  double inertia{};  ///< [kg m2] capstan torque by acceleration of the motor shaft, link included
  double viscous{};  ///< [Nms/rad]
  double coulomb{};  ///< [Nm]
  double offset{};   ///< [Nm] that the axis needs at joints 0
  Vec3 gravity{};    ///< [Nm/rad, Nm/rad, Nm/m] by which that changes with the joints
  DetectorThresholds published{}, departure{};  ///< for each rule
};

/** What an alarm takes. */
enum class DetectorRule : std::uint8_t {
  kPublished,  ///< DSN 2016: one step ahead, the three quantities of a joint agree
  kDeparture,  ///< the same of the velocities that the command leads to, and the tip departs by `excursion`
};
constexpr std::array<const char*, 2> kDetectorRuleNames{"published", "departure"};

/** What an alarm does. */
enum class Mitigation : std::uint8_t {
  kOff,   ///< nothing
  kHold,  ///< the last safe command is written in its place
  kStop,  ///< software E-stop
};
constexpr std::array<const char*, 3> kMitigationNames{"off", "hold", "stop"};

/** config/detector.yaml */
struct DetectorConfig {
  Mitigation mitigate{Mitigation::kOff};
  DetectorRule rule{DetectorRule::kDeparture};
  double factor{};          ///< [-] on all thresholds
  double memory{};          ///< [s] over which a motor's mean velocity is taken
  double braking_time{};    ///< [s] for which velocity gained carries on
  double asked{};           ///< [-] weight of a position error that a command within the clip stands for
  double persistence{};     ///< [s] that a command beyond the clip is taken to last
  double suspicion{};       ///< [-] of an alarm's size, from which on an arm's motion is not taken to be the surgeon's
  double suspicion_time{};  ///< [s] for which, at most
  double excursion{};       ///< [m] predicted departure of the tip
  PerArm<std::array<DetectorAxis, kDetectorAxes>> axes{};
};

}  // namespace raven2_trainer
