#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "raven2_trainer/core/types.h"

namespace raven2_trainer {

constexpr std::size_t kDetectorAxes = 3;  ///< shoulder, elbow, insertion

/** Largest values of fault-free runs, by percentile. */
struct DetectorThresholds {
  double acceleration{};    ///< [rad/s2] of the motor
  double motor_velocity{};  ///< [rad/s]
  double joint_velocity{};  ///< [rad/s; m/s]
};

/** Model of one motor axis, identified from commands and encoders alone. */
struct DetectorAxis {
  double inertia{};  ///< [kg m2] capstan torque per acceleration of the motor shaft, link included
  double viscous{};  ///< [Nms/rad]
  double coulomb{};  ///< [Nm]
  double offset{};   ///< [Nm] load at joints 0
  Vec3 gravity{};    ///< [Nm/rad, Nm/rad, Nm/m] change of the load with the joints
  DetectorThresholds published{}, departure{};  ///< thresholds of each rule
};

/** Condition of an alarm. */
enum class DetectorRule : std::uint8_t {
  kPublished,  ///< DSN 2016: one step ahead; all three quantities of a joint exceed their thresholds
  kDeparture,  ///< as above, with predicted changes of velocity; the tip also departs by `excursion`
};
constexpr std::array<const char*, 2> kDetectorRuleNames{"published", "departure"};

/** Reaction to an alarm. */
enum class Mitigation : std::uint8_t {
  kOff,   ///< nothing
  kHold,  ///< the last safe command replaces the command
  kStop,  ///< software E-stop
};
constexpr std::array<const char*, 3> kMitigationNames{"off", "hold", "stop"};

/** config/detector.yaml */
struct DetectorConfig {
  Mitigation mitigate{Mitigation::kOff};
  DetectorRule rule{DetectorRule::kDeparture};
  double factor{};          ///< [-] on all thresholds
  double memory{};          ///< [s] averaging time of a motor's mean velocity
  double braking_time{};    ///< [s] for which a gained velocity continues
  double asked{};           ///< [-] weight of the position error that a command within the clip stands for
  double persistence{};     ///< [s] assumed duration of a command beyond the clip
  double suspicion{};       ///< [-] size of a verdict from which an arm's motion is suspicious
  double suspicion_time{};  ///< [s] longest suspicion
  double excursion{};       ///< [m] threshold of the predicted departure of the tip
  PerArm<std::array<DetectorAxis, kDetectorAxes>> axes{};
};

}  // namespace raven2_trainer
