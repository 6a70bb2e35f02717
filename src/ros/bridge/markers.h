#pragma once

#include <ros/time.h>
#include <visualization_msgs/MarkerArray.h>

#include "raven2_trainer/core/contact.h"
#include "raven2_trainer/core/state.h"
#include "raven2_trainer/kinematics/eigen.h"

// Contacts and forces as markers of RViz, in frame world and in the picture's colours (render/overlays.h). Numbers that
// are not finite are left out.

namespace raven2_trainer::ros_bridge {

/** [m/N] An arrow of 1 N is 20 mm long: the largest force on the hand, 3.3 N, is the longest arrow but for cut ones. */
constexpr double kArrowPerNewton = 0.02;
/** [m] Longer arrows are cut: a grip presses with 45 N. */
constexpr double kLongestArrow = 0.07;

/** `contact_points`, a ball each, and `contact_forces` on the first of the two bodies, a line each. */
visualization_msgs::MarkerArray contactMarkers(const ContactList& contacts, const ros::Time& stamp);

/** `hand_forces`: at the model's tool tip of each arm the force of its master, if there is a force. */
visualization_msgs::MarkerArray forceMarkers(const ModelState& model,
                                             const HapticState& haptic,
                                             const PerArm<Pose>& X_WB,
                                             const ros::Time& stamp);

}  // namespace raven2_trainer::ros_bridge
