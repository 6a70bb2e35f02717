#include "planning/arm_choice.h"

#include <gtest/gtest.h>

namespace raven2_trainer::planning {
namespace {

ArmProspect prospect(bool may_start, PlanStatus status, double distance) {
  return {may_start, {status, {}}, distance};
}

const ArmProspect kNear = prospect(true, PlanStatus::kSuccess, 0.2), kFar = prospect(true, PlanStatus::kSuccess, 0.7);
const ArmProspect kTaken = prospect(true, PlanStatus::kGoalInCollision, 0.0);
const ArmProspect kBeyond = prospect(true, PlanStatus::kGoalUnreachable, 0.0);
const ArmProspect kStuck = prospect(false, PlanStatus::kGoalUnreachable, 0.0);

struct Row {
  ArmProspect gold, green;
  Arm from_gold, from_green;  // the choice if the request names gold, or green
};

TEST(ChooseArm, TakesWhoReachesTheGoalThenWhoIsNearer) {
  const std::vector<Row> rows{
      {kNear, kFar, Arm::kGold, Arm::kGold},       {kFar, kNear, Arm::kGreen, Arm::kGreen},
      {kNear, kNear, Arm::kGold, Arm::kGreen},     {kFar, kBeyond, Arm::kGold, Arm::kGold},
      {kTaken, kFar, Arm::kGreen, Arm::kGreen},    {kBeyond, kTaken, Arm::kGreen, Arm::kGreen},
      {kBeyond, kBeyond, Arm::kGold, Arm::kGreen}, {kStuck, kFar, Arm::kGreen, Arm::kGreen},
      {kStuck, kStuck, Arm::kGold, Arm::kGreen},
  };
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const PerArm<ArmProspect> prospects{rows[i].gold, rows[i].green};
    EXPECT_EQ(chooseArm(Arm::kGold, prospects), rows[i].from_gold) << "row " << i;
    EXPECT_EQ(chooseArm(Arm::kGreen, prospects), rows[i].from_green) << "row " << i;
  }
}

}  // namespace
}  // namespace raven2_trainer::planning
