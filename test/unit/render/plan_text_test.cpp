#include "render/plan_text.h"

#include <gtest/gtest.h>

#include <limits>

#include "plan_fixture.h"
#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"

namespace raven2_trainer::render {
namespace {

const ArmGeometry& packagedGeometry() {
  static const TrainerConfig kConfig = config::loadTrainerConfig(RAVEN2_TRAINER_SOURCE_DIR "/config/trainer.yaml");
  return kConfig.arms.geometry;
}

Snapshot inState(PlanningStatus status) {
  Snapshot snapshot;
  setPlan(makePlan(packagedGeometry(), Arm::kGreen), status, &snapshot);
  return snapshot;
}

void report(const ExecutionReport& execution, Snapshot* snapshot) {
  snapshot->plans.add(std::make_shared<const ExecutionReport>(execution));
}

void answer(std::uint32_t id, PlanStatus status, Snapshot* snapshot) {
  PlanResult result;
  result.id = id;
  result.status = status;
  snapshot->plans.add(std::make_shared<const PlanResult>(result));
}

std::string text(const Snapshot& snapshot, double error = 0.0) {
  return planLine(snapshot, error);
}

TEST(PlanText, SaysNothingWhereNobodyAskedForAPlan) {
  EXPECT_EQ(text(Snapshot{}), "");
}

TEST(PlanText, SaysWhatGoesOn) {
  EXPECT_EQ(text(inState(PlanningStatus::kChoosing)), "plan      choosing the goal, green arm");
  EXPECT_EQ(text(inState(PlanningStatus::kPlanning)), "plan      planning");
  EXPECT_EQ(text(inState(PlanningStatus::kReady)), "plan      ready");
}

TEST(PlanText, SaysWhatThePedalWouldDo) {
  Snapshot armed = inState(PlanningStatus::kArmed);
  EXPECT_EQ(text(armed), "plan      ready: hold the pedal, model alone");
  armed.model.planning.on_robot = 1;
  EXPECT_EQ(text(armed), "plan      ready: hold the pedal, robot moves");
}

TEST(PlanText, SaysHowFarTheExecutionIsAndHowFarOffThePath) {
  Snapshot executing = inState(PlanningStatus::kExecuting);
  executing.model.planning.progress = 0.617;
  EXPECT_EQ(text(executing, 0.00043), "plan      executing 62 %  err 0.4 mm");
  executing.model.planning.progress = 1.0;
  EXPECT_EQ(text(executing, 0.0), "plan      executing 100 %  err 0.0 mm");
}

TEST(PlanText, SaysHowTheExecutionEnded) {
  Snapshot kept = inState(PlanningStatus::kReady);
  report(makeReport(ExecutionEnd::kReleased, 0.62), &kept);
  EXPECT_EQ(text(kept), "plan      stopped: released at 62 %");
  report(makeReport(ExecutionEnd::kFinished, 1.0), &kept);
  EXPECT_EQ(text(kept), "plan      finished, 0.4 mm from the goal") << "the model's distance";
  Snapshot gone = inState(PlanningStatus::kIdle);
  ExecutionReport on_robot = makeReport(ExecutionEnd::kFinished, 1.0);
  on_robot.on_robot = 1;
  report(on_robot, &gone);
  EXPECT_EQ(text(gone), "plan      finished, 1.1 mm from the goal") << "the robot's distance";
  report(makeReport(ExecutionEnd::kRobotLost, 0.5), &gone);
  EXPECT_EQ(text(gone), "plan      stopped: robot lost at 50 %");
  ExecutionReport never = makeReport(ExecutionEnd::kNoPedal, 0.0);
  never.started = -1;
  report(never, &gone);
  EXPECT_EQ(text(gone), "plan      stopped: no pedal");
}

TEST(PlanText, ANewPlanMakesAnOldReportNoNews) {
  Snapshot kept = inState(PlanningStatus::kReady);
  report(makeReport(ExecutionEnd::kReleased, 0.62), &kept);
  PlanResult newer = makePlan(packagedGeometry(), Arm::kGreen);
  newer.id = kPlan + 1;
  setPlan(newer, PlanningStatus::kReady, &kept);
  EXPECT_EQ(text(kept), "plan      ready");
  kept.model.planning.status = PlanningStatus::kIdle;
  EXPECT_EQ(text(kept), "");
}

TEST(PlanText, SaysWhyThereIsNoPlan) {
  Snapshot snapshot;
  answer(7, PlanStatus::kGoalInCollision, &snapshot);
  EXPECT_EQ(text(snapshot), "plan      none: goal in collision");
  answer(8, PlanStatus::kCancelled, &snapshot);
  EXPECT_EQ(text(snapshot), "plan      cancelled");
}

TEST(PlanText, SaysWhyARequestWasRefused) {
  Snapshot snapshot = inState(PlanningStatus::kReady);
  snapshot.model.planning.answer = PlanningAnswer::kRobotCannotFollow;
  EXPECT_EQ(text(snapshot), "plan      ready; refused: robot cannot follow");
  snapshot.model.planning.answer = PlanningAnswer::kAccepted;
  EXPECT_EQ(text(snapshot), "plan      ready");
  Snapshot idle;
  idle.model.planning.answer = PlanningAnswer::kNoPlan;
  EXPECT_EQ(text(idle), "plan      refused: no plan");
}

TEST(PlanText, ARefusedRequestLeavesThePlanReady) {
  Snapshot kept = inState(PlanningStatus::kReady);
  answer(kPlan + 1, PlanStatus::kCancelled, &kept);
  EXPECT_EQ(text(kept), "plan      ready");
}

TEST(PlanText, ValuesThatNoLogShouldHoldDoNoHarm) {
  Snapshot snapshot = inState(PlanningStatus::kChoosing);
  snapshot.model.planning.arm = static_cast<Arm>(9);
  EXPECT_EQ(text(snapshot), "plan      choosing the goal, ? arm");
  snapshot.model.planning.status = PlanningStatus::kExecuting;
  snapshot.model.planning.progress = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(pathError(packagedGeometry(), snapshot), 0.0);
  EXPECT_EQ(text(snapshot, std::numeric_limits<double>::quiet_NaN()), "plan      executing - %  err - mm");
  snapshot.model.planning.progress = 1e300;
  EXPECT_EQ(text(snapshot, 1e300), "plan      executing 100 %  err 9900.0 mm");
  snapshot.model.planning.status = static_cast<PlanningStatus>(99);
  EXPECT_EQ(text(snapshot), "plan      ?");
  Snapshot ready = inState(PlanningStatus::kReady);
  report(makeReport(static_cast<ExecutionEnd>(99), 0.5), &ready);
  EXPECT_EQ(text(ready), "plan      stopped: ? at 50 %");
}

TEST(PathError, IsTheFartherTipsDistanceFromWhereTheDesiredJointsPutIt) {
  Snapshot executing = inState(PlanningStatus::kExecuting);
  ArmState& model = at(executing.model.arms, Arm::kGreen);
  model.q_d = packagedGeometry().home;
  const Vector3 path_B = kinematics::forward(packagedGeometry(), Arm::kGreen, packagedGeometry().home).p;
  model.p_BT = toArray(path_B + Vector3(0.0003, 0.0, -0.0004));                                 // 0.5 mm
  at(executing.robot.arms, Arm::kGreen).p_BT = toArray(path_B + Vector3(0.0, 0.0005, 0.0012));  // 1.3 mm
  EXPECT_NEAR(pathError(packagedGeometry(), executing), 0.0005, 1e-12);
  executing.model.planning.on_robot = 1;
  EXPECT_NEAR(pathError(packagedGeometry(), executing), 0.0013, 1e-12);
  executing.model.planning.status = PlanningStatus::kReady;
  EXPECT_EQ(pathError(packagedGeometry(), executing), 0.0);
}

TEST(PathError, IsThatOfThePlansArm) {
  const ArmGeometry& geometry = packagedGeometry();
  for (const Arm arm : kArms) {
    Snapshot executing;
    setPlan(makePlan(geometry, arm), PlanningStatus::kExecuting, &executing);
    for (const Arm each : kArms) {
      at(executing.model.arms, each).q_d = geometry.home;
      at(executing.model.arms, each).p_BT = at(executing.robot.arms, each).p_BT = {9.0, 9.0, 9.0};
    }
    const Vector3 path_B = kinematics::forward(geometry, arm, geometry.home).p;
    at(executing.model.arms, arm).p_BT = toArray(path_B + Vector3(0.0003, 0.0, -0.0004));  // 0.5 mm
    at(executing.robot.arms, arm).p_BT = toArray(path_B + Vector3(0.0, 0.0005, 0.0012));   // 1.3 mm
    EXPECT_NEAR(pathError(geometry, executing), 0.0005, 1e-12) << name(arm);
    executing.model.planning.on_robot = 1;
    EXPECT_NEAR(pathError(geometry, executing), 0.0013, 1e-12) << name(arm);
  }
}

}  // namespace
}  // namespace raven2_trainer::render
