#include <gtest/gtest.h>

#include <algorithm>
#include <memory>

#include "drill/drill.h"
#include "raven2_trainer/console/make_motion.h"
#include "raven2_trainer/faults/arming.h"
#include "raven2_trainer/kinematics/eigen.h"
#include "raven2_trainer/lockstep/lockstep_stack.h"
#include "raven2_trainer/physics/raven_world.h"
#include "raven2_trainer/training/hazard_response.h"

// Every exercise's drill strikes when and as the exercise says, in the whole system: judge, link, robot, surgeon.

namespace raven2_trainer::testing {
namespace {

struct DrillRun {
  explicit DrillRun(const TrainerConfig& configuration) : config(configuration) {
    physics::initialiseOde();
    physics::attachOdeToThread();
    stack = std::make_unique<lockstep::LockstepStack>(config, console::makeMotion(config, "scripted"));
  }

  void tick() {
    const bool acted = acts();
    stack->tick();
    stack->discardRecords();
    const ModelState& model = stack->view().model;
    if (reached < 0 && model.faults.signals.step >= config.exercise.drill.step) reached = model.tick;
    if (acts() && !acted) began.push_back(model.tick);
    for (const Vec3& force : stack->view().haptic.force_I)
      largest_force = std::max(largest_force, toEigen(force).norm());
  }
  void ticks(int n) {
    for (int i = 0; i < n; ++i)
      tick();
  }
  /** Ticks until the drill strikes. @return false if it does not. */
  bool strike() {
    const std::size_t before = began.size();
    for (int i = 0; i < 10000 && began.size() == before; ++i)
      tick();
    return began.size() > before;
  }
  bool acts() const {
    const DaemonFaults& daemon = stack->view().model.faults;
    return stack->robot().fault_mask != 0 || daemon.relay != 0 || daemon.master != 0 || daemon.console != 0;
  }

  const TrainerConfig config;
  std::unique_ptr<lockstep::LockstepStack> stack;
  Tick reached{-1};           ///< tick that reaches the step that starts the drill's clock
  std::vector<Tick> began{};  ///< activations
  double largest_force{0.0};  ///< [N] on a hand
};

constexpr Tick kLinkWay = 3;  // [1 ms] from the daemon's tick to the robot's cycle that acts on it

class OwnDrill : public ::testing::TestWithParam<const char*> {};

TEST_P(OwnDrill, StrikesItsDelayAfterTheStepAndIsFelt) {
  DrillRun run(drillConfig(GetParam(), "own", 1));
  const Tick delay = faults::drillPlan(run.config, 1, 1).faults[0].first_tick;
  ASSERT_TRUE(run.strike());
  ASSERT_GT(run.reached, 0);
  EXPECT_GE(run.began[0], run.reached + delay);
  EXPECT_LE(run.began[0], run.reached + delay + kLinkWay);
  run.largest_force = 0.0;
  for (int i = 0; i < 3000 && run.largest_force <= kFeltForce; ++i)
    run.tick();
  EXPECT_GT(run.largest_force, kFeltForce) << "too weak to be felt";
}

INSTANTIATE_TEST_SUITE_P(Exercises,
                         OwnDrill,
                         ::testing::Values("pick_hand_over_place",
                                           "ring_tower_transfer",
                                           "ring_along_loops",
                                           "peg_transfer",
                                           "retrieve_and_reach",
                                           "camera_clutch"),
                         [](const auto& exercise) { return std::string(exercise.param); });

TEST(Drill, ComesOnceInAnAttemptAndAgainInTheNext) {
  TrainerConfig config = drillConfig("pick_hand_over_place", "own", 1);
  config.console.clutch_every = 5.0;  // a new attempt needs a raised pedal
  DrillRun run(config);
  ASSERT_TRUE(run.strike());
  run.ticks(9000);  // the library's scenario repeats every 8 s
  EXPECT_EQ(run.began.size(), 1U);
  while (run.stack->view().model.pedal != 0)
    run.tick();
  run.ticks(100);
  Request again;
  again.kind = RequestKind::kStartExercise;
  again.id = 1;
  ASSERT_TRUE(run.stack->shared()->requests.tryPush(again));
  run.ticks(3);
  ASSERT_EQ(run.stack->view().model.exercise.attempt, 2);
  EXPECT_EQ(run.began.size(), 1U) << "the step of the previous attempt does not start the new drill";
  run.reached = -1;
  ASSERT_TRUE(run.strike());
  const Tick delay = faults::drillPlan(run.config, 2, 1).faults[0].first_tick;
  EXPECT_NE(delay, faults::drillPlan(run.config, 1, 1).faults[0].first_tick);
  EXPECT_GE(run.began[1], run.reached + delay);
  EXPECT_LE(run.began[1], run.reached + delay + kLinkWay);
  EXPECT_EQ(run.stack->view().model.exercise.attempt, 2);
}

TEST(Drill, OfAnotherScenarioStrikesAtTheSameTick) {
  std::vector<Tick> began;
  for (const char* scenario : {"own", "unavailable_recoverable", "net_delay_3"}) {
    DrillRun run(drillConfig("pick_hand_over_place", scenario, 5));
    ASSERT_TRUE(run.strike()) << scenario;
    began.push_back(run.began[0]);
  }
  EXPECT_EQ(began[0], began[1]);
  EXPECT_NEAR(static_cast<double>(began[2]), static_cast<double>(began[0]), 3.0) << "a daemon's fault needs no link";
}

TEST(Drill, TheSeedDecidesTheTick) {
  std::vector<Tick> began;
  for (const std::uint64_t seed : {1, 1, 2}) {
    DrillRun run(drillConfig("pick_hand_over_place", "own", seed));
    ASSERT_TRUE(run.strike());
    began.push_back(run.began[0] - run.reached);
  }
  EXPECT_EQ(began[0], began[1]);
  EXPECT_NE(began[0], began[2]);
}

}  // namespace
}  // namespace raven2_trainer::testing
