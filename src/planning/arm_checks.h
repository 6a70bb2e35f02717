#pragma once

#include <vector>

#include "planning/arm_clearance.h"
#include "planning/arm_collision.h"
#include "planning/joint_space.h"
#include "planning/motion_cost.h"

namespace raven2_trainer::planning {

/**
 * All that a plan asks about what one arm touches. States and edges are free if they keep the clearance, by the
 * distance grid. Start and goal, once allowed, need only not touch, by FCL: the arm may be nearer than the
 * clearance there, and then the clearance does not hold for its edges near that end.
 *
 * Keeps scratch space: one thread at a time.
 */
class ArmChecks {
 public:
  /** @param[in] edge_step [-] as PlannerConfig: for edges at ends that are nearer than the clearance. Models and grid
   * must outlive this.
   *  @param[in] poll called now and then. @throw ModelException as what it is made of; what `poll` throws. */
  ArmChecks(const model::RavenModel& raven,
            const SceneObstacles& scene,
            const DistanceGrid& grid,
            Arm arm,
            double clearance,
            double edge_step,
            const Poll& poll = {});

  /** Begins a plan: no end is allowed any more. */
  void begin(const JointSpace& space, const JointArray& other);

  bool isFree(const UnitState& unit) noexcept;
  bool isEdgeFree(const UnitState& a, const UnitState& b);
  /** An end that does not touch, but may be nearer than the clearance. @return false if it touches. */
  bool allowEnd(const UnitState& end);
  /** True of what allowEnd() let pass though it is not free. */
  bool isAllowedEnd(const UnitState& unit) const;
  /** [m] lower bound of the distance to whatever is near, at most `cap`. */
  double clearance(const JointArray& q, double cap) noexcept;
  /** The same for the cost. Lives as long as this. */
  ClearanceFunction clearanceFunction();

 private:
  bool touches(const UnitState& unit);
  bool isFreeNear(const std::vector<UnitState>& ends, const UnitState& unit);

  const double edge_step_;
  JointSpace space_;
  ArmClearance kept_;                  // with the clearance
  ArmClearance bare_;                  // without: how far things truly are
  ArmCollision judge_;                 // without
  std::vector<UnitState> tight_ends_;  // nearer than the clearance
};

}  // namespace raven2_trainer::planning
