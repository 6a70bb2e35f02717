#pragma once

#include <cmath>
#include <string>

#include "raven2_trainer/kinematics/arms_config.h"
#include "raven2_trainer/kinematics/joint_conventions.h"
#include "raven2_trainer/model/raven_model.h"

// A RavenModel built in code from the DH table of raven2.md 2.1, with the published masses and centres of mass (6.2,
// 3.8) and round figures for the tool. The tests need neither URDF nor meshes. They check the plant against numbers
// that can be worked out by hand.

namespace raven2_trainer::plant::test {

inline Pose dhPose(double alpha, double a, double theta, double d) {
  Pose pose;
  pose.R = Eigen::AngleAxisd(alpha, Vector3::UnitX()).toRotationMatrix() *
           Eigen::AngleAxisd(theta, Vector3::UnitZ()).toRotationMatrix();
  pose.p = Vector3(a, -std::sin(alpha) * d, std::cos(alpha) * d);
  return pose;
}

inline model::Inertial inertial(double mass, const Vector3& com, const Vector3& diagonal) {
  return {mass, com, diagonal.asDiagonal()};
}

/** DH pose of each joint in its parent at robot coordinate `q`, raven2.md 2.1 and 2.2. */
inline Pose dhJoint(Arm arm, const ArmGeometry& g, std::size_t joint, double q) {
  const bool gold = arm == Arm::kGold;
  const double degree = kPi / 180.0;
  switch (joint) {
    case kShoulder:
      return dhPose(gold ? 0.0 : kPi, 0.0, q + (gold ? 205.0 : 25.0) * degree, 0.0);
    case kElbow:
      return dhPose(75.0 * degree, 0.0, q + (gold ? kPi : 0.0), 0.0);
    case kInsertion:
      return dhPose((gold ? 128.0 : 52.0) * degree, 0.0, gold ? kPi / 2 : -kPi / 2, q);
    case kToolRotation:
      return dhPose(0.0, 0.0, q, g.d4);
    case kWrist:
      return dhPose(kPi / 2, 0.0, q - kPi / 2, 0.0);
    case kGrasp1:
      return dhPose(kPi / 2, g.lw, -q, 0.0);
    default:
      return dhPose(kPi / 2, g.lw, q, 0.0);
  }
}

inline model::Inertial dhInertial(Arm arm, std::size_t joint) {
  const double s = arm == Arm::kGold ? 1.0 : -1.0;
  switch (joint) {
    case kShoulder:
      return inertial(0.503, {0.0065 * s, 0.09775 * s, -0.13771 * s}, {0.0174, 0.0072, 0.0102});
    case kElbow:
      return inertial(0.753, {-0.002, -0.18274, -0.23053 * s}, {0.0168, 0.0094, 0.0070});
    case kInsertion:
      return inertial(0.407, {0.0, 0.0, -0.015}, {0.0029, 0.0030, 0.00036});
    case kToolRotation:
      return inertial(0.043, {0.0, 0.0, 0.237}, {7.8e-4, 7.8e-4, 6.1e-7});
    case kWrist:
      return inertial(0.004, {0.0037, 0.0, 0.0}, {3e-8, 9e-8, 1e-7});
    default:
      return inertial(0.001, {0.006, 0.001, 0.0}, {1e-8, 2e-8, 2e-8});
  }
}

inline void addArm(Arm arm, model::RavenModel* raven) {
  constexpr std::array<int, kJointCount> kParents{-1, 0, 1, 2, 3, 4, 4};
  const ArmGeometry& g = raven->arms.geometry;
  JointArray unit;
  unit.fill(1.0);
  const JointArray rate = kinematics::rateToUrdf(arm, unit);
  const JointArray zero = kinematics::fromUrdf(arm, g.d4, JointArray{});  // robot joints at URDF position 0

  model::Link base;
  base.name = std::string("base_") + name(arm);
  base.X_PJ = at(raven->X_WB, arm);
  raven->description.links.push_back(base);
  const int base_index = static_cast<int>(raven->description.links.size()) - 1;
  at(raven->base_links, arm) = base_index;
  for (std::size_t j = 0; j < kJointCount; ++j) {
    model::Link link;
    link.name = std::string(kJointNames[j]) + "_" + name(arm);
    link.parent = base_index + 1 + kParents[j];
    link.joint = j == kInsertion ? model::JointKind::kPrismatic : model::JointKind::kRevolute;
    link.X_PJ = dhJoint(arm, g, j, zero[j]);
    // DH theta (or d) grows with the robot coordinate, except for grasper 1.
    link.axis = Vector3::UnitZ() * (j == kGrasp1 ? -rate[j] : rate[j]);
    link.inertial = dhInertial(arm, j);
    raven->description.links.push_back(link);
    at(raven->links, arm)[j] = base_index + 1 + static_cast<int>(j);
  }
}

inline model::RavenModel dhRaven(const ArmsConfig& arms) {
  model::RavenModel raven;
  raven.description.name = "dh_raven";
  raven.description.file = "test/unit/plant/dh_raven.h";
  raven.arms = arms;
  for (const Arm arm : kArms) {
    Pose& X_WB = at(raven.X_WB, arm);
    X_WB.p = toEigen(at(arms.rcm_W, arm));
    // core/frames.h: gold x up, y toward the surgeon (-x of W), z right (-y of W); green x up, y forward, z left.
    if (arm == Arm::kGold) {
      X_WB.R << 0, -1, 0, 0, 0, -1, 1, 0, 0;
    } else {
      X_WB.R << 0, 1, 0, 0, 0, 1, 1, 0, 0;
    }
    addArm(arm, &raven);
  }
  return raven;
}

}  // namespace raven2_trainer::plant::test
