#pragma once

#include <Eigen/Core>

#include "raven2_trainer/haptics/haptics_config.h"

namespace raven2_trainer::haptics {

/**
 * Cue at the edge of the master's workspace, a box. There is no force in a box that is smaller by `margin` on every
 * side. Outside it a force towards it rises without a jump to `max_force`, reached `margin` away from it (in the middle
 * of a face: at the edge itself), and stays there. It depends on the distance to a convex body alone, so that it has a
 * potential: nothing can be gained from it in a cycle, but for the link's delay, which PassivityGuard watches.
 * Real-time safe.
 *
 * @param[in] hand_I [m] of the hand from the middle of the box, axes I; what is not finite gives no force.
 * @return [N] at the hand, axes I.
 */
Eigen::Vector3d workspaceEdge(const EdgeConfig& config, const Eigen::Vector3d& hand_I) noexcept;

}  // namespace raven2_trainer::haptics
