#include "raven2_trainer/control/path_relay.h"

#include <cmath>

#include "raven2_trainer/control/axis_map.h"
#include "raven2_trainer/control/path_follower.h"

namespace raven2_trainer::control {
namespace {

using kinematics::IkStatus;

constexpr double kStep =
    5.0;  // [ticks] between checks: 10 mrad at planner.yaml's fastest joint, far from any other branch

/** Shorter way round: of q and -q the one with w >= 0. */
Quaternion shortest(const Quaternion& q) noexcept {
  return q.w() < 0.0 ? Quaternion(-q.coeffs()) : q;
}

bool isNear(const JointArray& a, const JointArray& b) noexcept {
  for (std::size_t j = 0; j < kFollowTolerance.size(); ++j) {
    if (std::abs(a[j] - b[j]) > kFollowTolerance[j]) return false;
  }
  return std::abs(kinematics::jawMidline(a) - kinematics::jawMidline(b)) <= kFollowTolerance[kWrist];
}

/** As PathExecution says it: the rate is that of the last tick. */
JointTarget pathTarget(const PlanResult& plan, double time, std::uint32_t* segment) noexcept {
  const JointArray before = pathJoints(plan, time - kTickSeconds, segment);
  JointTarget target{pathJoints(plan, time, segment), {}};
  for (std::size_t j = 0; j < kJointCount; ++j)
    target.dq[j] = (target.q[j] - before[j]) / kTickSeconds;
  return target;
}

}  // namespace

void PathRelay::start(Arm arm, const JointArray& q) noexcept {
  arm_ = arm;
  const Pose X_BT = kinematics::forward(geometry_, arm, q);
  p_um_ = (X_BT.p * 1e6).unaryExpr([](double um) { return std::trunc(um); });
  R_BT_ = Quaternion(X_BT.R).normalized();
  is_up_to_date_ = true;
}

/** [um] In B; the axes of I are those of B in another order, so a limit of the one is one of the other. */
Vector3 PathRelay::positionStep(const Vector3& p_BT) noexcept {
  const Vector3 missing = (p_BT * 1e6 - p_um_).unaryExpr([](double um) { return std::round(um); });
  const Vector3 step = missing.cwiseMin(limits_.position_um).cwiseMax(-limits_.position_um);
  is_up_to_date_ = is_up_to_date_ && step == missing;
  return step;
}

Quaternion PathRelay::rotationStep(const Quaternion& R_BT) noexcept {
  const Quaternion missing = shortest((R_BT * R_BT_.conjugate()).normalized());
  const double angle = 2.0 * std::atan2(missing.vec().norm(), missing.w());
  if (angle <= limits_.rotation) return missing;
  is_up_to_date_ = false;
  return Quaternion::Identity().slerp(limits_.rotation / angle, missing);
}

TipIncrement PathRelay::advance(const JointArray& q) noexcept {
  const Pose X_BT = kinematics::forward(geometry_, arm_, q);
  const Matrix3& C = itpToBase(arm_);
  is_up_to_date_ = true;
  const Vector3 dp_B = positionStep(X_BT.p);
  const Quaternion dq_B = rotationStep(Quaternion(X_BT.R).normalized());
  p_um_ += dp_B;
  R_BT_ = (dq_B * R_BT_).normalized();
  Quaternion dq_I = dq_B;
  dq_I.vec() = C.transpose() * dq_B.vec();  // the axis turns, the angle stays
  return {toArray(Vector3(C.transpose() * dp_B * 1e-6)), toArray(dq_I)};
}

bool robotFollows(const ArmGeometry& geometry,
                  const IncrementLimits& limits,
                  const ArmController& law,
                  const PlanResult& plan) noexcept {
  const bool can_be_counted = plan.waypoint_count > 0 && plan.waypoint_count <= kMaxWaypoints;
  if (plan.status != PlanStatus::kSuccess || !can_be_counted) return false;
  PathRelay relay(geometry, {kStep * limits.position_um, kStep * limits.rotation});
  relay.start(plan.arm, plan.waypoints[0]);
  JointArray robot = plan.waypoints[0];
  const double end = plan.arrival[plan.waypoint_count - 1];
  std::uint32_t segment = 0;
  for (double time = 0.0, before = -1.0; before < end; before = time, time += kStep * kTickSeconds) {
    const JointArray q = law.leading(pathTarget(plan, time, &segment));
    relay.advance(q);
    const Pose X_BT = relay.pose();
    if (!relay.isUpToDate() || kinematics::isFirstWristPointAtRcm(geometry, X_BT)) return false;
    const auto ik = kinematics::inverseWithinLimits(geometry, plan.arm, X_BT, kinematics::jawOpening(q), robot);
    if (!kinematics::isUsable(ik.status) || ik.status == IkStatus::kClamped || !isNear(ik.q, q)) return false;
    robot = ik.q;
  }
  return true;
}

}  // namespace raven2_trainer::control
