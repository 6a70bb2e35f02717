#include "ros/planning/planning_messages.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>

#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"

namespace raven2_trainer::ros_bridge {
namespace {

constexpr double kDegree = kPi / 180.0;
constexpr double kD4 = -0.47;  // [m] raven2.md 2.1

TEST(ErrorCodes, AreThoseOfMoveIt) {
  // https://docs.ros.org/en/api/moveit_msgs/html/msg/MoveItErrorCodes.html
  const std::map<std::string, int> plans{{"none", 99999},
                                         {"success", 1},
                                         {"start_in_collision", -10},
                                         {"goal_unreachable", -31},
                                         {"goal_in_collision", -12},
                                         {"no_path", -1},
                                         {"cancelled", -7},
                                         {"dynamics_infeasible", -2},
                                         {"time_limit", -6},
                                         {"invalid_start", -26},
                                         {"failed", 99999}};
  const std::map<std::string, int> answers{
      {"none", -25}, {"accepted", 1},   {"not_now", -17},           {"no_plan", -2},
      {"moved", -3}, {"no_robot", -23}, {"robot_cannot_follow", -2}};
  const std::map<std::string, int> ends{{"none", 99999},     {"finished", 1},   {"released", -7},    {"cancelled", -7},
                                        {"e_stop", -30},     {"time_slip", -4}, {"robot_lost", -23}, {"off_path", -4},
                                        {"not_settled", -4}, {"no_pedal", -6},  {"moved", -3}};
  for (std::size_t i = 0; i < kPlanStatusCount; ++i)
    EXPECT_EQ(number(errorCode(static_cast<PlanStatus>(i))), plans.at(kPlanStatusNames[i])) << kPlanStatusNames[i];
  for (std::size_t i = 0; i < kPlanningAnswerCount; ++i)
    EXPECT_EQ(number(errorCode(static_cast<PlanningAnswer>(i))), answers.at(kPlanningAnswerNames[i]))
        << kPlanningAnswerNames[i];
  for (std::size_t i = 0; i < kExecutionEndCount; ++i)
    EXPECT_EQ(number(errorCode(static_cast<ExecutionEnd>(i))), ends.at(kExecutionEndNames[i])) << kExecutionEndNames[i];
  EXPECT_EQ(errorCode(static_cast<ExecutionEnd>(200)), ErrorCode::kFailure);
}

WantedPlan wanted(const std::string& arm) {
  WantedPlan plan;
  plan.arm = arm;
  return plan;
}

TEST(PlanRequests, WithoutAnArmThePlannerChooses) {
  WantedPlan plan = wanted("");
  plan.default_goal = true;
  const ReadRequest read = planRequest(plan, kD4);
  ASSERT_TRUE(read.isGood());
  EXPECT_EQ(read.request.kind, RequestKind::kPlan);
  EXPECT_EQ(read.request.goal, GoalKind::kDefault);
  EXPECT_EQ(read.request.choose_arm, 1);
}

TEST(PlanRequests, ATipInTheWorld) {
  WantedPlan plan = wanted("green");
  plan.goal_W = {0.01, -0.02, 0.03};
  const ReadRequest read = planRequest(plan, kD4);
  ASSERT_TRUE(read.isGood());
  EXPECT_EQ(read.request.goal, GoalKind::kTip);
  EXPECT_EQ(read.request.choose_arm, 0);
  EXPECT_EQ(read.request.arm, Arm::kGreen);
  EXPECT_EQ(read.request.goal_W, plan.goal_W);
}

TEST(PlanRequests, JointsComeInTheCoordinatesOfTheTopics) {
  WantedPlan plan = wanted("green");
  // raven2.md 5.4: insertion + d4, tool roll + 45 degrees, wrist negated on R, grasper 2 negated
  plan.joints = {0.5, 1.5, 0.40 + kD4, 0.1 + 45 * kDegree, -0.2, 0.3, -0.4};
  const ReadRequest read = planRequest(plan, kD4);
  ASSERT_TRUE(read.isGood()) << read.status;
  EXPECT_EQ(read.request.goal, GoalKind::kJoints);
  const JointArray expected{0.5, 1.5, 0.40, 0.1, 0.2, 0.3, 0.4};
  for (std::size_t j = 0; j < kJointCount; ++j)
    EXPECT_NEAR(read.request.goal_q[j], expected[j], 1e-12) << kJointNames[j];
}

TEST(PlanRequests, AreRefusedWithTheirReason) {
  EXPECT_EQ(planRequest(wanted("third"), kD4).code, ErrorCode::kInvalidGroupName);
  EXPECT_NE(planRequest(wanted("third"), kD4).status.find("gold"), std::string::npos);

  WantedPlan few = wanted("gold");
  few.joints = {0.1, 0.2};
  EXPECT_EQ(planRequest(few, kD4).code, ErrorCode::kInvalidGoalConstraints);
  WantedPlan whose = wanted("");
  whose.joints.assign(7, 0.1);
  EXPECT_EQ(planRequest(whose, kD4).code, ErrorCode::kInvalidGroupName);
  WantedPlan nowhere = wanted("gold");
  nowhere.goal_W[1] = std::nan("");
  EXPECT_EQ(planRequest(nowhere, kD4).code, ErrorCode::kInvalidGoalConstraints);
  WantedPlan endless = wanted("gold");
  endless.joints.assign(7, 0.1);
  endless.joints[6] = std::numeric_limits<double>::infinity();
  EXPECT_EQ(planRequest(endless, kD4).code, ErrorCode::kInvalidGoalConstraints);
}

class PathMessages : public ::testing::Test {
 protected:
  PathMessages() {
    // Only the insertion moves, by 30 and 20 mm, so the tip moves straight along the tool.
    plan.status = PlanStatus::kSuccess;
    plan.arm = Arm::kGold;
    plan.waypoint_count = 3;
    for (std::size_t i = 0; i < 3; ++i)
      plan.waypoints[i] = {0.5, 1.5, 0.40, 0.3, 0.2, 0.7, 0.8};
    plan.waypoints[1][kInsertion] = 0.43;
    plan.waypoints[2][kInsertion] = 0.45;
    plan.arrival = {0.0, 1.25, 2.5};
  }

