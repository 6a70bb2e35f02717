#include "loop/activity/activities.h"

#include <gtest/gtest.h>

#include "support/activity_stage.h"

namespace raven2_trainer::loop {
namespace {

class ActivitiesTest : public raven2_trainer::testing::ActivityStage {};

TEST_F(ActivitiesTest, AReplayBeginsInTheModesOfTheTable) {
  Activities activities(raven, scene, stage.config.live_camera, 1.0, &stage);
  for (std::size_t mode = 0; mode < kModeCount; ++mode) {
    stage.state.mode = static_cast<Mode>(mode);
    Request begin;
    begin.kind = RequestKind::kBeginReplay;
    begin.id = kOwnRequestIds + 1;
    begin.plan = static_cast<std::uint32_t>(mode) + 1;
    EXPECT_TRUE(activities.serve(begin));
    RequestAnswer answer;
    ASSERT_TRUE(shared->answers.tryPop(&answer));
    const bool is_begun = answer.answer == PlanningAnswer::kAccepted;
    EXPECT_EQ(is_begun, traitsOf(static_cast<Mode>(mode)).may_replay) << kModeNames[mode];
    EXPECT_EQ(stage.mode(), is_begun ? Mode::kReplaying : static_cast<Mode>(mode));
  }
}

}  // namespace
}  // namespace raven2_trainer::loop
