#pragma once

#include <atomic>
#include <memory>

#include "raven2_trainer/core/command.h"
#include "raven2_trainer/core/config.h"
#include "raven2_trainer/model/raven_model.h"

namespace raven2_trainer::planning {

/**
 * FMT* path planner for one arm, six joints at a fixed jaw opening (paper, 2.3). State space normalised to the unit
 * cube; cost eq. (1); FCL judges collisions on the shapes of the URDFs. Own OMPL problem per plan(); never the live
 * ODE world. Allocates and keeps scratch space: one thread at a time, the planner thread or lockstep.
 *
 * Deviation from the paper: edges are tested on the straight line in joint space with a clearance, not by a rollout
 * of the dynamics. The free bodies of the scene (the ring) are no obstacles: the goal is at the ring.
 */
class PathPlanner {
 public:
  /** `raven` must outlive this. @throw ModelException if a collision shape is a mesh. */
  PathPlanner(const model::RavenModel& raven, const model::SceneModel& scene, const PlannerConfig& config);
  ~PathPlanner();

  /**
   * Plans. Never throws for what is asked: every failure is a status. Stops on `samples` and, unless `lockstep`, on
   * the time limit (then kNoPath); the same request and seed give the same path.
   * kStartInCollision also stands for a start outside the limits or not finite; kNoPath for a path of more than
   * kMaxWaypoints. planning_time is measured here unless `lockstep`, which leaves it 0.
   * @param[in] cancel set from another thread to give up within 100 ms.
   */
  PlanResult plan(const PlanRequest& request, std::uint64_t seed, bool lockstep, const std::atomic<bool>& cancel);

  /** True if the arm at `q` touches the scene, itself or the other arm at `other`, or is nearer than the clearance. */
  bool inCollision(Arm arm, const JointArray& q, const JointArray& other) const;

  /** Cost of eq. (1) of the straight rest-to-rest motion from `a` to `b`; the opening is that of `a`. */
  double edgeCost(Arm arm, const JointArray& a, const JointArray& b) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace raven2_trainer::planning
