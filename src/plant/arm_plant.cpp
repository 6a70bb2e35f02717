#include "plant/arm_plant.h"

#include <algorithm>
#include <cmath>

#include "plant/inverse7.h"
#include "raven2_trainer/raven/board_channels.h"

namespace raven2_trainer::plant {
namespace {

constexpr double kStep = kTickSeconds / ArmPlant::kSubSteps;
constexpr double kCountsPerVolt = 65536.0 / 20.0;  // 16 bits over +-10 V (raven2.md 6.2)

/** Radius [m] of the capstan on the gearbox: GP42, GP32 (raven2.md 3.1). */
constexpr double capstanRadius(std::size_t joint) noexcept {
  return joint <= kInsertion ? 5.675e-3 : 5.005e-3;
}

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
      elastic_(config.plant.elastic_cables),
      amplifier_limit_(config.plant.amplifier_limit * kCountsPerVolt),
      dynamics_(raven, arm),
      stop_low_(toVector(kStopLow)),
      stop_high_(toVector(kStopHigh)) {
  const raven::CableCoupling coupling(arm, config);
  coupling_ = coupling.matrix();
  inverse_ = coupling.inverse();
  coulomb_.setZero();
  brake_.setZero();
  readAxes(config);
  const Vector7 q = toVector(raven.arms.geometry.home) + toVector(config.start_offset);
  setMotors(coupling_ * q, Vector7::Zero());
}

void ArmPlant::readAxes(const VirtualRavenConfig& config) {
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const auto k = static_cast<Eigen::Index>(j);
    const MotorAxis& motor = config.axes[j];
    const PlantAxis& axis = config.plant.axes[j];
    const double gear = raven::gearRatio(j);  // capstan torque to motor shaft torque
    const double cable_by_shaft = capstanRadius(j) / gear;
    torque_per_count_[k] =
        raven::torqueSign(arm_, j) * axis.torque_gain * motor.torque_per_amp / motor.counts_per_amp / gear;
    amplifier_offset_[k] = config.plant.amplifier_offset * motor.counts_per_amp;
    torque_offset_[k] = axis.torque_offset / gear;
    armature_[k] = axis.inertia / gear;
    motor_damping_[k] = axis.viscous / gear;
    link_damping_[k] = axis.link_viscous;
    cable_stiffness_[k] = axis.cable_stiffness * cable_by_shaft * cable_by_shaft;
    cable_damping_[k] = axis.cable_damping * cable_by_shaft * cable_by_shaft;
    coulomb_[k] = axis.coulomb / gear;
    coulomb_[7 + k] = axis.link_coulomb;
    brake_[k] = j <= kInsertion ? kBrakeTorque / gear : 0.0;
  }
  has_link_friction_ = !coulomb_.tail<7>().isZero(0.0);
  damping_ = inverse_.transpose() * (kStep * link_damping_).asDiagonal() * inverse_;
}

void ArmPlant::leadMotors(const Vector7& position, const Vector7& rate) noexcept {
  motor_ = position;
  motor_rate_ = rate;
  if (elastic_) return;
  q_ = inverse_ * motor_;
  dq_ = inverse_ * motor_rate_;
}

void ArmPlant::setMotors(const Vector7& position, const Vector7& rate) noexcept {
  motor_ = position;
  motor_rate_ = rate;
  q_ = inverse_ * motor_;
  dq_ = inverse_ * motor_rate_;
  dynamics_.update(q_, dq_);
  friction_solver_.reset();
}

Vector7 ArmPlant::motorTorques(const std::array<std::int16_t, raven::kChannels>& dac) const noexcept {
  Vector7 torque;
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const auto k = static_cast<Eigen::Index>(j);
    const double counts = std::clamp<double>(dac[raven::channelOf(j)], -amplifier_limit_, amplifier_limit_);
    torque[k] = torque_per_count_[k] * (counts + amplifier_offset_[k]) + torque_offset_[k];
  }
  return torque;
}

void ArmPlant::step(const std::array<std::int16_t, raven::kChannels>& dac, bool brakes_on) noexcept {
  const Vector7 torque = motorTorques(dac);
  const FrictionSolver::Vector friction = brakes_on ? FrictionSolver::Vector(coulomb_ + brake_) : coulomb_;
  for (int k = 0; k < kSubSteps; ++k)
    subStep(torque, kStep * friction);
}

void ArmPlant::subStep(const Vector7& torque, const FrictionSolver::Vector& friction) noexcept {
  dynamics_.update(q_, dq_);
  if (elastic_) {
    solveElastic(torque);
  } else {
    solveRigid(torque);
  }
  const std::size_t stop_count = findStops();
  if (!elastic_ && (stop_count > 0 || has_link_friction_)) coupleLinks();
  moveOn(friction_solver_.solve(admittance_, free_, friction, stops_, stop_count));
}

