#pragma once

#include "loop/activity/activity.h"
#include "loop/activity/plan_store.h"
#include "raven2_trainer/control/path_follower.h"

namespace raven2_trainer::loop {

/** A plan is computed, and then shown by the model: planning, tracking. Keeps the plan (PlanStore) in other modes, too.
 */
class Planning final : public Activity {
 public:
  /** @throw ModelException for a collision shape that is a mesh. */
  Planning(const model::RavenModel& raven, const model::SceneModel& scene, Stage* stage);

  PlanStore& store() noexcept { return store_; }
  const PlanStore& store() const noexcept { return store_; }
  /** Asks the planner. As many may be under way as the rings hold: no answer can find its ring full, and whether one is
   *  refused follows from the record. */
  PlanningAnswer plan(Request request) noexcept;
  /** The plan that the configuration asks for (runtime.yaml, plan_at). Once a tick. */
  void planBySchedule() noexcept;
  /** Takes what the planner answered. Once a tick. */
  void takeResults() noexcept;
  /** Nothing shows a plan any more. */
  void stopShowing() noexcept { follower_.stop(); }

  void leave(Mode next) noexcept override;
  void settle(Mode next, control::Event event) noexcept override;
  void tick() noexcept override;
  PlanningAnswer request(const Request& request) noexcept override { return plan(request); }

 private:
  void lead(PerArm<JointArray>* target) noexcept override;
  std::uint32_t nextOwnId() noexcept;

  PlanStore store_;
  control::PathFollower follower_;
  bool is_scheduled_{true};  ///< a plan that is still to come
  std::uint32_t next_id_{0};
};

}  // namespace raven2_trainer::loop
