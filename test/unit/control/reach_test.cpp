#include "raven2_trainer/control/reach.h"

#include <gtest/gtest.h>

#include <set>

namespace raven2_trainer::control {
namespace {

using kinematics::IkStatus;

TEST(IsAtEdge, IsOfTheArmWhoseHandAsksForMoreAndOnlyWhileAHandMoves) {
  const std::set<Mode> by_hand{Mode::kTeleoperating, Mode::kChoosing, Mode::kSimulating, Mode::kTrial};
  const std::set<IkStatus> beyond{IkStatus::kClamped, IkStatus::kOutOfReach, IkStatus::kSingularRcm, IkStatus::kTooFar};
  for (const Arm arm : kArms) {
    for (std::size_t m = 0; m < kModeCount; ++m) {
      for (std::uint32_t status = 0; status <= static_cast<std::uint32_t>(IkStatus::kSingularWrist); ++status) {
        ModelState model;
        model.mode = static_cast<Mode>(m);
        at(model.arms, arm).ik_status = status;
        const bool is_beyond = beyond.count(static_cast<IkStatus>(status)) > 0 && by_hand.count(model.mode) > 0;
        EXPECT_EQ(isAtEdge(model, arm), is_beyond) << kModeNames[m] << " " << status;
        EXPECT_FALSE(isAtEdge(model, otherArm(arm))) << kModeNames[m] << " " << status;
      }
    }
  }
}

}  // namespace
}  // namespace raven2_trainer::control
