#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "raven2_trainer/core/types.h"
#include "raven2_trainer/wire/itp_rules.h"

namespace raven2_trainer {

/** The control software's parameters of one axis of the emulated robot. */
struct MotorAxis {
  double transmission{};    ///< [rad motor / rad joint; rad/m]
  double torque_per_amp{};  ///< [Nm/A] at the capstan
  double counts_per_amp{};  ///< [counts/A]
  double kp{};              ///< [Nm/rad] control software, motor space (raven2.md 3.6)
  double kd{};              ///< [Nms/rad]
  double ki{};              ///< [Nm/(rad s)]
  std::int32_t dac_clip{};  ///< [counts] (raven2.md 3.5)
};

/** What the overdrive check does with a command above its clip (raven2.md 4.5). */
enum class OverdrivePolicy : std::uint8_t {
  kSoft,  ///< clips
  kHard,  ///< stops the robot after more than 10 of them
  kNone,  ///< lets it pass
};
constexpr std::array<const char*, 3> kOverdrivePolicyNames{"SOFT", "HARD", "NONE"};

/** Drive of one axis of the emulated robot, DAC to link. Torques at the capstan, angles of the motor shaft. */
struct PlantAxis {
  double torque_gain{};      ///< [-] real torque per commanded torque
  double torque_offset{};    ///< [Nm] constant, towards growing motor angle
  double inertia{};          ///< [kg m2] of rotor and gear: capstan torque by shaft acceleration
  double coulomb{};          ///< [Nm] dry friction of motor and gear
  double viscous{};          ///< [Nms/rad] of motor and gear
  double link_coulomb{};     ///< [Nm; N] dry friction at the joint
  double link_viscous{};     ///< [Nms/rad; Ns/m] at the joint
  double cable_stiffness{};  ///< [N/m] force per stretch at the capstan; elastic cables only
  double cable_damping{};    ///< [Ns/m] elastic cables only
};

/** config/plants/NAME.yaml: how the emulated robot differs from its nominal model. */
struct PlantConfig {
  std::string title;
  bool elastic_cables{};      ///< false: joints rigidly coupled to the motors
  double amplifier_limit{};   ///< [V] saturation; 10 V are 32768 counts
  double amplifier_offset{};  ///< [A] current at command 0, every channel
  std::array<PlantAxis, kJointCount> axes{};
};

/** config/virtual_raven.yaml */
struct VirtualRavenConfig {
  std::string behaviour;  ///< compat: a real Raven's rules; hardened: those of `itp`
  ItpRules itp{};         ///< as network.yaml says
  std::array<MotorAxis, kJointCount> axes{};
  double green_insertion_kd{};    ///< [Nms/rad] the one gain that differs between the arms
  std::int32_t max_inst_dac{};    ///< [counts] overdrive threshold of any axis
  std::int64_t master_timeout{};  ///< [cycles]
  std::string training_level;     ///< set of thresholds and gains in force
  OverdrivePolicy overdrive_policy{OverdrivePolicy::kSoft};
  std::array<std::int32_t, kJointCount> homing_dac{};  ///< [counts] demand that means a hard stop (raven2.md 3.5)
  bool low_pass{};                                     ///< motor positions through the 120 Hz Butterworth (3.7)
  bool full_homing{};                                  ///< search the hard stops; else the joints are known at power-on
  bool gravity_compensation{};
  JointArray start_offset{};  ///< [rad, m] joints at power-on, relative to home
  double homing_time{};       ///< [s] half-cosine from there to home
  std::string plant_name;     ///< preset of plants_folder
  std::string plants_folder;  ///< absolute path
  PlantConfig plant{};
};

}  // namespace raven2_trainer
