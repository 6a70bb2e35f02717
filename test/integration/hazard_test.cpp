#include <std_srvs/Trigger.h>

#include <algorithm>

#include "fixture.h"
#include "raven2_trainer/StartHazard.h"

namespace raven2_trainer {
namespace {

StartHazard::Response startHazard(const std::string& name) {
  StartHazard call;
  call.request.name = name;
  EXPECT_TRUE(ros::service::waitForService("start_hazard", ros::Duration(kStartDeadline)));
  EXPECT_TRUE(ros::service::call("start_hazard", call));
  return call.response;
}

TEST(SuddenJump, AnUnknownHazardIsRefusedWithTheKnownNames) {
  const StartHazard::Response response = startHazard("no_such_hazard");
  EXPECT_FALSE(response.success);
  EXPECT_NE(response.message.find("sudden_jump"), std::string::npos) << response.message;
}

TEST(SuddenJump, IsFeltAsAForceTowardTheModelAndEndsWhenCleared) {
  Latest<sensor_msgs::JointState> model("model/joint_states"), robot("robot/joint_states");
  Latest<geometry_msgs::WrenchStamped> gold("haptic/gold/force"), green("haptic/green/force");
  ASSERT_TRUE(startHazard("sudden_jump").success);
  ASSERT_TRUE(waitFor([&] { return isMoving(model); }, kStartDeadline));
  // The scenario waits 3 s (run_rostest) after the first pedal-down, and a little more where the surgeon clutches.
  ASSERT_TRUE(waitFor([&] { return magnitude(gold.get()) > 0.0; }, 30.0)) << "the jump was never felt";
  double strongest = 0.0, part = 0.0;
  const int begin = gold.count();
  waitFor(
      [&] {
        strongest = std::max(strongest, magnitude(gold.get()));
        part = std::max(part, std::abs(position(model.get(), "shoulder_L") - position(robot.get(), "shoulder_L")));
        return gold.count() >= begin + 30;
      },
      5.0);
  EXPECT_LE(strongest, 3.3 + 1e-9) << "the force exceeds its cap";
  EXPECT_GT(part, 0.02) << "the robot's shoulder did not leave the model's";
  EXPECT_EQ(magnitude(green.get()), 0.0) << "the other arm is not concerned";

  std_srvs::Trigger stop;
  ASSERT_TRUE(ros::service::call("stop_hazard", stop));
  EXPECT_TRUE(stop.response.success);
  EXPECT_TRUE(waitFor([&] { return magnitude(gold.get()) == 0.0; }, 5.0)) << "the robot never came back";
}

}  // namespace
}  // namespace raven2_trainer

RAVEN2_INTEGRATION_MAIN("hazard_test")
