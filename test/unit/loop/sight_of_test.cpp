#include "raven2_trainer/loop/sight_of.h"

#include <gtest/gtest.h>

#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"
#include "raven2_trainer/model/raven_model.h"

namespace raven2_trainer::loop {
namespace {

TEST(SightOf, ShowsTheToolsWhereTheUrdfPutsThem) {
  const TrainerConfig config = config::loadTrainerConfig(RAVEN2_TRAINER_SOURCE_DIR "/config/trainer.yaml");
  const model::RavenModel raven = model::loadRavenModel(config);
  ModelState state;
  for (const Arm arm : kArms) {
    ArmState& a = at(state.arms, arm);
    a.q = config.arms.geometry.home;
    a.q[kShoulder] += arm == Arm::kGold ? 0.1 : -0.2;
    kinematics::setJaws(0.3, 0.7, &a.q);
    const Pose X_BT = kinematics::forward(config.arms.geometry, arm, a.q);
    a.p_BT = toArray(X_BT.p);
    a.q_BT = toArray(Quaternion(X_BT.R));
  }
  const Sight sight = sightOf(state, RobotState{}, config.arms, 1, 7);
  std::vector<double> positions(raven.description.links.size());
  std::vector<Pose> links(raven.description.links.size());
  raven.linkPosesInWorld({state.arms[0].q, state.arms[1].q}, &positions, &links);
  for (const Arm arm : kArms) {
    // The jaws' links rotate about the tool's frame.
    const Pose& jaw = links[static_cast<std::size_t>(at(raven.links, arm)[kGrasp1])];
    EXPECT_NEAR((toEigen(at(sight.tool_W, arm).p) - jaw.p).norm(), 0.0, 1e-9) << name(arm);
    EXPECT_NEAR(at(sight.opening, arm), 0.7, 1e-12);
  }
  EXPECT_EQ(sight.sequence, 7u);
  EXPECT_EQ(sight.runlevel, RunLevel::kEStop) << "there is no robot";
}

TEST(SightOf, TellsWhichPartsAreBrokenOff) {
  ModelState state;
  state.exercise.bodies[1] = kBodyParked;
  state.exercise.bodies[2] = kBodyBrokenOff;
  state.exercise.bodies[5] = kBodyBrokenOff | kHeldByGold;
  state.exercise.step = 3;
  state.exercise.status = ExerciseStatus::kRunning;
  RobotState robot;
  robot.frame = 1;
  robot.runlevel = RunLevel::kPedalDown;
  const Sight sight = sightOf(state, robot, ArmsConfig{}, 2, 1);
  EXPECT_EQ(sight.broken, 1u | 8u);
  EXPECT_EQ(sight.step, 3u);
  EXPECT_EQ(sight.exercise, ExerciseStatus::kRunning);
  EXPECT_EQ(sight.runlevel, RunLevel::kPedalDown);
}

/** doc/scores.md: 3 mm, of a robot that is there, and none that the model opens on purpose. */
TEST(SightOf, ShowsAGhostWhereTheRobotsTipIsOffTheModels) {
  for (const Arm arm : kArms) {
    const auto ghosts = [arm](double gap, std::uint64_t frame, std::uint8_t connected, Mode mode, std::uint8_t linked) {
      ModelState state;
      state.mode = mode;
      state.linked = linked;
      RobotState robot;
      robot.frame = frame;
      robot.connected = connected;
      at(state.arms, arm).p_BT = {0.1, 0.2, 0.3};
      at(robot.arms, arm).p_BT = {0.1, 0.2 - gap, 0.3};
      at(state.arms, otherArm(arm)).p_BT = at(robot.arms, otherArm(arm)).p_BT = {0.4, 0.5, 0.6};
      return static_cast<int>(sightOf(state, robot, ArmsConfig{}, 2, 1).ghost);
    };
    const int mine = arm == Arm::kGold ? 1 : 2;
    EXPECT_EQ(ghosts(0.00301, 1, 1, Mode::kTeleoperating, 1), mine);
    EXPECT_EQ(ghosts(-0.00301, 1, 1, Mode::kStopped, 0), mine);
    EXPECT_EQ(ghosts(0.00299, 1, 1, Mode::kTeleoperating, 1), 0);
    EXPECT_EQ(ghosts(0.00301, 0, 1, Mode::kTeleoperating, 1), 0) << "there was no robot yet";
    EXPECT_EQ(ghosts(0.00301, 1, 0, Mode::kTeleoperating, 1), 0) << "it is gone";
    EXPECT_EQ(ghosts(0.00301, 1, 1, Mode::kTrial, 0), 0) << "the model moves alone";
  }
}

}  // namespace
}  // namespace raven2_trainer::loop
