#include "plant/arm_plant.h"

#include <Eigen/Cholesky>
#include <cmath>

#include "raven2_trainer/raven/board_channels.h"

namespace raven2_trainer::plant {
namespace {

constexpr double kDegree = kPi / 180.0;
constexpr double kStep = kTickSeconds / ArmPlant::kSubSteps;

/** Friction of the tool joints' own cables and pulleys [Nms/rad]. Ours: with the stock gains, which have no damping at
 *  the wrist and the jaws, it makes those axes close to critically damped (doc/virtual_raven.md). */
constexpr JointArray kLinkViscous{0.0, 0.0, 0.0, 0.008, 0.035, 0.035, 0.035};

/** [Nm] at the capstan: 22 Nm at the shoulder, 350 N at the insertion. Ours; tool joints have no brakes. */
constexpr double kBrakeTorque = 2.0;

/** Hard stops [rad; m]: the side where homing searches them is published (raven2.md 2.3: max_position), the other is
 *  ours, 5 degrees or 5 mm beyond the software limit; tool joints symmetric. */
constexpr JointArray kStopLow{0.0, 40 * kDegree, 0.225, -330 * kDegree, -100 * kDegree, -120 * kDegree, -120 * kDegree};
constexpr JointArray kStopHigh{95 * kDegree,  137.5 * kDegree, 0.562,        330 * kDegree,
                               100 * kDegree, 120 * kDegree,   120 * kDegree};

Vector7 toVector(const JointArray& values) noexcept {
  return Eigen::Map<const Vector7>(values.data());
}

}  // namespace

ArmPlant::ArmPlant(const model::RavenModel& raven, Arm arm, const VirtualRavenConfig& config)
    : arm_(arm),
      axes_(config.axes),
      dynamics_(raven, arm),
      stop_low_(toVector(kStopLow)),
      stop_high_(toVector(kStopHigh)) {
  const raven::CableCoupling coupling(arm, config);
  coupling_ = coupling.matrix();
  inverse_ = coupling.inverse();
  armature_.setZero();
  damping_ = inverse_.transpose() * toVector(kLinkViscous).asDiagonal() * inverse_;
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const auto k = static_cast<Eigen::Index>(j);
    const double gear = raven::gearRatio(j);  // capstan torque to motor shaft torque
    armature_(k, k) = axes_[j].inertia / gear;
    damping_(k, k) += axes_[j].viscous / gear;
    coulomb_[k] = axes_[j].coulomb / gear;
    brake_[k] = j <= kInsertion ? kBrakeTorque / gear : 0.0;
  }
  motor_ = coupling_ * (toVector(raven.arms.geometry.home) + toVector(config.start_offset));
  motor_rate_.setZero();
  q_ = inverse_ * motor_;
  dq_.setZero();
  dynamics_.update(q_, dq_);
}

Vector7 ArmPlant::motorTorques(const std::array<std::int16_t, raven::kChannels>& dac) const noexcept {
  Vector7 torque;
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const double amps = dac[raven::channelOf(j)] / axes_[j].counts_per_amp;
    torque[static_cast<Eigen::Index>(j)] =
        raven::torqueSign(arm_, j) * amps * axes_[j].torque_per_amp / raven::gearRatio(j);
  }
  return torque;
}

void ArmPlant::step(const std::array<std::int16_t, raven::kChannels>& dac, bool brakes_on) noexcept {
  const Vector7 torque = motorTorques(dac);
  const Vector7 friction = brakes_on ? Vector7(coulomb_ + brake_) : coulomb_;
  for (int k = 0; k < kSubSteps; ++k)
    subStep(torque, friction);
}

void ArmPlant::subStep(const Vector7& torque, const Vector7& friction) noexcept {
  dynamics_.update(q_, dq_);
  const Matrix7 inertia = inverse_.transpose() * dynamics_.massMatrix() * inverse_ + armature_;
  const Vector7 load = inverse_.transpose() * dynamics_.bias();
  const Matrix7 implicit = inertia + kStep * damping_;
  const Matrix7 W = implicit.llt().solve(Matrix7::Identity());
  const Vector7 free = W * (inertia * motor_rate_ + kStep * (torque - load));

  const std::size_t stop_count = findStops(inverse_ * free);
  motor_rate_ = friction_.solve(W, free, kStep * friction, stops_, stop_count);
  motor_ += kStep * motor_rate_;
  q_ = inverse_ * motor_;
  dq_ = inverse_ * motor_rate_;
}

std::size_t ArmPlant::findStops(const Vector7& rate) noexcept {
  std::size_t count = 0;
  for (Eigen::Index j = 0; j < 7; ++j) {
    const bool upward = rate[j] > 0.0;
    const double room = upward ? stop_high_[j] - q_[j] : q_[j] - stop_low_[j];
    if (std::abs(rate[j]) * kStep <= room) continue;
    stops_[count].direction = (upward ? -1.0 : 1.0) * inverse_.row(j).transpose();
    stops_[count].least_rate = -room / kStep;
    ++count;
  }
  return count;
}

std::array<std::int32_t, raven::kChannels> ArmPlant::encoders() const noexcept {
  std::array<std::int32_t, raven::kChannels> counts{};
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const auto count = std::lround(motor_[static_cast<Eigen::Index>(j)] / raven::kMotorRadPerCount);
    counts[raven::channelOf(j)] = raven::encoderSign(arm_, j) * static_cast<std::int32_t>(count);
  }
  return counts;
}

}  // namespace raven2_trainer::plant