/** Joints hang rigidly on the motors: everything in motor coordinates. */
void ArmPlant::solveRigid(const Vector7& torque) noexcept {
  Matrix7 inertia = inverse_.transpose() * dynamics_.massMatrix() * inverse_;
  inertia.diagonal() += armature_;
  Matrix7 implicit = inertia + damping_;
  implicit.diagonal() += kStep * motor_damping_;
  const Matrix7 W = Inverse7(implicit).matrix();
  const Vector7 load = inverse_.transpose() * dynamics_.bias();
  free_.head<7>().noalias() = W * (inertia * motor_rate_ + kStep * (torque - load));
  free_.tail<7>().noalias() = inverse_ * free_.head<7>();
  admittance_.topLeftCorner<7, 7>() = W;
}

/** The rest of a rigid arm's admittance: without stops and friction at the links, nothing depends on it. */
void ArmPlant::coupleLinks() noexcept {
  admittance_.bottomLeftCorner<7, 7>().noalias() = inverse_ * admittance_.topLeftCorner<7, 7>();
  admittance_.topRightCorner<7, 7>() = admittance_.bottomLeftCorner<7, 7>().transpose();
  admittance_.bottomRightCorner<7, 7>().noalias() = admittance_.bottomLeftCorner<7, 7>() * inverse_.transpose();
}

/**
 * Backward Euler in the cables: with D = h c + h^2 k, P = I + h b + D (diagonal, motors) and A = d motor / d joint
 *   P v_m - D A v_q = I v_m0 + h (tau - k e),   -A^T D v_m + (M + h b_q + A^T D A) v_q = M v_q0 + h (A^T k e - bias)
 * The motors are eliminated, which leaves seven equations and stays well-conditioned for any stiffness.
 */
void ArmPlant::solveElastic(const Vector7& torque) noexcept {
  const Vector7 tension = cable_stiffness_.cwiseProduct(cableStretch());
  const Vector7 D = kStep * cable_damping_ + (kStep * kStep) * cable_stiffness_;
  const Vector7 motor_side = armature_ + kStep * motor_damping_;
  const Vector7 P_inverse = (motor_side + D).cwiseInverse();
  const Vector7 ratio = D.cwiseProduct(P_inverse);        // D / P
  const Vector7 series = ratio.cwiseProduct(motor_side);  // D - D^2 / P
  const Matrix7 M = dynamics_.massMatrix();
  Matrix7 S = M + coupling_.transpose() * series.asDiagonal() * coupling_;
  S.diagonal() += kStep * link_damping_;
  const Matrix7 Y_qq = Inverse7(S).matrix();
  const Matrix7 Y_mq = ratio.asDiagonal() * (coupling_ * Y_qq);

  const Vector7 rhs_m = armature_.cwiseProduct(motor_rate_) + kStep * (torque - tension);
  const Vector7 rhs_q = M * dq_ + kStep * (coupling_.transpose() * tension - dynamics_.bias());
  free_.tail<7>().noalias() = Y_qq * (rhs_q + coupling_.transpose() * ratio.cwiseProduct(rhs_m));
  free_.head<7>() = P_inverse.cwiseProduct(rhs_m) + ratio.cwiseProduct(coupling_ * free_.tail<7>());

  admittance_.bottomRightCorner<7, 7>() = Y_qq;
  admittance_.topRightCorner<7, 7>() = Y_mq;
  admittance_.bottomLeftCorner<7, 7>() = Y_mq.transpose();
  admittance_.topLeftCorner<7, 7>().noalias() = Y_mq * (coupling_.transpose() * ratio.asDiagonal());
  admittance_.topLeftCorner<7, 7>().diagonal() += P_inverse;
}

std::size_t ArmPlant::findStops() noexcept {
  std::size_t count = 0;
  for (Eigen::Index j = 0; j < 7; ++j) {
    const double rate = free_[7 + j];
    const bool upward = rate > 0.0;
    const double room = upward ? stop_high_[j] - q_[j] : q_[j] - stop_low_[j];
    if (std::abs(rate) * kStep <= room) continue;
    stops_[count] = {7 + j, upward ? -1.0 : 1.0, -room / kStep};
    ++count;
  }
  return count;
}

void ArmPlant::moveOn(const FrictionSolver::Vector& rate) noexcept {
  motor_rate_ = rate.head<7>();
  motor_ += kStep * motor_rate_;
  if (elastic_) {
    dq_ = rate.tail<7>();
    q_ += kStep * dq_;
  } else {
    q_ = inverse_ * motor_;
    dq_ = inverse_ * motor_rate_;
  }
}

double ArmPlant::energy() const noexcept {
  const Vector7 stretch = elastic_ ? cableStretch() : Vector7(Vector7::Zero());
  ArmDynamics now = dynamics_;
  now.update(q_, dq_);
  return now.kineticEnergy() + now.potentialEnergy() + 0.5 * motor_rate_.dot(armature_.cwiseProduct(motor_rate_)) +
         0.5 * stretch.dot(cable_stiffness_.cwiseProduct(stretch));
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
