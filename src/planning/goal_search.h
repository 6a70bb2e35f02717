#pragma once

#include <functional>

#include "planning/joint_space.h"
#include "raven2_trainer/core/command.h"
#include "raven2_trainer/kinematics/arms_config.h"
#include "raven2_trainer/kinematics/eigen.h"

namespace raven2_trainer::planning {

struct GoalChoice {
  PlanStatus status{PlanStatus::kGoalUnreachable};  ///< kSuccess, kGoalUnreachable or kGoalInCollision
  UnitState goal{};                                 ///< with kSuccess
};

/**
 * Joints that put the tip at `p_BT`, with any orientation: the collision-free ones nearest to the start in the unit
 * cube. They come from the inverse kinematics of a fixed set of orientations: the start's own, and its tilts in steps
 * of 15 degrees about 13 axes. `stop` is polled between candidates; true ends the search without a goal.
 */
GoalChoice findGoal(const ArmGeometry& geometry,
                    Arm arm,
                    const JointSpace& space,
                    const JointArray& start,
                    const Vector3& p_BT,
                    const std::function<bool(const UnitState&)>& is_free,
                    const std::function<bool()>& stop);

}  // namespace raven2_trainer::planning
