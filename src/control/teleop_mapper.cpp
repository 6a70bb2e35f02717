#include "raven2_trainer/control/teleop_mapper.h"

#include <algorithm>
#include <cmath>

#include "raven2_trainer/control/axis_map.h"

namespace raven2_trainer::control {
namespace {

using kinematics::IkStatus;

constexpr double kGraspResync = 45.0 * kPi / 180.0;  // the wanted opening survives a smaller difference (1.4)

/** Whole micrometres, toward zero, as the robot's mapping does. The nudge undoes the binary error of 1e-6. */
double wholeMicrometres(double metres) noexcept {
  const double um = metres * 1e6;
  return std::trunc(um + std::copysign(1e-6, um));
}

}  // namespace

TeleopMapper::TeleopMapper(const ArmGeometry& geometry, Arm arm) noexcept : geometry_(geometry), arm_(arm) {
  opening_ = kinematics::jawOpening(geometry.home);
  rebase(geometry.home);
}

void TeleopMapper::rebasePose(const JointArray& q) noexcept {
  X_BTd_ = kinematics::forward(geometry_, arm_, q);
  p_um_ = (X_BTd_.p * 1e6).unaryExpr([](double um) { return std::trunc(um); });
  X_BTd_.p = p_um_ * 1e-6;
  q_d_ = q;
  kinematics::setJaws(kinematics::jawMidline(q), opening_, &q_d_);
  status_ = IkStatus::kOk;
}

void TeleopMapper::rebase(const JointArray& q) noexcept {
  const double actual = kinematics::jawOpening(q);
  if (std::abs(actual - opening_) > kGraspResync) opening_ = actual;
  rebasePose(q);
}

IkStatus TeleopMapper::add(const Vec3& dp_I, const Quat& dq_I, double dgrasp, const JointArray& current) noexcept {
  const Matrix3& C = itpToBase(arm_);
  p_um_ += (C * toEigen(dp_I)).unaryExpr(&wholeMicrometres);
  X_BTd_.p = p_um_ * 1e-6;
  if (dq_I != kIdentityQuat) {
    const Quaternion turned(C * toEigen(dq_I).toRotationMatrix() * C.transpose() * X_BTd_.R);
    X_BTd_.R = turned.normalized().toRotationMatrix();  // keeps a million products orthonormal
  }
  opening_ = std::clamp(opening_ - dgrasp, kMinOpening, kMaxOpening);

  const kinematics::IkResult result = kinematics::inverseWithinLimits(geometry_, arm_, X_BTd_, opening_, current);
  if (result.status == IkStatus::kClamped) {
    rebasePose(result.q);
  } else if (kinematics::isUsable(result.status)) {
    q_d_ = result.q;
  }
  status_ = result.status;
  return status_;
}

}  // namespace raven2_trainer::control
