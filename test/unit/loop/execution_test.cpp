#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "loop/plan_cancelled.h"
#include "raven2_trainer/control/path_follower.h"
#include "raven2_trainer/control/path_relay.h"
#include "raven2_trainer/core/random.h"
#include "raven2_trainer/loop/planner_worker.h"
#include "raven2_trainer/planning/clearance_gauge.h"
#include "support/effort.h"
#include "support/rig.h"

// Tests how a goal is chosen and a plan is armed and executed, with the virtual Raven: doc/execution.md.

namespace raven2_trainer::loop {
namespace {

using raven2_trainer::testing::effort;
using raven2_trainer::testing::packagedConfig;
using raven2_trainer::testing::Rig;

constexpr JointArray kClear{0.12, 0.08, 0.015, 0.3, 0.2, 0.1, -0.1};  ///< from home to a pose clear of the scene

double apart(const Vec3& a, const Vec3& b) {
  return (toEigen(a) - toEigen(b)).norm();
}

class Execution : public ::testing::Test {
 protected:
  static TrainerConfig configuration() {
    TrainerConfig config = packagedConfig();
    config.hazard = "none";
    config.runtime.plan_at = -1.0;
    config.planner.samples = 100;
    config.execution.pedal_timeout = 3.0;
    return config;
  }

  void SetUp() override {
    raven2_trainer::testing::useOde();
    rig = std::make_unique<Rig>(configuration());
    ASSERT_TRUE(rig->home());
    rest(false, 200);
  }

  void rest(bool pedal, int ticks, const Vec3& gold_dp_I = {}) {
    for (int i = 0; i < ticks; ++i)
      rig->tick(pedal, gold_dp_I);
  }

  /** Sends a request and runs one tick. @return the answer. */
  PlanningAnswer ask(RequestKind kind, std::uint8_t on_robot = 0, std::uint32_t plan = 0, Arm arm = Arm::kGold) {
    Request request;
    request.kind = kind;
    request.arm = arm;
    request.id = ++last_id;
    request.on_robot = on_robot;
    request.plan = plan;
    EXPECT_TRUE(rig->shared->requests.tryPush(request));
    rig->tick(false);
    EXPECT_EQ(planning().answered, last_id);
    return planning().answer;
  }

  PlanningState planning() const { return rig->model().planning; }
  ExecutionReport report() const { return rig->shared->last_execution.load(); }
  Vec3 modelTip() const { return rig->model().arms[0].p_BT; }
  Vec3 robotTip() const { return rig->robot().arms[0].p_BT; }
  Vec3 tipAt(const JointArray& q) const {
    return toArray(kinematics::forward(rig->config.arms.geometry, Arm::kGold, q).p);
  }

  /** @return a planner's answer: a straight path there and a little back, within the planner's limits. */
  PlanResult answerTo(const PlanRequest& request, const JointArray& delta) const {
    const PlannerConfig& limits = rig->config.planner;
    PlanResult plan;
    plan.id = request.id;
    plan.status = PlanStatus::kSuccess;
    plan.arm = request.arm;
    plan.waypoint_count = 3;
    plan.waypoints = {request.start, request.start, request.start};
    for (std::size_t j = 0; j < kJointCount; ++j) {
      plan.waypoints[1][j] += delta[j];
      plan.waypoints[2][j] += 0.8 * delta[j];
    }
    const double there = control::quinticDuration(delta, limits.velocity_limit, limits.acceleration_limit);
    plan.arrival[1] = there;
    plan.arrival[2] = 2.0 * there;
    plan.clearance = clearance;
    const ItpRules& rules = rig->config.network.itp;
    const control::IncrementLimits packet{static_cast<double>(rules.max_increment_um), rules.max_rotation};
    const control::ArmController law(rig->config.model, plan.arm);
    plan.robot_follows = control::robotFollows(rig->config.arms.geometry, packet, law, plan) ? 1 : 0;
    return plan;
  }

  /** Requests a plan and answers the request. The model then shows the plan. */
  void plan(Arm arm = Arm::kGold) {
    ASSERT_EQ(ask(RequestKind::kPlan, 0, 0, arm), PlanningAnswer::kAccepted);
    ASSERT_EQ(planning().status, PlanningStatus::kPlanning);
    ASSERT_TRUE(rig->shared->plan_requests.tryPop(&asked));
    planned = answerTo(asked, kClear);
    ASSERT_TRUE(rig->shared->plan_results.tryPush(planned));
    rest(false, 1);
    ASSERT_EQ(rig->model().mode, Mode::kTracking);
    ASSERT_EQ(planning().status, PlanningStatus::kReady);
  }

  void arm(bool on_robot) {
    plan();
    ASSERT_EQ(ask(RequestKind::kExecutePlan, on_robot ? 1 : 0), PlanningAnswer::kAccepted);
    ASSERT_EQ(rig->model().mode, Mode::kArmed);
    ASSERT_EQ(planning().status, PlanningStatus::kArmed);
    rest(false, 20);
  }

  const JointArray& goal() const { return planned.waypoints[planned.waypoint_count - 1]; }

  /** Holds the pedal until the execution is over. @return ticks. */
  int hold(int limit = 10000) {
    int ticks = 0;
    do {
      rig->tick(true);
    } while (++ticks < limit && rig->model().mode == Mode::kExecuting);
    return ticks;
  }

  /** Runs a tick in which the robot reports `state`, whatever it really does. Our packets no longer reach it. */
  void tickWith(RobotState* state, bool pedal) {
    rig->hear(state);
    rig->tick(pedal);
  }

