#pragma once

#include "loop/activity/planning.h"

namespace raven2_trainer::loop {

/** The surgeon shows a plan's goal. The hands move one arm, kinematically; everything else in the world keeps its
 * place. An object in the jaws stays where it is, and the arm comes back to it. */
class GoalSelection final : public Activity {
 public:
  GoalSelection(Planning* planning, Stage* stage) noexcept : Activity(stage), planning_(*planning) {}

  void leave(Mode next) noexcept override;
  void tick() noexcept override;
  void move() noexcept override;
  PlanningAnswer request(const Request& request) noexcept override;

 private:
  PlanningAnswer begin(Arm arm) noexcept;
  PlanningAnswer record(Request request) noexcept;
  PlanningAnswer end() noexcept;
  Arm arm() const noexcept { return planning_.store().state().arm; }

  Planning& planning_;
};

}  // namespace raven2_trainer::loop