  TrainerConfig config{config::loadTrainerConfig(RAVEN2_TRAINER_SOURCE_DIR "/config/trainer.yaml")};
  PlanResult plan;
};

TEST_F(PathMessages, ATrajectoryRestsAtItsPointsForAnyPlayer) {
  const trajectory_msgs::JointTrajectory message = trajectory(plan, kD4);
  EXPECT_EQ(message.joint_names.at(2), "insertion_L");
  EXPECT_TRUE(message.header.stamp.isZero()) << "a zero stamp means: begin on arrival";
  ASSERT_EQ(message.points.size(), 3U);
  EXPECT_NEAR(message.points[1].positions.at(2), 0.43 - 0.47, 1e-12);
  EXPECT_EQ(message.points[1].velocities, std::vector<double>(7, 0.0));
  EXPECT_EQ(message.points[1].accelerations, std::vector<double>(7, 0.0));
  EXPECT_EQ(message.points[2].time_from_start, ros::Duration(2.5));
}

TEST_F(PathMessages, TheTipsPathIsStraightAndAsLongAsTheInsertion) {
  Pose X_WB;
  X_WB.p = Vector3(1.0, 2.0, 3.0);
  const nav_msgs::Path path = tipPath(plan, config.arms.geometry, X_WB, ros::Time(4.0));
  EXPECT_EQ(path.header.frame_id, "world");
  EXPECT_EQ(path.header.stamp, ros::Time(4.0));
  ASSERT_EQ(path.poses.size(), 41U);
  const auto at = [&](std::size_t i) {
    const geometry_msgs::Point& p = path.poses[i].pose.position;
    return Vector3(p.x, p.y, p.z);
  };
  const Vector3 way = at(40) - at(0);
  EXPECT_NEAR(way.norm(), 0.05, 1e-12);
  for (std::size_t i = 0; i < path.poses.size(); ++i) {
    const double gone = i <= 20 ? 0.03 * static_cast<double>(i) / 20 : 0.03 + 0.02 * static_cast<double>(i - 20) / 20;
    EXPECT_NEAR((at(i) - at(0) - gone * way.normalized()).norm(), 0.0, 1e-12) << i;
    EXPECT_EQ(path.poses[i].pose.orientation, path.poses[0].pose.orientation) << i;
    EXPECT_EQ(path.poses[i].header.frame_id, "world");
  }
}

TEST_F(PathMessages, TheTipsPathTurnsAndShiftsWithTheArmsBase) {
  Pose X_WB;  // a quarter turn about z: x to y
  X_WB.R << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  X_WB.p = Vector3(0.1, 0.2, 0.3);
  const geometry_msgs::PoseStamped moved = tipPath(plan, config.arms.geometry, X_WB, {}).poses.front();
  const geometry_msgs::PoseStamped plain = tipPath(plan, config.arms.geometry, Pose(), {}).poses.front();
  EXPECT_NEAR(moved.pose.position.x, 0.1 - plain.pose.position.y, 1e-12);
  EXPECT_NEAR(moved.pose.position.y, 0.2 + plain.pose.position.x, 1e-12);
  EXPECT_NEAR(moved.pose.position.z, 0.3 + plain.pose.position.z, 1e-12);
  const auto rotation = [](const geometry_msgs::Quaternion& q) {
    return Quaternion(q.w, q.x, q.y, q.z).toRotationMatrix();
  };
  EXPECT_TRUE(rotation(moved.pose.orientation).isApprox(X_WB.R * rotation(plain.pose.orientation), 1e-12));
}

TEST_F(PathMessages, APathWithoutWaypointsIsEmpty) {
  plan.waypoint_count = 0;
  EXPECT_TRUE(tipPath(plan, config.arms.geometry, Pose(), {}).poses.empty());
  EXPECT_TRUE(trajectory(plan, kD4).points.empty());
}

TEST_F(PathMessages, TheTipsErrorCountsFromWhereTheModelIsWanted) {
  ModelState model;
  RobotState robot;
  model.planning.arm = Arm::kGreen;
  ArmState& arm = at(model.arms, Arm::kGreen);
  arm.q_d = plan.waypoints[0];
  const Vector3 wanted_B = kinematics::forward(config.arms.geometry, Arm::kGreen, arm.q_d).p;
  arm.p_BT = toArray(Vector3(wanted_B + Vector3(0.003, 0.0, 0.004)));
  at(robot.arms, Arm::kGreen).p_BT = toArray(Vector3(wanted_B - Vector3(0.0, 0.012, 0.005)));

  model.planning.status = PlanningStatus::kArmed;
  EXPECT_EQ(tipErrors(model, robot, config.arms.geometry).model, 0.0);
  model.planning.status = PlanningStatus::kExecuting;
  EXPECT_NEAR(tipErrors(model, robot, config.arms.geometry).model, 0.005, 1e-12);
  EXPECT_EQ(tipErrors(model, robot, config.arms.geometry).robot, 0.0) << "the robot does not move";
  model.planning.on_robot = 1;
  EXPECT_NEAR(tipErrors(model, robot, config.arms.geometry).robot, 0.013, 1e-12);
}

TEST(StatusClocks, CountFromTheFirstLookAtAStatusAndPlan) {
  StatusClock clock;
  ModelState model;
  model.tick = 1000;
  EXPECT_TRUE(clock.look(model));
  model.tick = 1250;
  EXPECT_FALSE(clock.look(model));
  EXPECT_NEAR(clock.elapsed(), 0.25, 1e-12);
  model.planning.status = PlanningStatus::kPlanning;
  model.planning.plan = 3;
  EXPECT_TRUE(clock.look(model));
  EXPECT_EQ(clock.elapsed(), 0.0);
  model.tick = 1300;
  model.planning.plan = 4;
  EXPECT_TRUE(clock.look(model)) << "another plan starts the clock again";
  EXPECT_EQ(clock.elapsed(), 0.0);
}

TEST(ProgressMessages, SayWhatIsUnderWay) {
  PlanningState state;
  state.status = PlanningStatus::kExecuting;
  state.arm = Arm::kGreen;
  state.on_robot = 1;
  state.plan = 12;
  state.progress = 0.75;
  const PlanningProgress message = planningProgress(state, {100, 200, 3, 4.5}, 1.5, ros::Time(3.0));
  EXPECT_EQ(message.status, "executing");
  EXPECT_EQ(message.arm, "green");
  EXPECT_TRUE(message.on_robot);
  EXPECT_EQ(message.plan, 12U);
  EXPECT_EQ(message.progress, 0.75);
  EXPECT_EQ(message.elapsed, 1.5);
  EXPECT_EQ(message.samples, 100U);
  EXPECT_EQ(message.edges, 200U);
  EXPECT_EQ(message.rollouts, 3U);
  EXPECT_EQ(message.best_cost, 4.5);
  EXPECT_EQ(message.header.stamp, ros::Time(3.0));
}

TEST(ExecutionMessages, HoldTheWholeReport) {
  ExecutionReport report;
  report.id = 1;
  report.plan = 2;
  report.arm = Arm::kGreen;
  report.on_robot = 1;
  report.end = ExecutionEnd::kReleased;
  report.started = 3;
  report.ended = 4;
  report.path_time = 5.0;
  report.progress = 0.6;
  report.planned_clearance = 7.0;
  report.model = {8.0, 9.0, 10.0};
  report.robot = {11.0, 12.0, 13.0};
  report.model_clearance = 13.5;
  report.robot_clearance = 13.7;
  report.contact_ticks = 14;
  report.contact_points = 15;
  const PlanExecution message = planExecution(report, ros::Time(16.0));
  EXPECT_EQ(message.header.stamp, ros::Time(16.0));
  EXPECT_EQ(message.execution, 1U);
  EXPECT_EQ(message.plan, 2U);
  EXPECT_EQ(message.arm, "green");
  EXPECT_TRUE(message.on_robot);
  EXPECT_EQ(message.end, "released");
  EXPECT_EQ(message.error_code, -7);
  EXPECT_EQ(message.started, 3);
  EXPECT_EQ(message.ended, 4);
  EXPECT_EQ(message.path_time, 5.0);
  EXPECT_EQ(message.progress, 0.6);
  EXPECT_EQ(message.planned_clearance, 7.0);
  EXPECT_EQ(message.model_error_mean, 8.0);
  EXPECT_EQ(message.model_error_largest, 9.0);
  EXPECT_EQ(message.model_error_at_end, 10.0);
  EXPECT_EQ(message.robot_error_mean, 11.0);
  EXPECT_EQ(message.robot_error_largest, 12.0);
  EXPECT_EQ(message.robot_error_at_end, 13.0);
  EXPECT_EQ(message.model_clearance, 13.5);
  EXPECT_EQ(message.robot_clearance, 13.7);
  EXPECT_EQ(message.contact_ticks, 14U);
  EXPECT_EQ(message.contact_points, 15U);
}

PlanResult answer(std::uint32_t id, PlanStatus status) {
  PlanResult result;
  result.id = id;
  result.status = status;
  return result;
}

TEST(NewestPath, IsNotHiddenByAnAnswerThatIsNone) {
  const auto good = PlanStatus::kSuccess, bad = PlanStatus::kNoPath, stopped = PlanStatus::kCancelled;
  const auto idOf = [](const std::vector<PlanResult>& answers) {
    const PlanResult* path = newestPath(answers);
    return path == nullptr ? 0U : path->id;
  };
  EXPECT_EQ(idOf({answer(1, good), answer(2, bad)}), 1U);
  EXPECT_EQ(idOf({answer(1, good), answer(2, good), answer(3, bad), answer(4, stopped)}), 2U);
  EXPECT_EQ(idOf({answer(1, bad), answer(2, good)}), 2U);
  EXPECT_EQ(idOf({answer(1, bad)}), 0U);
  EXPECT_EQ(idOf({}), 0U);
}

/** An empty path clears the one that a subscriber shows. */
TEST(PlanMessages, OfNoPlanHaveNoPoints) {
  EXPECT_TRUE(trajectory(PlanResult{}, kD4).points.empty());
  const nav_msgs::Path path = tipPath(PlanResult{}, ArmGeometry{}, Pose{}, ros::Time());
  EXPECT_TRUE(path.poses.empty());
  EXPECT_EQ(path.header.frame_id, "world");
}

/** raven2.md 5.4: the green arm's names end in R, its wrist is negated and its tool rotates inversely. */
TEST_F(PathMessages, OfTheGreenArmHaveItsNamesSignsAndKinematics) {
  plan.arm = Arm::kGreen;
  const trajectory_msgs::JointTrajectory message = trajectory(plan, kD4);
  EXPECT_EQ(message.joint_names.at(0), "shoulder_R");
  EXPECT_EQ(message.joint_names.at(4), "wrist_joint_R");
  const std::vector<double>& q = message.points.at(0).positions;
  EXPECT_NEAR(q.at(3), 0.3 + 45 * kDegree, 1e-12);
  EXPECT_NEAR(q.at(4), -0.2, 1e-12);
  EXPECT_NEAR(q.at(6), -0.8, 1e-12);
  const nav_msgs::Path path = tipPath(plan, config.arms.geometry, Pose(), ros::Time(4.0));
  const Vector3 tip = kinematics::forward(config.arms.geometry, Arm::kGreen, plan.waypoints[2]).p;
  const geometry_msgs::Point& end = path.poses.back().pose.position;
  EXPECT_NEAR((Vector3(end.x, end.y, end.z) - tip).norm(), 0.0, 1e-12);
}

/** Both tips of the executing arm are off the place on the path: by 5 mm (3-4-5) and 10 mm (6-8-10). */
TEST_F(PathMessages, TipErrorsAreThoseOfTheArmThatExecutes) {
  for (const Arm arm : kArms) {
    const Arm other = arm == Arm::kGold ? Arm::kGreen : Arm::kGold;
    ModelState model;
    RobotState robot;
    model.planning.status = PlanningStatus::kExecuting;
    model.planning.arm = arm;
    at(model.arms, arm).q_d = plan.waypoints[1];
    at(model.arms, other).p_BT = at(robot.arms, other).p_BT = {9, 9, 9};
    const Vector3 wanted = kinematics::forward(config.arms.geometry, arm, plan.waypoints[1]).p;
    at(model.arms, arm).p_BT = toArray(Vector3(wanted + Vector3(0.003, -0.004, 0.0)));
    at(robot.arms, arm).p_BT = toArray(Vector3(wanted + Vector3(0.0, 0.006, -0.008)));
    EXPECT_NEAR(tipErrors(model, robot, config.arms.geometry).model, 0.005, 1e-12) << name(arm);
    EXPECT_EQ(tipErrors(model, robot, config.arms.geometry).robot, TipErrors{}.robot) << "the robot does not follow";
    model.planning.on_robot = 1;
    EXPECT_NEAR(tipErrors(model, robot, config.arms.geometry).robot, 0.010, 1e-12) << name(arm);
    model.planning.status = PlanningStatus::kArmed;
    EXPECT_EQ(tipErrors(model, robot, config.arms.geometry).model, TipErrors{}.model) << "nothing is executed";
  }
}

}  // namespace
}  // namespace raven2_trainer::ros_bridge
