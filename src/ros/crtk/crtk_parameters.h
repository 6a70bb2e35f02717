#pragma once

#include <ros/node_handle.h>
#include <xmlrpcpp/XmlRpcValue.h>

#include "raven2_trainer/control/crtk_config.h"
#include "raven2_trainer/kinematics/arms_config.h"

namespace raven2_trainer::ros_bridge {

/**
 * Facts about an arm that clients of the robot's own branch `crtk` read from the parameter server. That branch loads
 * them from its params/raven_gold_crtk.yaml and raven_green_crtk.yaml. They are num_joints, home_jpos and is_prismatic;
 * home_pos and home_quat (x, y, z, w), where measured_cp of that branch is after homing; grasper_name, the jaws'
 * namespace.
 */
XmlRpc::XmlRpcValue ravenParameters(const CrtkConfig& config, Arm arm, const ArmGeometry& geometry);

/** Sets them in the arm's namespace. Those that are there already stay. Two calls to the master. */
void setRavenParameters(const ros::NodeHandle& node, const CrtkConfig& config, Arm arm, const ArmGeometry& geometry);

}  // namespace raven2_trainer::ros_bridge
