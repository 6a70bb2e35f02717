#include "planning/arm_choice.h"

namespace raven2_trainer::planning {
namespace {

/** 2 reaches the goal, 1 would reach it without obstacles, 0 does not. */
int rank(const ArmProspect& prospect) noexcept {
  if (!prospect.may_start) return 0;
  if (prospect.goal.status == PlanStatus::kSuccess) return 2;
  return prospect.goal.status == PlanStatus::kGoalInCollision ? 1 : 0;
}

}  // namespace

Arm chooseArm(Arm asked, const PerArm<ArmProspect>& prospects) noexcept {
  const Arm other = asked == Arm::kGold ? Arm::kGreen : Arm::kGold;
  const ArmProspect &first = at(prospects, asked), &second = at(prospects, other);
  if (rank(first) != rank(second)) return rank(first) > rank(second) ? asked : other;
  return rank(first) == 2 && second.distance < first.distance ? other : asked;
}

}  // namespace raven2_trainer::planning
