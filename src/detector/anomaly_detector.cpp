#include "raven2_trainer/detector/anomaly_detector.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "raven2_trainer/core/ticks.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"

namespace raven2_trainer::detector {
namespace {

/** Half an encoder count per cycle: 2 pi / 4000 rad (raven2.md 3.1) in 1 ms, halved. */
constexpr double kAtRest = 0.5 * 2.0 * kPi / 4000.0 / kTickSeconds;  // [rad/s]

/** A threshold of zero is always exceeded. */
double ratio(double value, double threshold) noexcept {
  return threshold > 0.0 ? std::abs(value) / threshold : std::numeric_limits<double>::infinity();
}

/** [Nm] Torque minus load and viscous friction. */
double netTorque(const DetectorAxis& axis, double torque, double velocity, const JointArray& q) noexcept {
  double net = torque - axis.offset - axis.viscous * velocity;
  for (std::size_t i = 0; i < kAxes; ++i)
    net -= axis.gravity[i] * q[i];
  return net;
}

/** Torque minus the dry friction that opposes it. */
double opposed(double torque, double coulomb) noexcept {
  return std::copysign(std::max(std::abs(torque) - coulomb, 0.0), torque);
}

Vec3 jointOf(const std::array<Vec3, kAxes>& rows, const Vec3& motor) noexcept {
  Vec3 joint;
  for (std::size_t i = 0; i < kAxes; ++i)
    joint[i] = rows[i][0] * motor[0] + rows[i][1] * motor[1] + rows[i][2] * motor[2];
  return joint;
}

}  // namespace

double acceleration(const DetectorAxis& axis, double torque, double velocity, const JointArray& q) noexcept {
  const double net = netTorque(axis, torque, velocity, q);
  if (std::abs(velocity) > kAtRest) return (net - std::copysign(axis.coulomb, velocity)) / axis.inertia;
  return opposed(net, axis.coulomb) / axis.inertia;
}

Suspicion::Suspicion(const DetectorConfig& config) noexcept
    : threshold_(config.suspicion),
      longest_(static_cast<int>(toTicks(config.suspicion_time))),
      memory_(static_cast<int>(toTicks(config.memory))) {}

void Suspicion::step(double size, double departs, bool is_beyond_clip) noexcept {
  const bool is_suspicious = size > threshold_;
  if (is_beyond_clip) {
    age_ = 0;
  } else if (age_ > 0) {
    age_ = departs > threshold_ && age_ < longest_ ? age_ + 1 : 0;
  } else if (is_suspicious && calm_ >= memory_ && longest_ > 0) {
    age_ = 1;
  }
  calm_ = is_beyond_clip || is_suspicious ? 0 : std::min(calm_ + 1, memory_);
}

AnomalyDetector::AnomalyDetector(const DetectorConfig& config, const Drives& drives) noexcept
    : config_(config),
      drives_(drives),
      forgetting_(1.0 - std::exp(-kTickSeconds / config.memory)),
      suspicion_{Suspicion(config), Suspicion(config)} {}

void AnomalyDetector::forget(const Observation& now) noexcept {
  for (const Arm arm : kArms) {
    for (std::size_t i = 0; i < kAxes; ++i)
      at(last_motor_, arm)[i] = at(now.motor, arm)[i];
    at(velocity_, arm) = at(mean_velocity_, arm) = at(surgeons_, arm) = at(travelled_, arm) = Vec3{};
    at(was_beyond_, arm).fill(false);
    at(suspicion_, arm).forget();
  }
  warm_ = now.engaged;
}

const Verdict& AnomalyDetector::step(const Observation& now) noexcept {
  verdict_ = Verdict{};
  if (!now.engaged || !warm_) {
    forget(now);
    return verdict_;
  }
  for (const Arm arm : kArms) {
    observe(arm, now);
    predict(arm, now);
    judge(arm);
  }
  verdict_.alarm = verdict_.size > config_.factor;
  return verdict_;
}

/** The velocity is the difference of encoder positions, as the robot computes it (raven2.md 3.7). The mean does not
 *  follow motion under a command beyond the clip or under suspicion: that motion is not the surgeon's. */
void AnomalyDetector::observe(Arm arm, const Observation& now) noexcept {
  const bool is_suspected = at(suspicion_, arm).holds();
  for (std::size_t i = 0; i < kAxes; ++i) {
    const bool was_beyond = at(was_beyond_, arm)[i];
    const double motor = at(now.motor, arm)[i];
    double& velocity = at(velocity_, arm)[i];
    double& mean = at(mean_velocity_, arm)[i];
    double& surgeons = at(surgeons_, arm)[i];
    double& travelled = at(travelled_, arm)[i];
    if (!was_beyond) mean += forgetting_ * (velocity - mean);
    if (!is_suspected) surgeons = mean;
    velocity = (motor - at(last_motor_, arm)[i]) / kTickSeconds;
    at(last_motor_, arm)[i] = motor;
    travelled = was_beyond || is_suspected ? travelled + (velocity - surgeons) * kTickSeconds : 0.0;
    at(was_beyond_, arm)[i] = isBeyondClip(i, at(now.dac, arm)[i]);
  }
}

void AnomalyDetector::predict(Arm arm, const Observation& now) noexcept {
  auto& axes = at(predictions_, arm);
  Vec3 motors{};
  for (std::size_t i = 0; i < kAxes; ++i) {
    const std::int32_t dac = at(now.dac, arm)[i];
    const double velocity = at(velocity_, arm)[i];
    const double torque = at(drives_.torque_per_count, arm)[i] * dac;
    axes[i].acceleration = acceleration(at(config_.axes, arm)[i], torque, velocity, at(now.q, arm));
    motors[i] =
        isPublished() ? velocity + axes[i].acceleration * kTickSeconds : departure(arm, i, now) / config_.braking_time;
    axes[i].motor_velocity = motors[i];
  }
  const Vec3 joints = jointOf(drives_.joint_per_motor, motors);
  for (std::size_t i = 0; i < kAxes; ++i)
    axes[i].joint_velocity = joints[i];
  const kinematics::Jacobian J = kinematics::jacobian(drives_.geometry, arm, at(now.q, arm));
  at(excursion_, arm) = config_.braking_time * (J.topLeftCorner<3, 3>() * toEigen(joints)).norm();
}

/** [rad] of the motor: its travel since its command left the clip or became suspicious, plus the gained velocity times
 *  the braking time. A command beyond the clip adds its acceleration for `persistence`. A command within the clip
 *  stands for a position error that the control law closes, less dry friction; if that is larger, it counts instead. */
double AnomalyDetector::departure(Arm arm, std::size_t i, const Observation& now) const noexcept {
  const DetectorAxis& axis = at(config_.axes, arm)[i];
  const double velocity = at(velocity_, arm)[i];
  const double gained = velocity - at(surgeons_, arm)[i];
  const double carried = at(travelled_, arm)[i] + config_.braking_time * gained;
  const std::int32_t dac = at(now.dac, arm)[i];
  if (isBeyondClip(i, dac))
    return carried + config_.braking_time * config_.persistence * at(predictions_, arm)[i].acceleration;
  const double torque = at(drives_.torque_per_count, arm)[i] * dac;
  const double net = netTorque(axis, torque, velocity, at(now.q, arm));
  const double asked = config_.asked * opposed(net, axis.coulomb) / drives_.position_gain[i];
  return std::abs(asked) > std::abs(carried) ? asked : carried;
}

bool AnomalyDetector::isBeyondClip(std::size_t axis, std::int32_t dac) const noexcept {
  return std::abs(static_cast<double>(dac)) > drives_.clip[axis];
}

void AnomalyDetector::judge(Arm arm) noexcept {
  const double departs = ratio(at(excursion_, arm), isPublished() ? 0.0 : config_.excursion);
  double largest = 0.0;
  bool is_beyond = false;
  for (std::size_t i = 0; i < kAxes; ++i) {
    largest = std::max(largest, judgeAxis(arm, i, departs));
    is_beyond = is_beyond || at(was_beyond_, arm)[i];
  }
  at(verdict_.alarms, arm) = largest > config_.factor;
  at(suspicion_, arm).step(largest, departs, is_beyond);
}

double AnomalyDetector::judgeAxis(Arm arm, std::size_t i, double departs) noexcept {
  const Prediction& p = at(predictions_, arm)[i];
  const DetectorAxis& axis = at(config_.axes, arm)[i];
  const DetectorThresholds& limits = isPublished() ? axis.published : axis.departure;
  const double a = ratio(p.acceleration, limits.acceleration);
  const double v = ratio(p.motor_velocity, limits.motor_velocity);
  const double w = ratio(p.joint_velocity, limits.joint_velocity);
  const double size = std::min({a, v, w, departs});
  if (!(size > verdict_.size)) return size;
  const auto beyond = [this](double r, std::uint8_t bit) { return r > config_.factor ? bit : std::uint8_t{0}; };
  verdict_.agreeing = static_cast<std::uint8_t>(
      beyond(a, agreeing::kAcceleration) | beyond(v, agreeing::kMotorVelocity) | beyond(w, agreeing::kJointVelocity));
  verdict_.size = size;
  verdict_.arm = arm;
  verdict_.joint = static_cast<std::uint8_t>(i);
  verdict_.excursion = at(excursion_, arm);
  return size;
}

}  // namespace raven2_trainer::detector
