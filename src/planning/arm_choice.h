#pragma once

#include "planning/goal_search.h"

namespace raven2_trainer::planning {

/** Prospects of one arm for a goal. */
struct ArmProspect {
  bool may_start{};   ///< it is within its limits and touches nothing
  GoalChoice goal{};  ///< of this arm
  double distance{};  ///< [-] from its place to that goal in the unit cube
};

/**
 * Which arm is to move (paper, 2.3.3: a decision module ahead of FMT*): of those that may start and reach the goal the
 * one with the shorter way in the unit cube, `asked` where both ways are the same. If none can, `asked`, whose reason
 * is the answer then; unless only the other one reaches that far and finds the place taken.
 */
Arm chooseArm(Arm asked, const PerArm<ArmProspect>& prospects) noexcept;

}  // namespace raven2_trainer::planning
