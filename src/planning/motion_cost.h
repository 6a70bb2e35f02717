#pragma once

#include "planning/joint_space.h"
#include "raven2_trainer/core/config.h"

namespace raven2_trainer::planning {

/** Duration [s] of the rest-to-rest quintic from `a` to `b` within the limits of `config`. */
double edgeDuration(const PlannerConfig& config, const JointArray& a, const JointArray& b) noexcept;

/**
 * Integral of the squared linear acceleration of the tip [m2/s3] over the rest-to-rest quintic from `a` to `b`.
 *
 * The tip is taken at 17 Chebyshev points of time, its second derivative is that of the polynomial through them, and
 * the square is integrated by Clenshaw-Curtis quadrature on the same points: spectral accuracy for a smooth path,
 * so 17 points do (under 0.01 % on edges as long as FMT* tries, 0.05 % on longer ones). Exactly symmetric in `a` and
 * `b`. Real-time safe.
 */
double tipEffort(const ArmGeometry& geometry,
                 Arm arm,
                 const JointArray& a,
                 const JointArray& b,
                 double duration) noexcept;

/**
 * Eq. (1) of the paper for one edge: eta1 x length in the unit cube + eta2 x tip effort. The paper does not say how
 * |alpha|^2 is added up over waypoints; here the arm rests at each, so edges are independent and their costs add up.
 * Not cached by the search: only one call in four is a repeat (measured on the FRS scene).
 */
double edgeCost(const ArmGeometry& geometry,
                const PlannerConfig& config,
                const JointSpace& space,
                Arm arm,
                const UnitState& a,
                const UnitState& b) noexcept;

}  // namespace raven2_trainer::planning
