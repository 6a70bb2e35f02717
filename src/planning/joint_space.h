#pragma once

#include <array>

#include "raven2_trainer/kinematics/arms_config.h"

namespace raven2_trainer::planning {

constexpr std::size_t kPlanDimension = 6;

/** Shoulder, elbow, insertion, tool rotation, wrist, jaw mid-line, each scaled to [0, 1] between its limits. */
using UnitState = std::array<double, kPlanDimension>;

/** Euclidean distance: c(sigma) of eq. (1) along a straight edge. */
double distance(const UnitState& a, const UnitState& b) noexcept;

/** Straight line from `a` (s = 0) to `b` (s = 1). */
UnitState interpolate(const UnitState& a, const UnitState& b, double s) noexcept;

/** The unit cube of one plan: the six planned joints at a fixed jaw opening (paper, 2.3.1, assumption 2). */
class JointSpace {
 public:
  /** @param[in] opening [rad] grasp1 + grasp2; with it the two grasper limits bound the mid-line. */
  JointSpace(const ArmGeometry& geometry, double opening) noexcept;

  UnitState toUnit(const JointArray& q) const noexcept;
  /** Robot joints: grasp1 = opening / 2 - mid-line, grasp2 = opening / 2 + mid-line (raven2.md 2.3). */
  JointArray toJoints(const UnitState& unit) const noexcept;

  /** True if every number is finite and within [-slack, 1 + slack], and the opening leaves the mid-line room. */
  bool contains(const UnitState& unit, double slack) const noexcept;

 private:
  double opening_;
  UnitState lower_{}, range_{};  // [rad, m]
};

}  // namespace raven2_trainer::planning
