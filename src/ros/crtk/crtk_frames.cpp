#include "ros/crtk/crtk_frames.h"

namespace raven2_trainer::ros_bridge {

CrtkFrame worldFrame(const Pose& X_WB) {
  return {"world", {"world"}, X_WB.inverse()};
}

CrtkFrame baseFrame(Arm arm) {
  const std::string link = arm == Arm::kGold ? "base_link_L" : "base_link_R";
  return {"model/" + link, {"model/" + link, "robot/" + link}, Pose{}};
}

CrtkFrame ravenFrame(Arm arm) {
  const double s = arm == Arm::kGold ? -1.0 : 1.0;
  Matrix3 R_RB;
  R_RB << 0.0, s, 0.0, 0.0, 0.0, s, 1.0, 0.0, 0.0;
  return {"", {}, Pose{R_RB.transpose(), Vector3::Zero()}};
}

std::string jawNamespace(const CrtkConfig& config, Arm arm) {
  if (config.dialect == CrtkDialect::kRaven) return arm == Arm::kGold ? "grasp1" : "grasp2";
  return at(config.names, arm) + "/jaw";
}

}  // namespace raven2_trainer::ros_bridge
