#include "planning/arm_chain.h"

#include <algorithm>

#include "planning/sin_cos.h"
#include "raven2_trainer/kinematics/joint_conventions.h"
#include "raven2_trainer/kinematics/shortest_turn.h"

namespace raven2_trainer::planning {

ArmChain::ArmChain(const model::RavenModel& raven, Arm arm) : raven_(raven), arm_(arm) {
  const auto& links = raven.description.links;
  std::vector<Pose> poses(links.size());
  model::linkPoses(raven.description, std::vector<double>(links.size(), 0.0), &poses);
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const auto link = static_cast<std::size_t>(at(raven.links, arm)[j]);
    const Quaternion along_axis = kinematics::shortestTurn(Vector3::UnitZ(), links[link].axis);
    X_WJ_[j] = poses[link] * Pose{along_axis.toRotationMatrix(), Vector3::Zero()};
    const int before = parent(static_cast<int>(j));
    X_PJ_[j] = before < 0 ? X_WJ_[j] : X_WJ_[static_cast<std::size_t>(before)].inverse() * X_WJ_[j];
  }
}

JointArray ArmChain::positions(const JointArray& q) const noexcept {
  return kinematics::toUrdf(arm_, raven_.arms.geometry.d4, q);
}

void ArmChain::place(Joint joint, double c, double s, Frames* X_WJ) const noexcept {
  const int before = parent(static_cast<int>(joint));
  const Pose& X_PJ = X_PJ_[joint];
  Pose& X = (*X_WJ)[joint];
  X = before < 0 ? X_PJ : (*X_WJ)[static_cast<std::size_t>(before)] * X_PJ;
  const Vector3 x = X.R.col(0);
  X.R.col(0) = c * x + s * X.R.col(1);
  X.R.col(1) = c * X.R.col(1) - s * x;
}

void ArmChain::placeShaft(const JointArray& u, Frames* X_WJ) const noexcept {
  Pair s, c, s_roll, c_roll;
  sinCos(Pair{u[kShoulder], u[kElbow]}, &s, &c);
  sinCos(Pair{u[kToolRotation], 0.0}, &s_roll, &c_roll);
  place(kShoulder, c[0], s[0], X_WJ);
  place(kElbow, c[1], s[1], X_WJ);
  place(kInsertion, 1.0, 0.0, X_WJ);
  Pose& inserted = (*X_WJ)[kInsertion];
  inserted.p += u[kInsertion] * inserted.R.col(2);
  place(kToolRotation, c_roll[0], s_roll[0], X_WJ);
}

void ArmChain::placeTool(const JointArray& u, Frames* X_WJ) const noexcept {
  Pair s, c, s_jaws, c_jaws;
  sinCos(Pair{u[kWrist], 0.0}, &s, &c);
  sinCos(Pair{u[kGrasp1], u[kGrasp2]}, &s_jaws, &c_jaws);
  place(kWrist, c[0], s[0], X_WJ);
  place(kGrasp1, c_jaws[0], s_jaws[0], X_WJ);
  place(kGrasp2, c_jaws[1], s_jaws[1], X_WJ);
}

ArmChain::Mount ArmChain::mount(int link) const {
  const auto& links = raven_.description.links;
  std::vector<Pose> poses(links.size());
  model::linkPoses(raven_.description, std::vector<double>(links.size(), 0.0), &poses);
  const auto& joints = at(raven_.links, arm_);
  auto joint = joints.end();
  for (int i = link; joint == joints.end(); i = links[static_cast<std::size_t>(i)].parent)
    joint = std::find(joints.begin(), joints.end(), i);
  const auto index = static_cast<std::size_t>(joint - joints.begin());
  return {static_cast<int>(index), X_WJ_[index].inverse() * poses[static_cast<std::size_t>(link)]};
}

}  // namespace raven2_trainer::planning
