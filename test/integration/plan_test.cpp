#include <std_srvs/Trigger.h>

#include "fixture.h"
#include "raven2_trainer/PlanPath.h"

namespace raven2_trainer {
namespace {

PlanPath::Response plan(const std::string& arm) {
  PlanPath call;
  call.request.arm = arm;
  call.request.default_goal = true;
  EXPECT_TRUE(ros::service::waitForService("plan", ros::Duration(kStartDeadline)));
  EXPECT_TRUE(ros::service::call("plan", call));
  return call.response;
}

TEST(Plan, AnUnknownArmIsRefused) {
  const PlanPath::Response response = plan("third");
  EXPECT_FALSE(response.success);
  EXPECT_NE(response.status.find("gold"), std::string::npos);
}

TEST(Plan, ThePathFromTheDomeToTheRingIsTrackedByTheModelWhileTheRobotHolds) {
  Latest<sensor_msgs::JointState> model("model/joint_states"), robot("robot/joint_states");
  const auto isAtHome = [](const sensor_msgs::JointState& state) {
    return std::abs(position(state, "shoulder_L") - 0.5236) < 0.002 &&
           std::abs(position(state, "insertion_L") + 0.07) < 0.0002;
  };
  ASSERT_TRUE(waitFor([&] { return isAtHome(robot.get()) && isAtHome(model.get()); }, kStartDeadline))
      << "the robot did not home";
  const double held = position(robot.get(), "insertion_L");

  const PlanPath::Response response = plan("gold");
  ASSERT_TRUE(response.success) << response.status;
  EXPECT_GT(response.cost, 0.0);
  EXPECT_GT(response.planning_time, 0.0);
  ASSERT_GE(response.trajectory.points.size(), 2U);
  EXPECT_EQ(response.trajectory.joint_names.at(2), "insertion_L");

  const auto& goal = response.trajectory.points.back();
  const auto reached = [&] {
    return std::abs(position(model.get(), "shoulder_L") - goal.positions[0]) < 0.01 &&
           std::abs(position(model.get(), "elbow_L") - goal.positions[1]) < 0.01 &&
           std::abs(position(model.get(), "insertion_L") - goal.positions[2]) < 0.002;
  };
  EXPECT_FALSE(reached()) << "the arm was already at the goal: the test shows nothing";
  EXPECT_TRUE(waitFor(reached, goal.time_from_start.toSec() + 5.0)) << "the model did not get there";
  EXPECT_NEAR(position(robot.get(), "insertion_L"), held, 1e-3) << "the robot moved";
}

}  // namespace
}  // namespace raven2_trainer

RAVEN2_INTEGRATION_MAIN("plan_test")
