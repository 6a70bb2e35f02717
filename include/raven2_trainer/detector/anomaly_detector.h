#pragma once

#include <array>
#include <cstdint>

#include "raven2_trainer/core/types.h"
#include "raven2_trainer/detector/detector_config.h"
#include "raven2_trainer/kinematics/arms_config.h"

namespace raven2_trainer::detector {

constexpr std::size_t kAxes = kDetectorAxes;  ///< shoulder, elbow, insertion: the first three joints, as in DSN 2016

/** Constants of the drives from the robot's control software. None comes from the emulated plant. */
struct Drives {
  ArmGeometry geometry{};
  PerArm<Vec3> torque_per_count{};            ///< [Nm/count] at the capstan, by arm and axis, signed
  std::array<Vec3, kAxes> joint_per_motor{};  ///< [rad/rad; m/rad] cable coupling; one row per joint
  Vec3 position_gain{};                       ///< [Nm/rad] kp of the control law, in motor space
  Vec3 clip{};                                ///< [counts] dac_clip: the overdrive check reduces larger commands
                                              ///< to it. Its E-stop limit, max_inst_dac, is not used here
};

/** State of both arms in one control cycle, before its command is written. */
struct Observation {
  PerArm<JointArray> motor{};                     ///< [rad] measured
  PerArm<JointArray> q{};                         ///< [rad; m] the robot's joints, computed from `motor`
  PerArm<std::array<std::int32_t, kAxes>> dac{};  ///< [counts] command to the positioning joints, not yet written
  bool engaged{};                                 ///< PEDAL_DN: brakes off, motors may move
};

/** Predicted effect of the command on one axis. Velocities: rule `published` predicts them one control step ahead; rule
 *  `departure` divides the predicted departure from the surgeon's motion by `braking_time`. */
struct Prediction {
  double acceleration{};    ///< [rad/s2] of the motor, in this cycle
  double motor_velocity{};  ///< [rad/s]
  double joint_velocity{};  ///< [rad/s; m/s]
};

/** Bits of Verdict::agreeing: the quantities that exceed DetectorConfig::factor times their thresholds. */
namespace agreeing {
constexpr std::uint8_t kAcceleration = 1, kMotorVelocity = 2, kJointVelocity = 4, kAll = 7;
}

/** Outcome of one step. */
struct Verdict {
  bool alarm{};
  Arm arm{Arm::kGold};
  std::uint8_t joint{};     ///< the joint nearest to an alarm
  std::uint8_t agreeing{};  ///< bits of that joint's quantities
  double size{};            ///< [-] least ratio of that joint's quantities to their thresholds; with rule `departure`
                            ///< also of `excursion` to DetectorConfig::excursion. Above DetectorConfig::factor: alarm
  double excursion{};       ///< [m] predicted departure of that arm's tip; its threshold: DetectorConfig::excursion
  PerArm<bool> alarms{};    ///< of each arm, also of the one that is not the nearest to an alarm
};

/**
 * Whether an arm's motion counts as a fault's motion. The control law soon opposes a fault and so hides it, so
 * suspicion must last. It begins with a command within the clip whose size exceeds DetectorConfig::suspicion, if no
 * such command and none beyond the clip came during the last `memory`. It ends when the predicted departure of the tip
 * is at most DetectorConfig::suspicion times DetectorConfig::excursion, or after `suspicion_time`. A command beyond the
 * clip ends it, too: motion under such a command counts as a fault's without suspicion. Real-time safe.
 */
class Suspicion {
 public:
  explicit Suspicion(const DetectorConfig& config) noexcept;

  bool holds() const noexcept { return age_ > 0; }
  /** @param[in] size largest Verdict::size of the arm's joints. @param[in] departs predicted departure of the tip
   * divided by DetectorConfig::excursion. */
  void step(double size, double departs, bool is_beyond_clip) noexcept;
  void forget() noexcept { age_ = calm_ = 0; }

 private:
  double threshold_;      // [-] DetectorConfig::suspicion
  int longest_, memory_;  // [ticks]
  int age_{0};            // [ticks] since the suspicion began
  int calm_{0};           // [ticks] since the last command that was suspicious or beyond the clip, at most memory_
};

/**
 * Detects unsafe motor commands before they are written, as in Alemzadeh et al., DSN 2016. A model of each motor axis
 * predicts the effect of a command from the measured state. An alarm needs three quantities of one of the first three
 * joints beyond their thresholds in the same step: motor acceleration, motor velocity and joint velocity. The
 * thresholds are learnt from fault-free runs. The model treats each axis alone (inertia, viscous and Coulomb friction,
 * gravity linear in the joints). Its parameters are identified from commands and encoders alone.
 *
 * Rule `departure` deviates from DSN 2016: see Prediction. In addition, the predicted departure of the tip must exceed
 * DetectorConfig::excursion (doc/detector.md). All thresholds are multiplied by DetectorConfig::factor, this one too.
 *
 * Real-time safe: no allocation, no locks, no throw. One object serves both arms.
 */
class AnomalyDetector {
 public:
  AnomalyDetector(const DetectorConfig& config, const Drives& drives) noexcept;

  /** Call in each control cycle. Without `engaged` there is no alarm, and the memory is cleared. The first engaged
   * cycle gives no alarm. */
  const Verdict& step(const Observation& now) noexcept;

  const Verdict& verdict() const noexcept { return verdict_; }
  /** Prediction of the last engaged step. */
  const Prediction& prediction(Arm arm, std::size_t axis) const noexcept { return at(predictions_, arm)[axis]; }
  double excursion(Arm arm) const noexcept { return at(excursion_, arm); }  ///< [m] as Verdict::excursion

 private:
  void predict(Arm arm, const Observation& now) noexcept;
  void observe(Arm arm, const Observation& now) noexcept;
  double departure(Arm arm, std::size_t axis, const Observation& now) const noexcept;
  bool isBeyondClip(std::size_t axis, std::int32_t dac) const noexcept;
  bool isPublished() const noexcept { return config_.rule == DetectorRule::kPublished; }
  void judge(Arm arm) noexcept;
  double judgeAxis(Arm arm, std::size_t axis, double departs) noexcept;  // returns the axis's size
  void forget(const Observation& now) noexcept;

  DetectorConfig config_;
  Drives drives_;
  double forgetting_;  ///< [-] share of the mean velocity that one step replaces
  bool warm_{false};
  PerArm<Vec3> last_motor_{};     // [rad]
  PerArm<Vec3> velocity_{};       // [rad/s]
  PerArm<Vec3> mean_velocity_{};  // [rad/s] over `memory`, without motion under commands beyond the clip
  PerArm<Vec3> surgeons_{};       // [rad/s] mean_velocity_, frozen under suspicion: the surgeon's motion
  PerArm<Vec3> travelled_{};      // [rad] travel beyond the surgeon's motion, under suspicion or beyond the clip
  PerArm<std::array<bool, kAxes>> was_beyond_{};
  PerArm<Suspicion> suspicion_;
  PerArm<std::array<Prediction, kAxes>> predictions_{};
  PerArm<double> excursion_{};  // [m] predicted departure of the tip
  Verdict verdict_{};
};

/**
 * Acceleration [rad/s2] of a motor axis under a capstan torque [Nm] at a velocity [rad/s]. An axis slower than half an
 * encoder count per cycle is at rest: friction then opposes the torque, up to its Coulomb value. Real-time safe.
 * @param[in] q joints [rad; m], for gravity.
 */
double acceleration(const DetectorAxis& axis, double torque, double velocity, const JointArray& q) noexcept;

}  // namespace raven2_trainer::detector
