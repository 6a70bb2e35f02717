#include "raven2_trainer/kinematics/joint_conventions.h"

namespace raven2_trainer::kinematics {
namespace {

constexpr PerArm<std::array<const char*, kJointCount>> kNames{
    {{"shoulder_L", "elbow_L", "insertion_L", "tool_roll_L", "wrist_joint_L", "grasper_joint_1_L", "grasper_joint_2_L"},
     {"shoulder_R", "elbow_R", "insertion_R", "tool_roll_R", "wrist_joint_R", "grasper_joint_1_R",
      "grasper_joint_2_R"}}};

constexpr double kRollOffset = kPi / 4;  // raven2.md 5.4: -45 degrees on L, +45 on R

double rollOffset(Arm arm) noexcept {
  return arm == Arm::kGold ? -kRollOffset : kRollOffset;
}

}  // namespace

const std::array<const char*, kJointCount>& urdfJointNames(Arm arm) noexcept {
  return at(kNames, arm);
}

JointArray rateToUrdf(Arm arm, const JointArray& rate) noexcept {
  JointArray urdf = rate;
  if (arm == Arm::kGreen) urdf[kWrist] = -rate[kWrist];
  urdf[kGrasp2] = -rate[kGrasp2];
  return urdf;
}

JointArray toUrdf(Arm arm, double d4, const JointArray& q) noexcept {
  JointArray urdf = rateToUrdf(arm, q);
  urdf[kInsertion] += d4;
  urdf[kToolRotation] += rollOffset(arm);
  return urdf;
}

JointArray fromUrdf(Arm arm, double d4, const JointArray& urdf) noexcept {
  JointArray q = rateToUrdf(arm, urdf);
  q[kInsertion] -= d4;
  q[kToolRotation] -= rollOffset(arm);
  return q;
}

}  // namespace raven2_trainer::kinematics
