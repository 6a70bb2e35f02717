#include "ros/crtk/crtk_parameters.h"

#include <array>
#include <initializer_list>

#include "raven2_trainer/kinematics/arm_kinematics.h"
#include "ros/crtk/crtk_frames.h"

namespace raven2_trainer::ros_bridge {
namespace {

template <typename Value, typename Numbers>
XmlRpc::XmlRpcValue listOf(const Numbers& numbers) {
  XmlRpc::XmlRpcValue list;
  list.setSize(static_cast<int>(numbers.size()));
  int i = 0;
  for (const auto& number : numbers)
    list[i++] = static_cast<Value>(number);
  return list;
}

}  // namespace

XmlRpc::XmlRpcValue ravenParameters(const CrtkConfig& config, Arm arm, const ArmGeometry& geometry) {
  const Pose home = ravenFrame(arm).X_BR.inverse() * kinematics::forward(geometry, arm, geometry.home);
  const Quaternion q(home.R);
  std::array<int, kJointCount> is_prismatic{};
  is_prismatic[kInsertion] = 1;
  XmlRpc::XmlRpcValue parameters;
  parameters["num_joints"] = static_cast<int>(kJointCount);
  parameters["home_jpos"] = listOf<double>(geometry.home);
  parameters["home_pos"] = listOf<double>(std::initializer_list<double>{home.p.x(), home.p.y(), home.p.z()});
  parameters["home_quat"] = listOf<double>(std::initializer_list<double>{q.x(), q.y(), q.z(), q.w()});
  parameters["is_prismatic"] = listOf<int>(is_prismatic);
  parameters["grasper_name"] = jawNamespace(config, arm);
  return parameters;
}

void setRavenParameters(const ros::NodeHandle& node, const CrtkConfig& config, Arm arm, const ArmGeometry& geometry) {
  XmlRpc::XmlRpcValue all, own = ravenParameters(config, arm, geometry);
  node.getParam(at(config.names, arm), all);
  if (all.valid() && all.getType() != XmlRpc::XmlRpcValue::TypeStruct) return;
  for (auto& [name, value] : own)
    if (!all.hasMember(name)) all[name] = value;
  node.setParam(at(config.names, arm), all);
}

}  // namespace raven2_trainer::ros_bridge
