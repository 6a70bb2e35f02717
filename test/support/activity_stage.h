#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "loop/activity/activity.h"
#include "support/rig.h"

namespace raven2_trainer::testing {

/** Records the events that an activity raises. With `state`, they also change its mode by the mode table; the test
 * calls enter() and leave(). */
class RecordedModes final : public loop::ModeMachine {
 public:
  void raise(control::Event event) noexcept override {
    events.push_back(event);
    if (state != nullptr) state->mode = control::nextMode(state->mode, event);
  }
  PlanningAnswer ask(control::Event event) noexcept override {
    const Mode before = state != nullptr ? state->mode : Mode::kWaiting;
    raise(event);
    return state == nullptr || state->mode != before ? PlanningAnswer::kAccepted : PlanningAnswer::kNotNow;
  }

  std::vector<control::Event> events;
  ModelState* state{nullptr};
};

/** A stage for one activity, without the physics loop: the test sets the mode, the pedal, the robot and the increments.
 */
class ActivityStage : public ::testing::Test {
 protected:
  static void SetUpTestSuite() { useOde(); }

  explicit ActivityStage(const TrainerConfig& of_stage = packagedConfig()) : config(of_stage) {
    stage.modes = &modes;
    describe();
  }

  /** Updates the arms' state as the loop does at the end of a tick. */
  void describe() {
    for (const Arm arm : kArms)
      stage.arms.describe(arm, true, &at(stage.state.arms, arm));
  }

  /** Shows a homed robot whose gold shoulder is `away` [rad] from the model's. */
  void showRobot(double away = 0.0) {
    RobotState robot;
    robot.connected = 1;
    robot.frame = robot.cycle = ++frame;
    robot.homed = 1;
    robot.runlevel = RunLevel::kPedalUp;
    robot.arms[0].q = stage.arms.joints(Arm::kGold);
    robot.arms[1].q = stage.arms.joints(Arm::kGreen);
    robot.arms[0].q[kShoulder] += away;
    shared->robot.store(robot);
    stage.robot.hear(shared->robot, 0);
    stage.robot.forgetOld();
    stage.robot.becomesReady();
  }

  void move(Arm arm, const Vec3& dp_I) {
    at(stage.increments.dp_I, arm) = dp_I;
    stage.increments.commands = 1;
  }

  /** Runs one tick of the activity and its world, as the loop does. */
  void tick(loop::Activity* activity) {
    activity->supervise();
    activity->tick();
    activity->move();
    stage.increments = {};
    describe();
  }

  double wanted(Arm arm, std::size_t joint) { return at(stage.arms.wanted(), arm)[joint]; }

  const TrainerConfig config;
  const model::RavenModel raven = robotOf(config);
  const model::SceneModel scene = model::loadSceneModel(config);
  std::unique_ptr<SharedState> shared = std::make_unique<SharedState>();
  loop::Stage stage{config, raven, scene, shared.get()};
  RecordedModes modes;
  std::uint64_t frame{0};
};

}  // namespace raven2_trainer::testing
