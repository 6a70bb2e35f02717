#pragma once

#include <ros/node_handle.h>
#include <ros/service_server.h>

#include <string>
#include <vector>

#include "raven2_trainer/kinematics/arms_config.h"
#include "ros/crtk/crtk_frames.h"
#include "ros/crtk/crtk_query.h"

namespace raven2_trainer::ros_bridge {

/** [rad; m] of a query, joints as measured_js has them: six, or in the robot's own dialect seven.
 *  @return false, and why, of another length, or with NaN or infinity. */
bool readQuery(const std::vector<double>& jp, bool is_raven, JointArray* q, std::string* why);

/** Where the tip is in a frame at joints `jp`, which must be within their limits. */
crtk::ForwardResponse answer(const ArmGeometry& geometry,
                             Arm arm,
                             const CrtkFrame& frame,
                             bool is_raven,
                             const crtk::ForwardRequest& query);
/** Joints within their limits for a pose in a frame, those next to `jp`; the jaws' opening stays. */
crtk::InverseResponse answer(const ArmGeometry& geometry,
                             Arm arm,
                             const CrtkFrame& frame,
                             bool is_raven,
                             const crtk::InverseRequest& query);

/** The services forward_kinematics and inverse_kinematics of an arm, in `world`, and under local/ in its base. They
 * move nothing. */
class CrtkKinematics {
 public:
  CrtkKinematics(ros::NodeHandle* node,
                 Arm arm,
                 const std::string& name,
                 const ArmGeometry& geometry,
                 const Pose& X_WB,
                 bool is_raven);

  std::vector<std::string> names() const;  ///< resolved

 private:
  std::vector<ros::ServiceServer> services_;
};

}  // namespace raven2_trainer::ros_bridge
