#pragma once

#include <vector>

#include "planning/arm_collision.h"
#include "planning/joint_space.h"
#include "planning/motion_cost.h"

namespace raven2_trainer::planning {

/**
 * All that a plan asks about what one arm touches. States and edges are free if they keep the clearance. Start and
 * goal, once allowed, need only not touch: the arm may stand nearer than the clearance, and then the edges there are
 * let off it near that end.
 *
 * Keeps scratch space: one thread at a time.
 */
class ArmChecks {
 public:
  /** @param[in] edge_step [-] as PlannerConfig. The models must outlive this. */
  ArmChecks(const model::RavenModel& raven, const SceneObstacles& scene, Arm arm, double clearance, double edge_step);

  /** Begins a plan: no end is allowed any more. */
  void begin(const JointSpace& space, const JointArray& other);

  bool isFree(const UnitState& unit);
  bool isEdgeFree(const UnitState& a, const UnitState& b);
  /** FCL's word, clearance left aside. */
  bool touches(const UnitState& unit);
  /** An end that does not touch, but may be nearer than the clearance. @return false if it touches. */
  bool allowEnd(const UnitState& end);
  /** True of what allowEnd() let pass, be it free or not. */
  bool isAllowedEnd(const UnitState& unit) const;
  /** Distances to whatever is near, for the cost; empty if there is nothing to tell them. Lives as long as this. */
  ClearanceFunction clearanceFunction();
  /** FCL's word, with the clearance. */
  bool isNear(const JointArray& q, const JointArray& other);

 private:
  bool isFreeNear(const UnitState& end, const UnitState& unit);

  const double edge_step_;
  JointSpace space_;
  ArmCollision near_, bare_;
  std::vector<UnitState> tight_ends_;  // nearer than the clearance
};

}  // namespace raven2_trainer::planning
