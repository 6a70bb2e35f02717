#include "raven2_trainer/kinematics/arm_kinematics.h"

#include <algorithm>

#include "raven2_trainer/kinematics/chain.h"

namespace raven2_trainer::kinematics {
namespace {

constexpr std::array<const char*, 6> kStatusNames{"ok",           "clamped", "out_of_reach",
                                                  "singular_rcm", "too_far", "singular_wrist"};

/** The axes and points of the chain that pose and Jacobian are made of, in B. */
struct Axes {
  Vector3 shoulder, elbow, shaft, wrist;
  Vector3 p_wrist;
  Walker tool;
};

Axes axes(const ArmGeometry& geometry, Arm arm, const JointArray& q) noexcept {
  const Chain& chain = kChains[index(arm)];
  Axes a;
  Walker& frame = a.tool;
  frame.link(chain.twist0, angle(q[kShoulder] + chain.offset1));
  a.shoulder = frame.z;
  frame.link(kLink12, angle(q[kElbow] + chain.offset2));
  a.elbow = frame.z;
  frame.link(chain.twist2, chain.theta3);
  a.shaft = frame.z;
  frame.link({}, angle(q[kToolRotation]));
  a.p_wrist = (q[kInsertion] + geometry.d4) * a.shaft;
  frame.link(kQuarter, angle(q[kWrist] + kOffset5));
  a.wrist = frame.z;
  frame.p = a.p_wrist + geometry.lw * frame.x;
  frame.link(kQuarter, angle(jawMidline(q)));
  return a;
}

Pose poseOf(const Walker& tool) noexcept {
  Pose X_BT;
  X_BT.R << tool.x, tool.y, tool.z;
  X_BT.p = tool.p;
  return X_BT;
}

Jacobian jacobianOf(const Axes& a) noexcept {
  const Vector3& tip = a.tool.p;
  const Vector3 zero = Vector3::Zero();
  Jacobian J;
  // Shoulder, elbow and roll pass through the remote centre, the origin. The tip lies on the jaw axis, so that the
  // mid-line, (grasp2 - grasp1) / 2, only turns it.
  J.topRows<3>() << a.shoulder.cross(tip), a.elbow.cross(tip), a.shaft, a.shaft.cross(tip),
      a.wrist.cross(tip - a.p_wrist), zero, zero;
  J.bottomRows<3>() << a.shoulder, a.elbow, zero, a.shaft, a.wrist, -0.5 * a.tool.z, 0.5 * a.tool.z;
  return J;
}

}  // namespace

const char* name(IkStatus status) noexcept {
  return kStatusNames[static_cast<std::size_t>(status)];
}

double jawMidline(const JointArray& q) noexcept {
  return (q[kGrasp2] - q[kGrasp1]) / 2;
}

double jawOpening(const JointArray& q) noexcept {
  return q[kGrasp1] + q[kGrasp2];
}

void setJaws(double midline, double opening, JointArray* q) noexcept {
  (*q)[kGrasp1] = -midline + opening / 2;
  (*q)[kGrasp2] = midline + opening / 2;
}

Pose forward(const ArmGeometry& geometry, Arm arm, const JointArray& q) noexcept {
  return poseOf(axes(geometry, arm, q).tool);
}

Jacobian jacobian(const ArmGeometry& geometry, Arm arm, const JointArray& q) noexcept {
  return jacobianOf(axes(geometry, arm, q));
}

TipMotion tipMotion(const ArmGeometry& geometry, Arm arm, const JointArray& q, const JointArray& dq) noexcept {
  const Axes a = axes(geometry, arm, q);
  const Eigen::Matrix<double, 7, 1> rates(dq.data());
  return {poseOf(a.tool), jacobianOf(a).topRows<3>() * rates};
}

bool isFirstWristPointAtRcm(const ArmGeometry& geometry, const Pose& X_BT) noexcept {
  Vector3 rcm_T = X_BT.inverse().p;
  rcm_T.z() = 0.0;
  const double off_axis = rcm_T.norm();
  return off_axis > 0.0 && (X_BT * Vector3(rcm_T * (geometry.lw / off_axis))).norm() <= geometry.lw;
}

bool applyJointLimits(const ArmGeometry& geometry, JointArray* q) noexcept {
  const JointArray before = *q;
  for (std::size_t j = 0; j <= kWrist; ++j) {
    (*q)[j] = std::clamp((*q)[j], geometry.q_min[j], geometry.q_max[j]);
  }
  // The robot's sixth joint is the jaws' mid-line; it is held against grasper 1's lower limit and no other.
  const double midline = jawMidline(*q);
  if (midline < geometry.q_min[kGrasp1]) setJaws(geometry.q_min[kGrasp1], jawOpening(*q), q);
  return before != *q;
}

}  // namespace raven2_trainer::kinematics
