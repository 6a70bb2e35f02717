#include "raven2_trainer/raven/cable_coupling.h"

#include <Eigen/LU>
#include <string>

#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::raven {
namespace {

// raven2 include/raven/fwd_cable_coupling.h:38-48
constexpr double kGb = 2.90870044;     // insertion motor per tool motor
constexpr double kC01 = 0.14545;       // [rad/rad] elbow by shoulder
constexpr double kC02 = 0.0077973826;  // [m/rad] insertion by shoulder
constexpr double kC12 = 0.008077387;   // [m/rad] insertion by elbow

using Vector7 = Eigen::Matrix<double, 7, 1>;

Eigen::Map<const Vector7> view(const JointArray& values) noexcept {
  return Eigen::Map<const Vector7>(values.data());
}

JointArray times(const Eigen::Matrix<double, 7, 7>& matrix, const JointArray& values) noexcept {
  JointArray result;
  Eigen::Map<Vector7>(result.data()).noalias() = matrix * view(values);
  return result;
}

double ratioOf(const VirtualRavenConfig& config, std::size_t joint) {
  const double ratio = config.axes[joint].transmission;
  if (!(ratio > 0.0)) {
    throw ConfigException(std::string("virtual_raven: axes/") + kJointNames[joint] + "/transmission is " +
                          std::to_string(ratio) + ", expected more than 0 rad/rad or rad/m");
  }
  return ratio;
}

}  // namespace

CableCoupling::CableCoupling(Arm arm, const VirtualRavenConfig& config) {
  matrix_.setZero();
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const auto k = static_cast<Eigen::Index>(j);
    matrix_(k, k) = ratioOf(config, j);
  }
  matrix_(kElbow, kShoulder) = matrix_(kElbow, kElbow) * kC01;
  matrix_(kInsertion, kShoulder) = matrix_(kInsertion, kInsertion) * kC02;
  matrix_(kInsertion, kElbow) = matrix_(kInsertion, kInsertion) * kC12;

  const double sign = arm == Arm::kGold ? 1.0 : -1.0;
  for (const std::size_t j : {kToolRotation, kWrist, kGrasp1, kGrasp2}) {
    tool_per_insertion_[j] = (j == kGrasp1 ? -sign : sign) / kGb;
    matrix_.row(static_cast<Eigen::Index>(j)) += tool_per_insertion_[j] * matrix_.row(kInsertion);
  }
  inverse_ = matrix_.inverse();
}

JointArray CableCoupling::toMotor(const JointArray& q) const noexcept {
  return times(matrix_, q);
}

JointArray CableCoupling::toMotorMeasured(const JointArray& q, double insertion_motor) const noexcept {
  JointArray motor = times(matrix_, q);
  const double lag = insertion_motor - motor[kInsertion];
  for (std::size_t j = kToolRotation; j < kJointCount; ++j)
    motor[j] += tool_per_insertion_[j] * lag;
  return motor;
}

JointArray CableCoupling::toJoint(const JointArray& motor) const noexcept {
  return times(inverse_, motor);
}

}  // namespace raven2_trainer::raven
