#pragma once

#include <array>
#include <cstdint>

#include "raven2_trainer/core/types.h"
#include "raven2_trainer/detector/detector_config.h"
#include "raven2_trainer/kinematics/arms_config.h"

namespace raven2_trainer::detector {

constexpr std::size_t kAxes = kDetectorAxes;  ///< shoulder, elbow, insertion: the first three joints, as in DSN 2016

/** Constants of the drives that the robot's control software knows. It contains nothing of the plant. */
struct Drives {
  ArmGeometry geometry{};
  PerArm<Vec3> torque_per_count{};            ///< [Nm/count] at the capstan, by arm and axis, signed
  std::array<Vec3, kAxes> joint_per_motor{};  ///< [rad/rad; m/rad] rows: joints
  Vec3 position_gain{};                       ///< [Nm/rad] kp of the control law, in motor space
  Vec3 clip{};                                ///< [counts] largest command that passes the robot's own check
};

/** State in one cycle, before the command is written. */
struct Observation {
  PerArm<JointArray> motor{};                     ///< [rad] measured
  PerArm<JointArray> q{};                         ///< [rad; m] the robot's joints, computed from `motor`
  PerArm<std::array<std::int32_t, kAxes>> dac{};  ///< [counts] command to the positioning joints, not yet written
  bool engaged{};                                 ///< PEDAL_DN: brakes off, motors may move
};

/** Predicted effect of the command on one axis. Rule `published`: one control step ahead. Rule `departure`: the change
 *  that the command causes against the motor's mean velocity over `memory`. */
struct Prediction {
  double acceleration{};    ///< [rad/s2] of the motor, in this cycle
  double motor_velocity{};  ///< [rad/s]
  double joint_velocity{};  ///< [rad/s; m/s]
};

/** Bits of the quantities that exceed their thresholds. */
namespace agreeing {
constexpr std::uint8_t kAcceleration = 1, kMotorVelocity = 2, kJointVelocity = 4, kAll = 7;
}

/** Outcome of one step. */
struct Verdict {
  bool alarm{};
  Arm arm{Arm::kGold};
  std::uint8_t joint{};     ///< the joint nearest to an alarm
  std::uint8_t agreeing{};  ///< bits of that joint's quantities, see above
  double size{};            ///< [-] largest factor on all thresholds with an alarm; larger than `factor` means alarm
  double excursion{};       ///< [m] predicted departure of that arm's tip
};

/**
 * Whether an arm's motion counts as a fault's motion. Suspicion begins with a suspicious command within the clip after
 * a calm `memory`. It lasts while the predicted departure of the tip is too large, at most `suspicion_time`: the
 * control law soon opposes the fault, and so hides it. Commands beyond the clip have their own rule and end the
 * suspicion. Real-time safe.
 */
class Suspicion {
 public:
  explicit Suspicion(const DetectorConfig& config) noexcept;

  bool holds() const noexcept { return age_ > 0; }
  /** @param[in] size of the arm's last verdict. @param[in] departs predicted departure of the tip divided by
   *  `excursion`. */
  void step(double size, double departs, bool is_beyond_clip) noexcept;
  void forget() noexcept { age_ = calm_ = 0; }

 private:
  double threshold_;
  int longest_, memory_;  // [ticks]
  int age_{0};            // [ticks] since the suspicion began
  int calm_{0};           // [ticks] since the last command that was suspicious or beyond the clip, at most memory_
};

/**
 * Detector of unsafe commands after Alemzadeh et al., DSN 2016. A model of each motor axis predicts the effect of a
 * command before it is written, from the measured state and the command. An alarm needs three quantities of one of the
 * first three joints beyond their thresholds in the same step: motor acceleration, motor velocity and joint velocity.
 * The thresholds are learnt from fault-free runs.
 *
 * Rule `departure` deviates from the paper (doc/detector.md gives the reasons). Its velocity is the change that the
 * command causes against the mean over `memory`. The predicted departure of the tip must also exceed `excursion`. The
 * model treats each axis alone (inertia, viscous and Coulomb friction, gravity linear in the joints). Its parameters
 * are identified from commands and encoders alone.
 *
 * Real-time safe: no allocation, no locks, no throw. Both arms share one object.
 */
class AnomalyDetector {
 public:
  AnomalyDetector(const DetectorConfig& config, const Drives& drives) noexcept;

  /** Runs one control cycle. Without `engaged` there is no alarm, and the memory is cleared. */
  const Verdict& step(const Observation& now) noexcept;

  const Verdict& verdict() const noexcept { return verdict_; }
  /** Prediction of the last engaged step. */
  const Prediction& prediction(Arm arm, std::size_t axis) const noexcept { return at(predictions_, arm)[axis]; }
  double excursion(Arm arm) const noexcept { return at(excursion_, arm); }  ///< [m]

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
  PerArm<Vec3> travelled_{};      // [rad] travel beyond the surgeon's motion, while the motion counts as a fault's
  PerArm<std::array<bool, kAxes>> was_beyond_{};
  PerArm<Suspicion> suspicion_;
  PerArm<std::array<Prediction, kAxes>> predictions_{};
  PerArm<double> excursion_{};  // [m]
  Verdict verdict_{};
};

/**
 * Acceleration [rad/s2] of a motor axis under a capstan torque [Nm] at a velocity [rad/s]. Below half an encoder count
 * per cycle the axis is at rest: friction then opposes the torque, up to its Coulomb value. Real-time safe.
 * @param[in] q joints [rad; m], for gravity.
 */
double acceleration(const DetectorAxis& axis, double torque, double velocity, const JointArray& q) noexcept;

}  // namespace raven2_trainer::detector
