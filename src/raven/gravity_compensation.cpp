#include "raven/gravity_compensation.h"

#include "raven2_trainer/raven/board_channels.h"

namespace raven2_trainer::raven {
namespace {

constexpr double kGravity = 9.8;                             // [m/s2] as the robot's software has it
constexpr std::array<double, 3> kMass{0.494, 0.750, 0.231};  // [kg] raven2 grav_comp.cpp:74-76

/** Centres of mass [m] in the links' own DH frames, raven2 grav_comp.cpp:59-66. */
std::array<Vector3, 3> centres(Arm arm) noexcept {
  if (arm == Arm::kGold) return {Vector3(0.0065, 0.09775, -0.13771), Vector3(-0.002, -0.18274, -0.23053), {0, 0, 0}};
  return {Vector3(-0.0065, -0.09775, 0.13771), Vector3(-0.002, -0.18274, 0.23053), {0, 0, 0}};
}

Matrix3 aboutX(double angle) noexcept {
  return Eigen::AngleAxisd(angle, Vector3::UnitX()).toRotationMatrix();
}

Matrix3 aboutZ(double angle) noexcept {
  return Eigen::AngleAxisd(angle, Vector3::UnitZ()).toRotationMatrix();
}

}  // namespace

GravityCompensation::GravityCompensation(Arm arm, const VirtualRavenConfig& config) noexcept
    : arm_(arm), twist0_(aboutX(arm == Arm::kGold ? 0.0 : kPi)), twist1_(aboutX(75.0 * kDegree)) {
  const bool gold = arm == Arm::kGold;
  shaft_ = aboutX((gold ? 128.0 : 52.0) * kDegree) * aboutZ(gold ? kPi / 2 : -kPi / 2);
  for (std::size_t j = 0; j < 3; ++j)
    capstan_per_joint_[j] = gearRatio(j) / config.axes[j].transmission;
}

/** DH frames 1 to 3 in B (raven2.md 2.1, 2.2). All but the third share the remote centre as origin. */
std::array<Pose, 3> GravityCompensation::frames(const JointArray& q) const noexcept {
  const bool gold = arm_ == Arm::kGold;
  std::array<Pose, 3> X;
  X[0].R = twist0_ * aboutZ(q[kShoulder] + (gold ? 205.0 : 25.0) * kDegree);
  X[1].R = X[0].R * (twist1_ * aboutZ(q[kElbow] + (gold ? kPi : 0.0)));
  X[2].R = X[1].R * shaft_;
  X[2].p = X[2].R.col(2) * q[kInsertion];
  return X;
}

std::array<double, 3> GravityCompensation::torque(const JointArray& q) const noexcept {
  const std::array<Pose, 3> X = frames(q);
  const std::array<Vector3, 3> c = centres(arm_);
  const Vector3 g_B(-kGravity, 0.0, 0.0);
  std::array<double, 3> tau{};
  Vector3 moment = Vector3::Zero();  // about the remote centre, of this link and all beyond
  for (std::size_t j = 3; j-- > 0;) {
    moment += (X[j] * c[j]).cross(kMass[j] * g_B);
    const Vector3 axis = X[j].R.col(2);
    const double load = j == kInsertion ? axis.dot(kMass[j] * g_B) : axis.dot(moment);
    tau[j] = -load * capstan_per_joint_[j];
  }
  return tau;
}

}  // namespace raven2_trainer::raven
