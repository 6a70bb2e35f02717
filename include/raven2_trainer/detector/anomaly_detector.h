#pragma once

#include <array>
#include <cstdint>

#include "raven2_trainer/core/types.h"
#include "raven2_trainer/detector/detector_config.h"
#include "raven2_trainer/kinematics/arms_config.h"

namespace raven2_trainer::detector {

constexpr std::size_t kAxes = kDetectorAxes;  ///< shoulder, elbow, insertion: the first three joints, as in DSN 2016

/** What the robot's own control software knows of its drives; nothing of the plant. */
struct Drives {
  ArmGeometry geometry{};
  PerArm<Vec3> torque_per_count{};            ///< [Nm/count] at the capstan, by arm and axis, signed
  std::array<Vec3, kAxes> joint_per_motor{};  ///< [rad/rad; m/rad] rows: joints
  Vec3 position_gain{};                       ///< [Nm/rad] kp of the control law, motor space
  Vec3 clip{};                                ///< [counts] largest command that passes the robot's own check
};

/** What is known in the cycle in which a command is about to be written. */
struct Observation {
  PerArm<JointArray> motor{};                     ///< [rad] measured
  PerArm<JointArray> q{};                         ///< [rad; m] the robot's joints from them
  PerArm<std::array<std::int32_t, kAxes>> dac{};  ///< [counts] positioning joints, about to be written
  bool engaged{};                                 ///< PEDAL_DN: brakes off, motors may move
};

/** What the command will do to one axis. Rule `published`: one control step ahead. Rule `departure`: the change against
 *  the motor's mean velocity of the last `memory` that the command leads to. */
struct Prediction {
  double acceleration{};    ///< [rad/s2] of the motor, now
  double motor_velocity{};  ///< [rad/s]
  double joint_velocity{};  ///< [rad/s; m/s]
};

/** Which of the three quantities are beyond their thresholds. */
namespace agreeing {
constexpr std::uint8_t kAcceleration = 1, kMotorVelocity = 2, kJointVelocity = 4, kAll = 7;
}

/** Outcome of one step. */
struct Verdict {
  bool alarm{};
  Arm arm{Arm::kGold};
  std::uint8_t joint{};     ///< the one that comes nearest to an alarm
  std::uint8_t agreeing{};  ///< bits of it, see above
  double size{};            ///< [-] factor on all thresholds at which an alarm would just cease; alarm: above `factor`
  double excursion{};       ///< [m] by which the command would make that arm's tip depart
};

/**
 * Whether an arm's motion is taken to be a fault's. It begins with a suspicious command in the range of the control law
 * after a calm `memory`, and lasts as long as the tip is predicted to be off, at most `suspicion_time`: the control law
 * soon fights the fault, which hides it. Commands beyond the clip have its own rule and end it. Real-time safe.
 */
class Suspicion {
 public:
  explicit Suspicion(const DetectorConfig& config) noexcept;

  bool holds() const noexcept { return age_ > 0; }
  /** @param[in] size of the arm's last verdict. @param[in] departs predicted departure of the tip over `excursion`. */
  void step(double size, double departs, bool is_beyond_clip) noexcept;
  void forget() noexcept { age_ = calm_ = 0; }

 private:
  double threshold_;
  int longest_, memory_;  // [ticks]
  int age_{0};            // [ticks] it has lasted
  int calm_{0};           // [ticks] since the last suspicious command or one beyond the clip, at most memory_
};

/**
 * Detector of unsafe commands after Alemzadeh et al., DSN 2016: a model of each motor axis predicts, from the measured
 * state and the command about to be written, what the command will do; an alarm needs motor acceleration, motor
 * velocity and joint velocity of one of the first three joints to be beyond thresholds learnt from fault-free runs, all
 * three in the same step.
 *
 * Deviation from the paper, rule `departure` (doc/detector.md says why): a velocity is what the command leads to, as a
 * change against the mean of the last `memory`; and the tip must be predicted to depart by more than `excursion`. The
 * model is of single axes (inertia, viscous and Coulomb friction, gravity linear in the joints), its parameters
 * identified from commands and encoders alone.
 *
 * Real-time safe: no allocation, no locks, no throw. Both arms share one object.
 */
class AnomalyDetector {
 public:
  AnomalyDetector(const DetectorConfig& config, const Drives& drives) noexcept;

  /** One control cycle. Not engaged: no alarm, and the memory is emptied. */
  const Verdict& step(const Observation& now) noexcept;

  const Verdict& verdict() const noexcept { return verdict_; }
  /** Of the last engaged step. */
  const Prediction& prediction(Arm arm, std::size_t axis) const noexcept { return at(predictions_, arm)[axis]; }
  double excursion(Arm arm) const noexcept { return at(excursion_, arm); }  ///< [m]

 private:
  void predict(Arm arm, const Observation& now) noexcept;
  void observe(Arm arm, const Observation& now) noexcept;
  double departure(Arm arm, std::size_t axis, const Observation& now) const noexcept;
  bool isBeyondClip(std::size_t axis, std::int32_t dac) const noexcept;
  bool isPublished() const noexcept { return config_.rule == DetectorRule::kPublished; }
  void judge(Arm arm) noexcept;
  double judgeAxis(Arm arm, std::size_t axis, double departs) noexcept;  // the size of its part
  void forget(const Observation& now) noexcept;

  DetectorConfig config_;
  Drives drives_;
  double forgetting_;  ///< [-] share of the mean velocity that a step replaces
  bool warm_{false};
  PerArm<Vec3> last_motor_{};     // [rad]
  PerArm<Vec3> velocity_{};       // [rad/s]
  PerArm<Vec3> mean_velocity_{};  // [rad/s] of `memory`, without what moved under commands beyond the clip
  PerArm<Vec3> surgeons_{};       // [rad/s] the same, but that it waits under suspicion
  PerArm<Vec3> travelled_{};      // [rad] against the surgeon's, as long as the motion is a fault's
  PerArm<std::array<bool, kAxes>> was_beyond_{};
  PerArm<Suspicion> suspicion_;
  PerArm<std::array<Prediction, kAxes>> predictions_{};
  PerArm<double> excursion_{};  // [m]
  Verdict verdict_{};
};

/**
 * Acceleration [rad/s2] of a motor axis under a capstan torque [Nm] at a velocity [rad/s]. Below half an encoder count
 * a cycle the axis counts as at rest: friction then opposes the torque, up to its Coulomb value. Real-time safe.
 * @param[in] q joints [rad; m], for gravity.
 */
double acceleration(const DetectorAxis& axis, double torque, double velocity, const JointArray& q) noexcept;

}  // namespace raven2_trainer::detector
