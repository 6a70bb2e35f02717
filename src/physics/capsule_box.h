#pragma once

#include <array>

#include "raven2_trainer/kinematics/eigen.h"

namespace raven2_trainer::physics {

/** A point where a capsule overlaps a box. */
struct OverlapPoint {
  Vector3 p_W{0, 0, 0};  ///< [m] in the middle of the overlap
  Vector3 n_W{0, 0, 1};  ///< [-] unit, from the box towards the capsule
  double depth{};        ///< [m] negative: a gap
};

using OverlapPoints = std::array<OverlapPoint, 3>;

/**
 * Overlap of a capsule about z (`length` without its round ends) with a box of half edges `half`; exact.
 *
 * The deepest point, and both ends of the stretch that the bar shares with the face or edge it lies along. ODE's own
 * capsule-box gives one point, which jumps between the ends: a resting bar twitches and a bar between two jaws turns
 * about the line through its two points. Real-time safe.
 *
 * @param[in] margin [m] gaps up to this count too.
 * @return number of points, 0 to 3
 */
int overlapCapsuleBox(const Pose& X_WC,
                      double radius,
                      double length,
                      const Pose& X_WB,
                      const Vector3& half,
                      double margin,
                      OverlapPoints* points) noexcept;

}  // namespace raven2_trainer::physics
