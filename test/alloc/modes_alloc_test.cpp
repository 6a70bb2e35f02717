#include <gtest/gtest.h>

#include "support/allocation_counter.h"
#include "support/mode_driver.h"
#include "support/servo_client.h"

#ifdef RAVEN2_COUNTS_ALLOCATIONS

namespace raven2_trainer::lockstep {
namespace {

using raven2_trainer::testing::allocatorCalls;
using raven2_trainer::testing::ModeDriver;
using raven2_trainer::testing::mutexLocks;
using raven2_trainer::testing::ServoClient;

/** Simulation and back, the camera, a stop, a trial repeated on model and robot, a discarded trial, and two replays,
 *  one of them to its end. @return ticks of repeating with the robot. */
int allModes(ModeDriver* d) {
  d->ask(RequestKind::kBeginSimulation);
  d->stroke(300, 1.0);
  d->rest(false, 20);
  d->ask(RequestKind::kEndSimulation);
  d->waitFor(Mode::kPedalUp);
  d->ask(RequestKind::kSetCameraPedal, true, 0, 1);
  d->stroke(100, 1.0);
  d->ask(RequestKind::kSetCameraPedal, false, 0, 0);
  d->rest(false, 20);
  d->ask(RequestKind::kEmergencyStop);
  d->ask(RequestKind::kClearStop);
  d->rest(false, 50);
  d->ask(RequestKind::kBeginTrial);
  d->stroke(300, 1.0, 0.004);
  d->rest(false, 20);
  d->stroke(300, -1.0);
  d->rest(false, 20);
  d->ask(RequestKind::kEndTrial);
  int repeated = 0;
  for (const std::uint8_t on_robot : {0, 1}) {
    d->ask(RequestKind::kRepeatTrial, false, on_robot);
    d->waitFor(Mode::kArmed);
    d->rest(false, 20);
    for (int i = 0; i < 1500; ++i) {
      d->rest(true, 1);
      repeated += d->mode() == Mode::kExecuting && d->rig.model().linked != 0 ? 1 : 0;
    }
    d->rest(false, 50);
  }
  d->ask(RequestKind::kBeginTrial);
  d->stroke(100, -1.0);
  d->rest(false, 20);
  d->ask(RequestKind::kDiscardTrial);
  d->waitFor(Mode::kPedalUp);
  d->beginReplay(1000, /*ends=*/false);
  d->rest(false, 100);
  d->ask(RequestKind::kEndReplay);
  d->rest(false, 1);
  d->beginReplay(20, /*ends=*/true);
  d->rest(false, 50);
  return repeated;
}

/** A CRTK client: every kind of command, valid and refused, the console in between, and a stop. */
void allCommands(ModeDriver* d, ServoClient* client) {
  client->send(StateCommand::kUnhome);
  client->enable();
  for (const Arm arm : kArms) {
    for (std::size_t kind = 0; kind < kServoKindCount; ++kind) {
      ServoCommand command;
      command.kind = static_cast<ServoKind>(kind);
      if (command.kind == ServoKind::kFree) continue;
      command.arm = arm;
      const ServoArmState now = client->arm(arm);
      const bool is_relative = command.kind == ServoKind::kServoJointsBy || command.kind == ServoKind::kServoPoseBy;
      command.joints = is_relative ? ServoJoints{} : now.setpoint_q;
      command.joints[kElbow] += 0.01;
      command.pose_B = is_relative ? RigidPose{} : now.setpoint_B;
      command.pose_B.p[0] += 0.003;
      command.v_B = {0.0, 0.02, 0.0};
      command.jaw = command.kind == ServoKind::kServoJawBy ? -0.1 : 1.0;
      client->send(command);
      client->rest(150);
      command.joints[kWrist] = command.jaw = command.v_B[0] = 100.0;
      command.pose_B.p[0] += 1.0;
      client->send(command);
      client->rest(5);
    }
  }
  client->rest(20, /*console_pedal=*/true);
  client->rest(20);
  d->ask(RequestKind::kEmergencyStop);
  client->rest(2);
  client->send(StateCommand::kEnable);
  client->rest(1);
  d->ask(RequestKind::kClearStop);
  client->rest(2);
  client->enable();
  client->send(StateCommand::kDisable);
  client->rest(50);
}

TEST(ModesAlloc, ServingClientsDoesNotTouchTheHeap) {
  raven2_trainer::testing::useOde();
  ModeDriver driver;
  ServoClient client(&driver.rig);
  ASSERT_TRUE(driver.begin());
  allCommands(&driver, &client);  // warm up
  EXPECT_EQ(allocatorCalls([&] { allCommands(&driver, &client); }), 0);
  EXPECT_EQ(mutexLocks(), 0);
  EXPECT_GT(client.refusals, 40U);
  EXPECT_GT(client.state().applied, 40U);
}

TEST(ModesAlloc, SimulatingTryingRepeatingAndReturningDoNotTouchTheHeap) {
  raven2_trainer::testing::useOde();
  ModeDriver driver;
  ASSERT_TRUE(driver.begin());
  allModes(&driver);  // warm up
  int repeated = 0;
  EXPECT_EQ(allocatorCalls([&] { repeated = allModes(&driver); }), 0);
  EXPECT_EQ(mutexLocks(), 0);
  EXPECT_GT(repeated, 500) << "the trial never reached the robot";
  EXPECT_EQ(driver.report().end, ExecutionEnd::kFinished);
  EXPECT_EQ(driver.mode(), Mode::kPedalUp);
}

}  // namespace
}  // namespace raven2_trainer::lockstep

#endif
