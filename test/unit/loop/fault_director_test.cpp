#include "raven2_trainer/loop/fault_director.h"

#include <gtest/gtest.h>

#include <memory>

#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/config/load_training.h"
#include "raven2_trainer/faults/arming.h"

namespace raven2_trainer::loop {
namespace {

/** The director of a session with a drill, and what the physics loop would tell it. */
struct Desk {
  Desk()
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
  void request(std::uint8_t start, std::uint32_t id) { shared->fault_requests.tryPush({start, id}); }
  FaultPlan plan() const { return shared->faults.load(); }
  std::uint32_t drill() const { return config::faultId(config, "sudden_jump"); }

  const TrainerConfig config;
  std::unique_ptr<SharedState> shared{std::make_unique<SharedState>()};
  FaultDirector director;
  ModelState model;
};

TEST(FaultDirectorDrill, IsArmedFromTheStartAndStaysSoForTheAttempt) {
  Desk desk;
  const FaultPlan first = desk.plan();
  ASSERT_EQ(first.count, 1U);
  EXPECT_EQ(first.faults[0].trigger, FaultTrigger::kStep);
  desk.director.tick();  // before the first tick of the physics
  for (const ExerciseStatus status : {ExerciseStatus::kWaiting, ExerciseStatus::kRunning}) {
    for (int i = 0; i < 20; ++i)
      desk.tick(1, status);
  }
  EXPECT_EQ(desk.plan().generation, first.generation) << "nothing was changed";
}

TEST(FaultDirectorDrill, EndsWithItsAttempt) {
  for (const ExerciseStatus end : {ExerciseStatus::kDone, ExerciseStatus::kFailed}) {
    Desk desk;
    desk.tick(1, ExerciseStatus::kRunning);
    desk.tick(1, end);
    EXPECT_EQ(desk.plan().count, 0U);
    const std::uint64_t generation = desk.plan().generation;
    for (int i = 0; i < 20; ++i)
      desk.tick(1, end);
    EXPECT_EQ(desk.plan().generation, generation) << "once";
  }
}

TEST(FaultDirectorDrill, EveryAttemptHasItsOwnDrawnAnew) {
  Desk desk;
  const Fault first = desk.plan().faults[0];
  desk.tick(1, ExerciseStatus::kRunning);
  desk.tick(2, ExerciseStatus::kWaiting);
  EXPECT_EQ(desk.plan().count, 0U) << "what triggers look at is still of the attempt before";
  desk.tick(2, ExerciseStatus::kWaiting);
  ASSERT_EQ(desk.plan().count, 1U);
  const Fault second = desk.plan().faults[0];
  EXPECT_NE(second.arming, first.arming) << "it begins anew";
  EXPECT_EQ(second.first_tick, faults::drillPlan(desk.config, 2, 0).faults[0].first_tick);
  EXPECT_NE(second.first_tick, first.first_tick);
  desk.tick(2, ExerciseStatus::kDone);
  EXPECT_EQ(desk.plan().count, 0U);
  desk.tick(3, ExerciseStatus::kWaiting);
  desk.tick(3, ExerciseStatus::kWaiting);
  EXPECT_EQ(desk.plan().count, 1U);
}

TEST(FaultDirectorDrill, StaysClearedOnceItWasClearedByRequest) {
  for (const bool all : {true, false}) {
    Desk desk;
    desk.tick(1, ExerciseStatus::kRunning);
    desk.request(0, all ? 0 : desk.drill());
    desk.tick(1, ExerciseStatus::kRunning);
    EXPECT_EQ(desk.plan().count, 0U);
    for (int i = 0; i < 5; ++i)
      desk.tick(2, ExerciseStatus::kWaiting);
    EXPECT_EQ(desk.plan().count, 0U);
  }
}

TEST(FaultDirectorDrill, StartedByRequestItIsTheLibrarysScenario) {
  Desk desk;
  desk.request(1, desk.drill());
  desk.tick(1, ExerciseStatus::kRunning);
  ASSERT_EQ(desk.plan().count, 1U);
  EXPECT_EQ(desk.plan().faults[0].trigger, FaultTrigger::kPedalDown);
  desk.tick(1, ExerciseStatus::kDone);
  EXPECT_EQ(desk.plan().count, 1U) << "it is no drill any more";
}

/** `count` rows of one scenario behind what is there. */
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
  Desk desk;
  const std::uint32_t other = config::faultId(desk.config, "unavailable_recoverable");
  desk.request(1, other);
  desk.tick(1, ExerciseStatus::kRunning);
  EXPECT_EQ(desk.plan().count, 2U);
  desk.tick(1, ExerciseStatus::kDone);
  ASSERT_EQ(desk.plan().count, 1U);
  EXPECT_EQ(desk.plan().faults[0].id, other);
}

}  // namespace
}  // namespace raven2_trainer::loop
