#pragma once

#include <array>
#include <functional>
#include <limits>

#include "planning/joint_space.h"
#include "raven2_trainer/kinematics/arms_config.h"
#include "raven2_trainer/planning/planner_config.h"

namespace raven2_trainer::planning {

/** Duration [s] of the rest-to-rest quintic from `a` to `b` within the limits of `config`. */
double edgeDuration(const PlannerConfig& config, const JointArray& a, const JointArray& b) noexcept;

/**
 * Integral of the squared linear acceleration of the tip [m2/s3] over the rest-to-rest quintic from `a` to `b`.
 *
 * Along the edge the tip depends on the quintic's value s alone. So its acceleration is p'' s'^2 + p' s''.
 * Both derivatives are exact, from the chain. Gauss's formula integrates the square at 12
 * instants: relative error under 2e-4 on edges of 0.85 in the cube, the longest that FMT* tries. Neither the shoulder's
 * angle nor what turns everything changes a length, so they are left out. Exactly symmetric in `a` and `b`. Real-time
 * safe.
 */
double tipEffort(const ArmGeometry& geometry,
                 Arm arm,
                 const JointArray& a,
                 const JointArray& b,
                 double duration) noexcept;

/** [m] lower bound of the distance to whatever is near, exact or not below the cap; negative in touch. */
using ClearanceFunction = std::function<double(const UnitState&, double cap)>;

/** Data of a motion's ends for the bound of its cost. */
struct MotionEnd {
  UnitState unit{};
  Vec3 tip_B{};  ///< [m] [@frame B]
};

/** Weights of a cost: eta1, eta2, eta3, and the range [m] of the third. */
struct CostWeights {
  double length{}, acceleration{}, clearance{}, range{};
};

/**
 * The cost of one edge: eq. (1) of the paper, eta1 x length in the unit cube + eta2 x tip effort, and a third term,
 * eta3 x integral of max(0, 1 - d/range)^2 ds, d the distance to obstacles. The paper does not say how |alpha|^2 is
 * added up over waypoints; here the arm rests at each, so edges are independent and their costs add up.
 */
class MotionCost {
 public:
  /** @param[in] clearance may be empty: then the third term is 0. */
  MotionCost(const ArmGeometry& geometry,
             Arm arm,
             const JointSpace& space,
             const PlannerConfig& limits,
             const CostWeights& weights,
             ClearanceFunction clearance);

  MotionEnd end(const UnitState& unit) const noexcept;

  /**
   * Never more than plain(): a tip that goes from rest to rest over D in T has an effort of at least 12 D^2 / T^3
   * (the cubic's, by Cauchy and Schwarz).
   */
  double lowerBound(const MotionEnd& a, const MotionEnd& b) const noexcept;

  /** Eq. (1): without the clearance term. */
  double plain(const UnitState& a, const UnitState& b) const noexcept;

  /**
   * The clearance term, by Simpson's rule with steps of at most 0.03 in the cube: at the mean speed of a tip (0.25 m a
   * unit) some 8 mm, less than half the range. Symmetric up to rounding.
   *
   * Every state adds to the sum, so that a part of it is a lower bound: as soon as it reaches `limit` the rest is not
   * asked for. Below `limit` the result is the term to the last bit, else at least `limit` and no more than the term.
   */
  double clearanceTerm(const UnitState& a,
                       const UnitState& b,
                       double limit = std::numeric_limits<double>::infinity()) const;

  bool countsClearance() const noexcept { return weights_.clearance > 0.0 && clearance_; }
  double lengthWeight() const noexcept { return weights_.length; }

 private:
  double duration(const UnitState& a, const UnitState& b) const noexcept;

  const ArmGeometry geometry_;
  const Arm arm_;
  const JointSpace space_;
  const CostWeights weights_;
  const ClearanceFunction clearance_;
  UnitState seconds_{}, square_seconds_{};  // duration for one unit by the velocity limits, its square by the others
};

}  // namespace raven2_trainer::planning
