#pragma once

#include <string>
#include <vector>

#include "raven2_trainer/control/crtk_config.h"
#include "raven2_trainer/kinematics/eigen.h"

// Frames that CRTK clients may speak of poses in, and where jaws are called (doc/crtk.md).

namespace raven2_trainer::ros_bridge {

/** A frame R for poses, increments and twists of an arm, published and commanded. */
struct CrtkFrame {
  std::string name;                  ///< header.frame_id of published messages; "": empty
  std::vector<std::string> allowed;  ///< header.frame_id of accepted commands; "" is always accepted
  Pose X_BR{};                       ///< R in the arm's base B
};

/** `world`, of the topics without a prefix. */
CrtkFrame worldFrame(const Pose& X_WB);

/** The arm's base B, of the topics under local/: `model/base_link_L` or `_R`, heard as `robot/...` too. */
CrtkFrame baseFrame(Arm arm);

/** The frame that the robot's own branch `crtk` turns its base to (T_crtk_in_r0 of its crtk_motion_api.cpp): the origin
 *  of B, gold (-y, -z, x) of B, green (y, z, x). It has no name there. */
CrtkFrame ravenFrame(Arm arm);

/** Namespace of an arm's jaws: below the arm's; in the robot's own dialect `grasp1` gold, `grasp2` green. */
std::string jawNamespace(const CrtkConfig& config, Arm arm);

}  // namespace raven2_trainer::ros_bridge
