#pragma once

#include <Eigen/Core>

#include "raven2_trainer/core/guide_path.h"
#include "raven2_trainer/haptics/haptics_config.h"

namespace raven2_trainer::haptics {

/**
 * Guidance virtual fixture (Rosenberg 1993): a spring from the tip to the nearest point of the path, past an end to
 * that end. At most `max_force`. From `reach` on the force fades, at twice that it is gone, so a surgeon can leave the
 * path. The size depends only on the distance d to the path, and the direction is that of -grad d. So the force is the
 * gradient of a potential, the integral of the size over d. A closed motion of the hand gains no energy from
 * it. Between the ends
 * there is no force along the path. Where two points of the path are equally near the direction jumps, the potential
 * does not. A tip that is not finite, or a path without points, gives none. Real-time safe: one pass over the path.
 *
 * @param[in] tip_B [m] in the frame B of the path's arm.
 * @return [N] at the hand, in B.
 */
Eigen::Vector3d pathGuidance(const GuidanceConfig& config,
                             const GuidePath& path,
                             const Eigen::Vector3d& tip_B) noexcept;

/** Next fade of a guidance: rises with time while there is something to follow, 0 at once when not.
 *  @param[in] seconds [s] since the last tick. @return 0 to 1. */
double nextFade(const GuidanceConfig& config, double fade, bool is_guided, double seconds) noexcept;

}  // namespace raven2_trainer::haptics
