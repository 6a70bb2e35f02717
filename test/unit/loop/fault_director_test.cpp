#include "raven2_trainer/loop/fault_director.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>

#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/config/load_training.h"
#include "raven2_trainer/faults/arming.h"

namespace raven2_trainer::loop {
namespace {

/** The director of a session with a drill. The test plays the physics loop. */
struct Drill {
  Drill()
      : config(config::loadTrainerConfig(RAVEN2_TRAINER_SOURCE_DIR "/config/trainer.yaml",
                                         config::TrainingNames{"pick_hand_over_place", "own", "", "none"})),
        director(config, shared.get()) {}

  void tick(std::uint8_t attempt, ExerciseStatus status) {
    ++model.tick;
    model.exercise.attempt = attempt;
    model.exercise.status = status;
    shared->model.store(model);
    director.tick();
  }
  void request(FaultOrder order, std::uint32_t id) { shared->fault_requests.tryPush({order, id}); }
  FaultPlan plan() const { return shared->faults.load(); }
  std::uint32_t drill() const { return config::faultId(config, "sudden_jump"); }

  const TrainerConfig config;
  std::unique_ptr<SharedState> shared{std::make_unique<SharedState>()};
  FaultDirector director;
  ModelState model;
};

TEST(FaultDirectorDrill, IsArmedFromTheStartAndStaysSoForTheAttempt) {
  Drill drill;
  const FaultPlan first = drill.plan();
  ASSERT_EQ(first.count, 1U);
  EXPECT_EQ(first.faults[0].trigger, FaultTrigger::kStep);
  drill.director.tick();  // before the first tick of the physics
  for (const ExerciseStatus status : {ExerciseStatus::kWaiting, ExerciseStatus::kRunning}) {
    for (int i = 0; i < 20; ++i)
      drill.tick(1, status);
  }
  EXPECT_EQ(drill.plan().generation, first.generation) << "the plan did not change";
}

TEST(FaultDirectorDrill, EndsWithItsAttempt) {
  for (const ExerciseStatus end : {ExerciseStatus::kDone, ExerciseStatus::kFailed}) {
    Drill drill;
    drill.tick(1, ExerciseStatus::kRunning);
    drill.tick(1, end);
    EXPECT_EQ(drill.plan().count, 0U);
    const std::uint64_t generation = drill.plan().generation;
    for (int i = 0; i < 20; ++i)
      drill.tick(1, end);
    EXPECT_EQ(drill.plan().generation, generation) << "the plan changes only once";
  }
}

TEST(FaultDirectorDrill, EveryAttemptHasItsOwnDrawnAnew) {
  Drill drill;
  const Fault first = drill.plan().faults[0];
  drill.tick(1, ExerciseStatus::kRunning);
  drill.tick(2, ExerciseStatus::kWaiting);
  EXPECT_EQ(drill.plan().count, 0U) << "the triggers' signals still belong to the attempt before";
  drill.tick(2, ExerciseStatus::kWaiting);
  ASSERT_EQ(drill.plan().count, 1U);
  const Fault second = drill.plan().faults[0];
  EXPECT_NE(second.arming, first.arming) << "the fault is armed again";
  EXPECT_EQ(second.first_tick, faults::drillPlan(drill.config, 2, 0).faults[0].first_tick);
  EXPECT_NE(second.first_tick, first.first_tick);
  drill.tick(2, ExerciseStatus::kDone);
  EXPECT_EQ(drill.plan().count, 0U);
  drill.tick(3, ExerciseStatus::kWaiting);
  drill.tick(3, ExerciseStatus::kWaiting);
  EXPECT_EQ(drill.plan().count, 1U);
}

TEST(FaultDirectorDrill, StaysClearedOnceItWasClearedByRequest) {
  for (const bool all : {true, false}) {
    Drill drill;
    drill.tick(1, ExerciseStatus::kRunning);
    drill.request(FaultOrder::kClear, all ? 0 : drill.drill());
    drill.tick(1, ExerciseStatus::kRunning);
    EXPECT_EQ(drill.plan().count, 0U);
    for (int i = 0; i < 5; ++i)
      drill.tick(2, ExerciseStatus::kWaiting);
    EXPECT_EQ(drill.plan().count, 0U);
  }
}

TEST(FaultDirectorDrill, StartedByRequestItIsTheLibrarysScenario) {
  Drill drill;
  drill.request(FaultOrder::kArm, drill.drill());
  drill.tick(1, ExerciseStatus::kRunning);
  ASSERT_EQ(drill.plan().count, 1U);
  EXPECT_EQ(drill.plan().faults[0].trigger, FaultTrigger::kPedalDown);
  drill.tick(1, ExerciseStatus::kDone);
  EXPECT_EQ(drill.plan().count, 1U) << "a requested scenario does not end with the attempt";
}

/** Appends `count` rows of one scenario to the plan. */
void addRows(std::uint32_t id, std::uint32_t count, FaultPlan* plan) {
  for (std::uint32_t i = 0; i < count; ++i)
    plan->faults[plan->count++].id = id;
}

TEST(FaultDirector, AScenarioFitsIfItsRowsDoOnceItsOwnFormerOnesAreGone) {
  FaultPlan armed;
  addRows(1, 5, &armed);
  addRows(2, 3, &armed);
  ASSERT_EQ(armed.count, kMaxFaults);
  const auto fits = [&armed](std::uint32_t id, std::uint32_t count) {
    FaultPlan added;
    addRows(id, count, &added);
    return FaultDirector::fits(armed, added);
  };
  EXPECT_TRUE(fits(1, 5));
  EXPECT_FALSE(fits(1, 6));
  EXPECT_TRUE(fits(2, 3));
  EXPECT_FALSE(fits(2, 4));
  EXPECT_FALSE(fits(3, 1));
}

TEST(FaultDirectorDrill, AnotherScenarioStandsBesideIt) {
  Drill drill;
  const std::uint32_t other = config::faultId(drill.config, "unavailable_recoverable");
  drill.request(FaultOrder::kArm, other);
  drill.tick(1, ExerciseStatus::kRunning);
  EXPECT_EQ(drill.plan().count, 2U);
  drill.tick(1, ExerciseStatus::kDone);
  ASSERT_EQ(drill.plan().count, 1U);
  EXPECT_EQ(drill.plan().faults[0].id, other);
}

TEST(FaultDirectorDrill, AnInjectedHazardActsAtOnceAndInItsOwnOrder) {
  Drill session;
  session.request(FaultOrder::kClear, 0);
  for (const Scenario& scenario : session.config.scenarios) {
    session.request(FaultOrder::kArmAtOnce, config::faultId(session.config, scenario.name));
    session.tick(1, ExerciseStatus::kRunning);
    const FaultPlan plan = session.plan();
    ASSERT_EQ(plan.count, scenario.faults.size()) << scenario.name;
    Tick first = plan.faults[0].first_tick;
    for (std::size_t i = 0; i < plan.count; ++i) {
      const Fault& fault = plan.faults[i];
      EXPECT_EQ(fault.trigger, FaultTrigger::kHand) << scenario.name;
      EXPECT_EQ(fault.first_tick - plan.faults[0].first_tick,
                scenario.faults[i].first_tick - scenario.faults[0].first_tick);
      EXPECT_EQ(fault.duration_ticks, scenario.faults[i].duration_ticks);
      first = std::min(first, fault.first_tick);
    }
    EXPECT_EQ(first, 0) << scenario.name;
    session.request(FaultOrder::kClear, 0);
    session.tick(1, ExerciseStatus::kRunning);
    EXPECT_EQ(session.plan().count, 0U);
  }
}

}  // namespace
}  // namespace raven2_trainer::loop