  /** The robot reports its present position, at this run level. */
  void robotSays(RunLevel level, int ticks, bool pedal) {
    RobotState state = rig->robot();
    state.runlevel = level;
    for (int i = 0; i < ticks; ++i)
      tickWith(&state, pedal);
  }

  std::unique_ptr<Rig> rig;
  PlanRequest asked;  ///< newest request to the planner; the test is the planner
  PlanResult planned;
  double clearance{0.003};  ///< [m] clearance of the path, as the planner reports it
  std::uint32_t last_id{40};
};

TEST_F(Execution, ReachesTheGoalOnModelAndRobotFromACommonPose) {
  arm(/*on_robot=*/true);
  const Vec3 green = rig->robot().arms[1].p_BT;
  rest(true, 1);
  EXPECT_EQ(rig->model().mode, Mode::kExecuting);
  EXPECT_EQ(rig->model().linked, 1);
  EXPECT_LT(rig->error(Arm::kGold), 0.1e-3);
  const int ticks = hold();
  const ExecutionReport done = report();
  EXPECT_EQ(done.end, ExecutionEnd::kFinished);
  EXPECT_EQ(done.plan, planned.id);
  EXPECT_EQ(done.id, last_id);
  EXPECT_EQ(done.on_robot, 1);
  EXPECT_EQ(done.progress, 1.0);
  EXPECT_EQ(done.contact_ticks, 0U);
  EXPECT_GE(ticks, static_cast<int>(1000.0 * (planned.arrival[2] + rig->config.execution.hold_time)));
  EXPECT_LT(apart(modelTip(), tipAt(goal())), rig->config.execution.settle_tolerance);
  EXPECT_LT(apart(robotTip(), tipAt(goal())), rig->config.execution.settle_tolerance);
  EXPECT_LT(done.model.largest, 0.008);
  EXPECT_LT(done.robot.largest, 0.008);
  // At home the nearest object is 19 mm away. The path keeps about that distance, far from everything else.
  EXPECT_NEAR(done.model_clearance, done.robot_clearance, 0.002);
  EXPECT_GT(done.model_clearance, 0.005);
  EXPECT_LT(done.model_clearance, 0.05);
  EXPECT_GT(apart(tipAt(goal()), tipAt(planned.waypoints[0])), 0.01) << "the arm must have a path to follow";
  EXPECT_LT(apart(rig->robot().arms[1].p_BT, green), 0.5e-3) << "the other arm holds";
  EXPECT_EQ(rig->last_relay.command.pedal, 0);
  EXPECT_EQ(rig->model().mode, Mode::kPedalUp);
  EXPECT_EQ(planning().status, PlanningStatus::kIdle);
  EXPECT_EQ(rig->robot().itp.rejectedTotal(), 0U);
  std::printf("path %.2f s, executed in %.2f s; model %.2f mm mean, %.2f max, %.2f end; robot %.2f, %.2f, %.2f\n",
              done.path_time, ticks * 1e-3, done.model.mean * 1e3, done.model.largest * 1e3, done.model.at_end * 1e3,
              done.robot.mean * 1e3, done.robot.largest * 1e3, done.robot.at_end * 1e3);
}

TEST_F(Execution, InOpenLoopReachesTheGoal) {
  TrainerConfig config = configuration();
  config.execution.drive = ExecutionDrive::kOpenLoop;
  rig = std::make_unique<Rig>(config);
  ASSERT_TRUE(rig->home());
  rest(false, 200);
  arm(/*on_robot=*/true);
  hold();
  const ExecutionReport done = report();
  EXPECT_EQ(done.end, ExecutionEnd::kFinished);
  EXPECT_LT(done.model.largest, 0.002);
  EXPECT_LT(done.model.at_end, rig->config.execution.settle_tolerance);
}

TEST_F(Execution, IsFinishedOnceTheRobotRests) {
  for (const bool rests : {true, false}) {
    SetUp();
    arm(/*on_robot=*/true);
    for (int i = 0; i < 10000 && planning().progress < 1.0; ++i)
      rig->tick(true);
    ASSERT_EQ(rig->model().mode, Mode::kExecuting);
    RobotState there = rig->robot();
    there.arms[0].q = goal();
    there.arms[0].dq = {};
    there.arms[0].dq[kInsertion] = rests ? 0.0 : 2.0 * rig->config.execution.settle_speed;
    for (int i = 0; i < 3000 && rig->model().mode == Mode::kExecuting; ++i)
      tickWith(&there, true);
    EXPECT_EQ(report().end, rests ? ExecutionEnd::kFinished : ExecutionEnd::kNotSettled);
  }
}

TEST_F(Execution, TheHeldPedalMovesNothingAfterwards) {
  arm(true);
  hold();
  const Vec3 reached = robotTip();
  rest(true, 300, {20e-6, 0.0, 0.0});
  EXPECT_EQ(rig->model().mode, Mode::kPedalUp);
  EXPECT_EQ(rig->last_relay.command.pedal, 0);
  EXPECT_LT(apart(robotTip(), reached), 0.2e-3);
  rest(false, 5);
  rest(true, 1);
  EXPECT_EQ(rig->model().mode, Mode::kTeleoperating) << "from the next pedal-down on the surgeon moves the arms";
}

TEST_F(Execution, OfATrialTheRobotKnowsNothingAndThePlanIsKept) {
  arm(/*on_robot=*/false);
  const Vec3 before = robotTip();
  rest(true, 1);
  EXPECT_EQ(rig->model().linked, 0);
  hold();
  EXPECT_EQ(report().end, ExecutionEnd::kFinished);
  EXPECT_EQ(report().on_robot, 0);
  EXPECT_EQ(report().robot.largest, 0.0);
  EXPECT_LT(apart(modelTip(), tipAt(goal())), rig->config.execution.settle_tolerance);
  EXPECT_LT(apart(robotTip(), before), 1e-6);
  EXPECT_EQ(rig->model().mode, Mode::kTracking) << "the model holds its position";
  EXPECT_EQ(planning().status, PlanningStatus::kReady);
  // WHEN the trial was satisfactory
  rest(false, 10);
  ASSERT_EQ(ask(RequestKind::kExecutePlan, 1), PlanningAnswer::kAccepted);
  hold();
  EXPECT_EQ(report().end, ExecutionEnd::kFinished);
  EXPECT_LT(apart(robotTip(), tipAt(goal())), rig->config.execution.settle_tolerance);
}

TEST_F(Execution, TheArmsMoveOneAfterTheOtherTheSecondFromWhereTheFirstStands) {
  arm(true);
  hold();
  rest(false, 100);
  const JointArray gold = rig->robot().arms[0].q;
  plan(Arm::kGreen);
  for (std::size_t j = 0; j < kGrasp1; ++j)
    EXPECT_NEAR(asked.other[j], gold[j], 1e-3) << kJointNames[j];
  ASSERT_EQ(ask(RequestKind::kExecutePlan, 1), PlanningAnswer::kAccepted);
  rest(false, 5);
  hold();
  EXPECT_EQ(report().end, ExecutionEnd::kFinished);
  EXPECT_EQ(report().arm, Arm::kGreen);
  const Vec3 green = toArray(kinematics::forward(rig->config.arms.geometry, Arm::kGreen, goal()).p);
  EXPECT_LT(apart(rig->robot().arms[1].p_BT, green), rig->config.execution.settle_tolerance);
  EXPECT_LT(apart(rig->model().arms[1].p_BT, green), rig->config.execution.settle_tolerance);
  EXPECT_LT(apart(robotTip(), tipAt(gold)), 0.5e-3) << "the first holds";
}

TEST_F(Execution, ReleaseAtAnyMomentStopsBothWithinTwentyMilliseconds) {
  Random random(5);
  double worst = 0.0;
  const auto releases = static_cast<int>(effort(4, 10));
  for (int release = 0; release < releases; ++release) {
    SetUp();  // each run begins at the same place, so that none depends on the one before
    arm(true);
    const double whole = 1000.0 * (planned.arrival[2] + rig->config.execution.hold_time);
    const double part = (whole - 100.0) / releases;  // one release in each part
    rest(true, static_cast<int>(50.0 + part * random.uniform(release, release + 1.0)));
    ASSERT_EQ(rig->model().mode, Mode::kExecuting) << release;
    rig->tick(false);
    ASSERT_EQ(rig->last_relay.command.pedal, 0) << "the robot's pedal goes up in the same tick";
    ASSERT_EQ(rig->last_relay.command.dp_I[0], Vec3{});
    ASSERT_EQ(rig->model().mode, Mode::kPedalUp);
    ASSERT_EQ(report().end, ExecutionEnd::kReleased);
    ASSERT_EQ(report().ended, rig->model().tick);
    rest(false, 19);
    const JointArray robot = rig->plant.jointPositions(Arm::kGold);
    const Vec3 stopped = tipAt(robot);
    for (int i = 0; i < 300; ++i) {
      rig->tick(false);
      const JointArray now = rig->plant.jointPositions(Arm::kGold);
      worst = std::max(worst, apart(tipAt(now), stopped));
      for (std::size_t j = 0; j <= kInsertion; ++j)  // joints with brakes; the tool's joints coast for 40 ms
        ASSERT_NEAR(now[j], robot[j], 1e-5) << kJointNames[j];
    }
    EXPECT_LT(rig->error(Arm::kGold), 0.1e-3) << "the model is where the robot is";
    EXPECT_EQ(planning().status, PlanningStatus::kIdle);
  }
  EXPECT_LT(worst, 0.15e-3) << "from 20 ms after the release on only the tool's joints coast";
  std::printf("true tip moved %.4f mm from 20 ms after the release on\n", worst * 1e3);
}

TEST_F(Execution, AnEStopEndsItForGood) {
  arm(true);
  rest(true, 400);
  ASSERT_EQ(rig->model().mode, Mode::kExecuting);
  robotSays(RunLevel::kEStop, 1, true);
  rest(true, 1);
  EXPECT_EQ(rig->model().mode, Mode::kStopped);
  EXPECT_EQ(report().end, ExecutionEnd::kEStop);
  EXPECT_GT(report().progress, 0.0);
  EXPECT_EQ(rig->last_relay.command.pedal, 0);
  EXPECT_EQ(planning().status, PlanningStatus::kIdle);
  robotSays(RunLevel::kPedalUp, 3, true);
  EXPECT_EQ(rig->model().mode, Mode::kPedalUp);
  rest(false, 3);
  EXPECT_EQ(ask(RequestKind::kExecutePlan, 1), PlanningAnswer::kNoPlan);
}

TEST_F(Execution, AnEStopDisarms) {
  arm(true);
  robotSays(RunLevel::kEStop, 2, false);
  EXPECT_EQ(report().end, ExecutionEnd::kEStop);
  EXPECT_EQ(report().started, -1);
  EXPECT_EQ(planning().status, PlanningStatus::kIdle);
  robotSays(RunLevel::kPedalUp, 3, false);
  robotSays(RunLevel::kPedalUp, 3, true);
  EXPECT_EQ(rig->model().mode, Mode::kTeleoperating) << "no execution starts";
}

TEST_F(Execution, LostTimeEndsIt) {
  arm(true);
  rest(true, 400);
  rig->physics.timeSlip();
  rest(true, 1);
  EXPECT_EQ(rig->model().mode, Mode::kPaused);
  EXPECT_EQ(report().end, ExecutionEnd::kTimeSlip);
  EXPECT_EQ(rig->last_relay.command.pedal, 0);
  EXPECT_EQ(planning().status, PlanningStatus::kIdle);
}

TEST_F(Execution, LostTimeForgetsAPlanThatWaits) {
  plan();
  rest(true, 20);
  rest(false, 20);
  ASSERT_EQ(planning().status, PlanningStatus::kReady) << "the surgeon may follow it by hand";
  rig->physics.timeSlip();
  rest(false, 1);
  EXPECT_EQ(planning().status, PlanningStatus::kIdle);
}

TEST_F(Execution, ALostRobotEndsIt) {
  arm(true);
  rest(true, 400);
  rig->robot_connected = false;
  rig->link.disconnected();
  rest(true, 2);
  EXPECT_EQ(report().end, ExecutionEnd::kRobotLost);
  EXPECT_NE(rig->model().mode, Mode::kExecuting);
  EXPECT_EQ(rig->last_relay.command.pedal, 0);
  EXPECT_EQ(planning().status, PlanningStatus::kIdle);
}

TEST_F(Execution, ALostRobotDisarms) {
  arm(true);
  rig->robot_connected = false;
  rig->link.disconnected();
  rest(false, 2);
  EXPECT_EQ(report().end, ExecutionEnd::kRobotLost);
  EXPECT_EQ(planning().status, PlanningStatus::kIdle);
  EXPECT_EQ(rig->model().mode, Mode::kPedalUp);
}

TEST_F(Execution, ThePathStandsStillWhileTheRobotIsNotHeard) {
  arm(true);
  rest(true, 400);
  rig->robot_connected = false;
  rest(true, 25);  // a silence of 20 ms is tolerated
  const double stood = planning().progress;
  rest(true, 50);
  EXPECT_EQ(planning().progress, stood);
  EXPECT_EQ(rig->model().mode, Mode::kExecuting);
  EXPECT_EQ(rig->last_relay.command.dp_I[0], Vec3{});
  rig->robot_connected = true;
  rest(true, 100);
  EXPECT_GT(planning().progress, stood);
}

TEST_F(Execution, AReleaseThatComesTogetherWithTheNextPressEndsIt) {
  arm(true);
  rest(true, 400);
  ASSERT_EQ(rig->model().mode, Mode::kExecuting);
  rig->send(MasterCommand{});  // pedal up, and down again in the same tick
  rest(true, 1);
  EXPECT_EQ(report().end, ExecutionEnd::kReleased);
  EXPECT_EQ(rig->last_relay.command.pedal, 0);
  rest(true, 2);
  EXPECT_NE(rig->model().mode, Mode::kExecuting);
}

TEST_F(Execution, ARobotThatGoesToPedalUpByItselfEndsIt) {
  arm(true);
  rest(true, 400);
  ASSERT_EQ(rig->model().mode, Mode::kExecuting);
  robotSays(RunLevel::kPedalUp, 1, true);
  EXPECT_EQ(report().end, ExecutionEnd::kRobotLost);
  EXPECT_EQ(rig->last_relay.command.pedal, 0);
  robotSays(RunLevel::kPedalDown, 5, true);
  EXPECT_NE(rig->model().mode, Mode::kExecuting) << "it continues only after a new pedal-down";
  EXPECT_EQ(rig->last_relay.command.dp_I[0], Vec3{});
}

TEST_F(Execution, DisengagingDisarmsAndEndsATrial) {
  arm(true);
  Request disengage;
  disengage.kind = RequestKind::kDisengage;
  ASSERT_TRUE(rig->shared->requests.tryPush(disengage));
  rest(false, 2);
  EXPECT_EQ(report().end, ExecutionEnd::kCancelled);
  rest(true, 10);
  EXPECT_NE(rig->model().mode, Mode::kExecuting);
  SetUp();
  arm(false);
  rest(true, 400);
  ASSERT_EQ(rig->model().mode, Mode::kExecuting);
  ASSERT_TRUE(rig->shared->requests.tryPush(disengage));
  rest(true, 2);
  EXPECT_EQ(report().end, ExecutionEnd::kCancelled);
  EXPECT_NE(rig->model().mode, Mode::kExecuting);
}

TEST_F(Execution, ANewRobotThatIsReadyAtOnceDisarms) {
  arm(true);
  RobotState state = rig->robot();
  state.cycle = 5;  // the old robot's cycle was far higher
  rig->link.disconnected();
  rig->link.connected();
  tickWith(&state, false);
  EXPECT_EQ(report().end, ExecutionEnd::kRobotLost);
  EXPECT_EQ(planning().status, PlanningStatus::kIdle);
}

TEST_F(Execution, ARobotThatStaysSilentIsGivenUp) {
  arm(true);
  rest(true, 400);
  rig->robot_connected = false;
  rest(true, 600);  // the link is lost after 0.5 s
  EXPECT_EQ(report().end, ExecutionEnd::kRobotLost);
}

TEST_F(Execution, CancelEndsItAtOnce) {
  arm(true);
  rest(true, 400);
  Request request;
  request.kind = RequestKind::kCancelPlan;
  request.id = 77;
  ASSERT_TRUE(rig->shared->requests.tryPush(request));
  rest(true, 1);
  EXPECT_EQ(report().end, ExecutionEnd::kCancelled);
  EXPECT_EQ(rig->last_relay.command.pedal, 0);
  EXPECT_EQ(rig->model().mode, Mode::kPedalUp);
  EXPECT_EQ(planning().status, PlanningStatus::kIdle);
  EXPECT_EQ(planning().answered, 77U);
}

TEST_F(Execution, DisengagingEndsItAtOnce) {
  arm(true);
  rest(true, 400);
  Request request;
  request.kind = RequestKind::kDisengage;
  ASSERT_TRUE(rig->shared->requests.tryPush(request));
  rest(true, 1);
  EXPECT_EQ(report().end, ExecutionEnd::kCancelled);
  EXPECT_EQ(rig->last_relay.command.pedal, 0);
}

TEST_F(Execution, AnotherPlanDisarms) {
  arm(true);
  ASSERT_EQ(ask(RequestKind::kPlan), PlanningAnswer::kAccepted);
  EXPECT_EQ(report().end, ExecutionEnd::kCancelled);
  EXPECT_EQ(planning().status, PlanningStatus::kPlanning);
  EXPECT_EQ(rig->model().mode, Mode::kPlanning);
}

TEST_F(Execution, NoPedalDisarms) {
  arm(true);
  rest(false, static_cast<int>(rig->config.execution.pedal_timeout * 1000.0) - 30);
  EXPECT_EQ(rig->model().mode, Mode::kArmed);
  rest(false, 40);
  EXPECT_EQ(rig->model().mode, Mode::kPedalUp);
  EXPECT_EQ(report().end, ExecutionEnd::kNoPedal);
  rest(true, 1);
  EXPECT_EQ(rig->model().mode, Mode::kTeleoperating);
}

TEST_F(Execution, IsRefusedOnceAnArmHasMoved) {
  for (const Arm arm : kArms) {
    SetUp();
    plan();
    MasterCommand command;
    command.pedal = 1;
    at(command.dp_I, arm) = {20e-6, 0.0, 0.0};
    for (int i = 0; i < 600; ++i)
      rig->tick(command);
    rest(false, 100);
    EXPECT_EQ(ask(RequestKind::kExecutePlan, 1), PlanningAnswer::kMoved) << name(arm);
    EXPECT_EQ(ask(RequestKind::kExecutePlan, 0), PlanningAnswer::kMoved) << name(arm);
    EXPECT_EQ(rig->model().mode, Mode::kPedalUp);
  }
}

TEST_F(Execution, IsRefusedAtThePedalIfTheOtherArmCameNearerThanThePathKeepsAway) {
  const auto pressWith = [this](double shift) {
    SetUp();
    arm(true);
    RobotState elsewhere = rig->robot();
    elsewhere.arms[1].q[kInsertion] += shift;  // along the shaft: the tip moves by the same length
    tickWith(&elsewhere, true);
    return report().end;
  };
  // Both shifts are within start_tolerance, 1 mm; the path keeps 0.4 mm.
  clearance = 0.0004;
  EXPECT_EQ(pressWith(0.0003), ExecutionEnd::kNone);
  EXPECT_EQ(pressWith(0.0006), ExecutionEnd::kMoved);
}

TEST_F(Execution, IsRefusedAtThePedalIfAnArmMovedSinceItWasArmed) {
  arm(true);
  RobotState elsewhere = rig->robot();
  elsewhere.arms[1].q[kElbow] += 0.05;
  tickWith(&elsewhere, true);
  EXPECT_EQ(report().end, ExecutionEnd::kMoved);
  EXPECT_EQ(report().started, -1);
  EXPECT_EQ(rig->model().mode, Mode::kPedalUp);
  EXPECT_EQ(rig->last_relay.command.pedal, 0);
}

TEST_F(Execution, IsRefusedAtThePedalIfSomethingIsBetweenTheArmAndThePath) {
  planning::ClearanceGauge gauge(rig->raven, rig->scene);
  const JointArray green = rig->robot().arms[1].q;
  JointArray stands = rig->robot().arms[0].q;
  const std::size_t joint = kShoulder;
  for (int i = 0; i < 6000 && gauge.measure(Arm::kGold, stands, green) > 0.0; ++i)
    stands[joint] += 1e-4;
  ASSERT_EQ(gauge.measure(Arm::kGold, stands, green), 0.0) << "the arm touches something";
  const double tolerance = rig->config.execution.start_tolerance[joint];
  stands[joint] -= 0.4 * tolerance;
  ASSERT_GT(gauge.measure(Arm::kGold, stands, green), 0.0);
  // Both moves are within the tolerance: one away from the obstacle, one into it.
  for (const double away : {-0.8 * tolerance, 0.8 * tolerance}) {
    SetUp();
    RobotState state = rig->robot();
    state.arms[0].q = stands;
    for (int i = 0; i < 10; ++i)
      tickWith(&state, false);
    ASSERT_EQ(ask(RequestKind::kPlan), PlanningAnswer::kAccepted);
    ASSERT_TRUE(rig->shared->plan_requests.tryPop(&asked));
    ASSERT_NEAR(asked.start[joint], stands[joint], 1e-5);
    JointArray back{};
    back[joint] = -0.02;
    ASSERT_TRUE(rig->shared->plan_results.tryPush(answerTo(asked, back)));
    tickWith(&state, false);
    ASSERT_EQ(ask(RequestKind::kExecutePlan, 1), PlanningAnswer::kAccepted);
    state.arms[0].q[joint] += away;
    tickWith(&state, true);
    EXPECT_EQ(report().end, away > 0.0 ? ExecutionEnd::kMoved : ExecutionEnd::kNone) << away;
  }
}

TEST_F(Execution, IsRefusedWithItsReason) {
  EXPECT_EQ(ask(RequestKind::kExecutePlan), PlanningAnswer::kNoPlan);
  plan();
  EXPECT_EQ(ask(RequestKind::kExecutePlan, 1, planned.id + 1), PlanningAnswer::kNoPlan)
      << "the request names another plan";
  Request disengage;
  disengage.kind = RequestKind::kDisengage;
  ASSERT_TRUE(rig->shared->requests.tryPush(disengage));
  EXPECT_EQ(ask(RequestKind::kExecutePlan, 1, planned.id), PlanningAnswer::kNoRobot);
  EXPECT_EQ(ask(RequestKind::kExecutePlan, 0, planned.id), PlanningAnswer::kAccepted) << "the model needs no robot";
  EXPECT_EQ(ask(RequestKind::kExecutePlan, 0, planned.id), PlanningAnswer::kNotNow) << "the plan is armed already";
  rest(true, 50);
  EXPECT_EQ(rig->model().mode, Mode::kExecuting);
}

TEST_F(Execution, APathThatTheRobotCannotFollowIsForTheModelAlone) {
  ASSERT_EQ(ask(RequestKind::kPlan), PlanningAnswer::kAccepted);
  ASSERT_TRUE(rig->shared->plan_requests.tryPop(&asked));
  planned = answerTo(asked, kClear);
  planned.robot_follows = 0;
  ASSERT_TRUE(rig->shared->plan_results.tryPush(planned));
  rest(false, 1);
  EXPECT_EQ(ask(RequestKind::kExecutePlan, 1), PlanningAnswer::kRobotCannotFollow);
  EXPECT_EQ(ask(RequestKind::kExecutePlan, 0), PlanningAnswer::kAccepted);
}

TEST_F(Execution, WithThePedalDownNothingIsArmed) {
  plan();
  rest(true, 20);
  Request request;
  request.kind = RequestKind::kExecutePlan;
  request.id = 90;
  ASSERT_TRUE(rig->shared->requests.tryPush(request));
  rest(true, 2);
  EXPECT_EQ(planning().answer, PlanningAnswer::kNotNow);
  EXPECT_EQ(planning().answered, 90U);
  EXPECT_EQ(rig->model().mode, Mode::kTeleoperating);
}

TEST_F(Execution, ARobotHeldBackEndsItOffThePath) {
  arm(true);
  rest(true, 100);
  // GIVEN a robot that we still hear but that our packets no longer reach
  RobotState state = rig->robot();
  for (int i = 0; i < 3000 && rig->model().mode == Mode::kExecuting; ++i)
    tickWith(&state, true);
  EXPECT_EQ(report().end, ExecutionEnd::kOffPath);
  EXPECT_NEAR(report().robot.largest, rig->config.execution.deviation_limit, 1e-3);
  EXPECT_EQ(rig->last_relay.command.pedal, 0);
}

/** The path is over, and both arms hold at the goal until they rest. The error there counts as on the path. */
TEST_F(Execution, ARobotPushedAwayBehindThePathsEndEndsItOffThePath) {
  arm(/*on_robot=*/true);
  for (int i = 0; i < 10000 && planning().progress < 1.0; ++i)
    rig->tick(true);
  const double limit = rig->config.execution.deviation_limit;
  RobotState pushed = rig->robot();
  for (const double off : {0.95 * limit, 1.05 * limit}) {
    ASSERT_EQ(rig->model().mode, Mode::kExecuting) << off;
    pushed.arms[0].q = goal();
    pushed.arms[0].q[kInsertion] += off;
    pushed.arms[0].dq = {};
    for (int i = 0; i < 10 && rig->model().mode == Mode::kExecuting; ++i)
      tickWith(&pushed, true);
  }
  EXPECT_EQ(report().end, ExecutionEnd::kOffPath);
  EXPECT_EQ(report().progress, 1.0);
  EXPECT_NEAR(report().robot.largest, 1.05 * limit, 1e-6);
  EXPECT_NEAR(report().robot.at_end, 1.05 * limit, 1e-6);
  EXPECT_LT(report().model.largest, 0.8 * limit) << "the model stays on the path";
}

TEST_F(Execution, TheRobotsClearanceIsThatOfTheRobot) {
  arm(/*on_robot=*/true);
  for (int i = 0; i < 100; ++i)
    rig->tick(true);
  planning::ClearanceGauge gauge(rig->raven, rig->scene);
  RobotState pushed = rig->robot();
  JointArray& q = pushed.arms[0].q;
  const JointArray start = q;
  const double before = gauge.measure(Arm::kGold, q, pushed.arms[1].q);
  double near = before;
  for (int i = 0; i < 120 && near > before - 0.003; ++i) {  // each joint to either side: one way leads to the scene
    if (i % 30 == 0) q = start;
    q[i < 60 ? kShoulder : kElbow] += i / 30 % 2 == 0 ? 0.01 : -0.01;
    near = gauge.measure(Arm::kGold, q, pushed.arms[1].q);
  }
  ASSERT_LT(near, before - 0.003);
  tickWith(&pushed, true);
  EXPECT_EQ(report().end, ExecutionEnd::kOffPath) << "so far from the model";
  EXPECT_NEAR(report().robot_clearance, near, 1e-6);
  EXPECT_GT(report().model_clearance, near + 2e-3);
}

// ---- choosing ----------------------------------------------------------------------------------------------------

TEST_F(Execution, TheGoalIsChosenOnTheModelAloneThroughEverything) {
  const Vec3 robot_before = robotTip();
  const ModelState before = rig->model();
  ASSERT_EQ(ask(RequestKind::kBeginPlanning), PlanningAnswer::kAccepted);
  ASSERT_EQ(rig->model().mode, Mode::kChoosing);
  ASSERT_EQ(planning().status, PlanningStatus::kChoosing);
  std::uint32_t contacts = 0;
  for (int i = 0; i < 2000; ++i) {
    rig->tick(true, {0.0, 0.0, 50e-6});  // 100 mm down: through the floor
    contacts += rig->model().arms[0].contacts;
    ASSERT_EQ(rig->last_relay.command.pedal, 0);
  }
  EXPECT_EQ(contacts, 0U);
  EXPECT_GT(apart(modelTip(), before.arms[0].p_BT), 0.05);
  EXPECT_LT(apart(robotTip(), robot_before), 1e-6);
  for (std::size_t body = 0; body < kMaxSceneBodies; ++body)
    EXPECT_EQ(rig->model().bodies[body].p, before.bodies[body].p) << "the arm pushes no object";
  EXPECT_EQ(rig->model().arms[1].q, before.arms[1].q) << "the other arm does not move";
  ASSERT_EQ(ask(RequestKind::kEndPlanning), PlanningAnswer::kAccepted);
  EXPECT_EQ(rig->model().mode, Mode::kPedalUp);
  EXPECT_LT(apart(modelTip(), before.arms[0].p_BT), 0.05e-3) << "the arm is back at its start";
}

TEST_F(Execution, OnlyThePedalMovesTheGoal) {
  ask(RequestKind::kBeginPlanning);
  const Vec3 before = modelTip();
  rest(false, 100, {20e-6, 0.0, 0.0});
  EXPECT_LT(apart(modelTip(), before), 2e-6);
  rest(true, 100, {20e-6, 0.0, 0.0});
  EXPECT_NEAR(apart(modelTip(), before), 2e-3, 1e-5)
      << "the tip moves exactly as commanded, without a controller's lag";
}

TEST_F(Execution, TheRecordedGoalIsWhatThePlannerIsAskedFor) {
  const JointArray stood = rig->model().arms[0].q;
  ask(RequestKind::kBeginPlanning);
  rest(true, 300, {-30e-6, 40e-6, 0.0});
  rest(false, 5);
  const JointArray chosen = rig->model().arms[0].q;
  ASSERT_EQ(ask(RequestKind::kRecordGoal), PlanningAnswer::kAccepted);
  EXPECT_EQ(rig->model().mode, Mode::kPlanning);
  PlanRequest request;
  ASSERT_TRUE(rig->shared->plan_requests.tryPop(&request));
  EXPECT_EQ(request.id, last_id);
  EXPECT_EQ(request.goal, GoalKind::kJoints);
  EXPECT_EQ(request.arm, Arm::kGold);
  for (std::size_t j = 0; j < kGrasp1; ++j) {
    EXPECT_NEAR(request.goal_q[j], chosen[j], 1e-9) << kJointNames[j];
    EXPECT_NEAR(request.start[j], stood[j], 1e-4) << kJointNames[j];
  }
  EXPECT_LT(apart(modelTip(), tipAt(stood)), 0.05e-3) << "the arm is back at its start";
}

TEST_F(Execution, ChoosingEndsWithAnEStopAndWithALostRobot) {
  ask(RequestKind::kBeginPlanning);
  robotSays(RunLevel::kEStop, 2, false);
  EXPECT_EQ(rig->model().mode, Mode::kStopped);
  EXPECT_EQ(planning().status, PlanningStatus::kIdle);
  SetUp();
  const Vec3 before = modelTip();
  ask(RequestKind::kBeginPlanning);
  rest(true, 100, {30e-6, 0.0, 0.0});
  rig->robot_connected = false;
  rig->link.disconnected();
  rest(true, 2);
  EXPECT_EQ(rig->model().mode, Mode::kPedalUp);
  EXPECT_EQ(planning().status, PlanningStatus::kIdle);
  EXPECT_LT(apart(modelTip(), before), 0.1e-3);
}

TEST_F(Execution, WhatIsNotUnderWayCannotBeEndedOrRecorded) {
  EXPECT_EQ(ask(RequestKind::kRecordGoal), PlanningAnswer::kNotNow);
  EXPECT_EQ(ask(RequestKind::kEndPlanning), PlanningAnswer::kNotNow);
  EXPECT_EQ(ask(RequestKind::kBeginPlanning), PlanningAnswer::kAccepted);
  EXPECT_EQ(ask(RequestKind::kBeginPlanning), PlanningAnswer::kNotNow) << "a goal is being chosen already";
  EXPECT_EQ(ask(RequestKind::kExecutePlan), PlanningAnswer::kNotNow);
  EXPECT_EQ(rig->model().mode, Mode::kChoosing);
}

// ---- the planner -------------------------------------------------------------------------------------------------

TEST_F(Execution, ThePlannersOwnPathIsExecutedFromTheRecordedGoalOn) {
  PlannerWorker planner(rig->config, rig->raven, rig->scene, rig->shared.get());
  ask(RequestKind::kBeginPlanning);
  rest(true, 500, {-20e-6, 40e-6, 0.0});
  rest(false, 5);
  ASSERT_EQ(ask(RequestKind::kRecordGoal), PlanningAnswer::kAccepted);
  const std::uint32_t id = last_id;
  ASSERT_TRUE(planner.serve());
  rest(false, 1);
  planned = rig->shared->last_plan.load();
  ASSERT_EQ(planned.status, PlanStatus::kSuccess);
  ASSERT_EQ(planned.id, id);
  ASSERT_EQ(planned.robot_follows, 1);
  EXPECT_EQ(rig->model().guide_plan, id);
  ASSERT_EQ(ask(RequestKind::kExecutePlan, 1, id), PlanningAnswer::kAccepted);
  EXPECT_EQ(rig->model().guide_plan, id);
  rest(true, 1);
  EXPECT_EQ(rig->model().guide_plan, 0U) << "no guidance while the arm follows the path";
  hold(60000);
  EXPECT_EQ(report().end, ExecutionEnd::kFinished);
  EXPECT_LT(apart(robotTip(), tipAt(goal())), rig->config.execution.settle_tolerance);
  EXPECT_LT(apart(modelTip(), tipAt(goal())), rig->config.execution.settle_tolerance);
}

TEST_F(Execution, APlanThatNobodyWaitsForIsGivenUpAndTheNextIsNot) {
  PlannerWorker planner(rig->config, rig->raven, rig->scene, rig->shared.get());
  PlanRequest first, second;
  ask(RequestKind::kPlan);
  ASSERT_TRUE(rig->shared->plan_requests.tryPop(&first));
  ask(RequestKind::kCancelPlan);
  EXPECT_EQ(rig->model().mode, Mode::kPedalUp);
  ASSERT_EQ(ask(RequestKind::kPlan), PlanningAnswer::kAccepted);
  ASSERT_TRUE(rig->shared->plan_requests.tryPop(&second));
  const PlanResult given_up = planner.planNow(first), answer = planner.planNow(second);
  EXPECT_EQ(given_up.status, PlanStatus::kCancelled) << "the planner itself cancelled it";
  EXPECT_NE(answer.status, PlanStatus::kCancelled);
  ASSERT_TRUE(rig->shared->plan_results.tryPush(given_up));
  ASSERT_TRUE(rig->shared->plan_results.tryPush(answer));
  rest(false, 1);
  EXPECT_EQ(rig->shared->last_plan.load().id, last_id);
  EXPECT_EQ(rig->shared->last_plan.load().status, answer.status);
}

TEST_F(Execution, ThePedalGivesUpThePlanUnderWay) {
  ask(RequestKind::kPlan);
  PlanRequest request;
  ASSERT_TRUE(rig->shared->plan_requests.tryPop(&request));
  EXPECT_FALSE(planCancelled(rig->shared.get(), request.serial).load());
  rest(true, 1);
  EXPECT_TRUE(planCancelled(rig->shared.get(), request.serial).load());
  EXPECT_EQ(planning().status, PlanningStatus::kIdle);
}

TEST_F(Execution, AnEndedPlannerBeginsNoPlan) {
  PlannerWorker planner(rig->config, rig->raven, rig->scene, rig->shared.get());
  planner.cancel();
  ask(RequestKind::kPlan);
  ASSERT_TRUE(planner.serve());
  rest(false, 1);
  EXPECT_EQ(rig->shared->last_plan.load().status, PlanStatus::kCancelled);
}

// ---- without a robot ---------------------------------------------------------------------------------------------

TEST(ExecutionAlone, WithoutARobotTheModelExecutesAndGoesBackForTheNext) {
  raven2_trainer::testing::useOde();
  TrainerConfig config = packagedConfig();
  config.hazard = "none";
  config.runtime.plan_at = -1.0;
  Rig rig(config);
  rig.robot_connected = false;
  rig.link.disconnected();
  for (int i = 0; i < 50; ++i)
    rig.tick(false);
  const auto ask = [&rig](RequestKind kind, std::uint32_t id, std::uint8_t on_robot) {
    Request request;
    request.kind = kind;
    request.id = id;
    request.on_robot = on_robot;
    EXPECT_TRUE(rig.shared->requests.tryPush(request));
    rig.tick(false);
    return rig.model().planning.answer;
  };
  ASSERT_EQ(ask(RequestKind::kPlan, 1, 0), PlanningAnswer::kAccepted);
  PlanRequest request;
  ASSERT_TRUE(rig.shared->plan_requests.tryPop(&request));
  PlanResult plan;
  plan.id = 1;
  plan.status = PlanStatus::kSuccess;
  plan.waypoint_count = 2;
  plan.waypoints[0] = plan.waypoints[1] = request.start;
  plan.waypoints[1][kShoulder] += 0.1;
  plan.arrival[1] = 1.0;
  plan.clearance = 0.002;
  ASSERT_TRUE(rig.shared->plan_results.tryPush(plan));
  for (int i = 0; i < 1200; ++i)  // until the path was shown to its end
    rig.tick(false);
  EXPECT_EQ(ask(RequestKind::kExecutePlan, 2, 1), PlanningAnswer::kNoRobot);
  for (std::uint32_t id = 3; id < 5; ++id) {
    ASSERT_EQ(ask(RequestKind::kExecutePlan, id, 0), PlanningAnswer::kAccepted);
    EXPECT_NEAR(rig.model().arms[0].q[kShoulder], request.start[kShoulder], 2e-3) << "back at the start";
    for (int i = 0; i < 4000 && rig.model().mode != Mode::kTracking; ++i)
      rig.tick(true);
    EXPECT_EQ(rig.shared->last_execution.load().end, ExecutionEnd::kFinished);
    EXPECT_EQ(rig.shared->last_execution.load().id, id);
    EXPECT_NEAR(rig.model().arms[0].q[kShoulder], plan.waypoints[1][kShoulder], 0.01);
    rig.tick(false);
  }
}

}  // namespace
}  // namespace raven2_trainer::loop
