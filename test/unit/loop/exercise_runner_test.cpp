#include "loop/exercise_runner.h"

#include <gtest/gtest.h>

#include "raven2_trainer/config/load_config.h"
#include "support/rig.h"

namespace raven2_trainer::loop {
namespace {

using raven2_trainer::testing::goldTowards;
using raven2_trainer::testing::Rig;

TrainerConfig configWith(const std::string& exercise) {
  raven2_trainer::testing::useOde();
  TrainerConfig config = config::loadTrainerConfig(RAVEN2_TRAINER_SOURCE_DIR "/config/trainer.yaml",
                                                   config::TrainingNames{exercise, "none", "", "none"});
  raven2_trainer::testing::homeQuickly(&config);
  config.hazard = "none";
  config.runtime.plan_at = -1.0;
  return config;
}

PlanningAnswer ask(Rig* rig, RequestKind kind, std::uint32_t id) {
  Request request;
  request.kind = kind;
  request.id = id;
  EXPECT_TRUE(rig->shared->requests.tryPush(request));
  rig->tick(false);
  EXPECT_EQ(rig->model().planning.answered, id);
  return rig->model().planning.answer;
}

TEST(ExerciseRunner, WaitsForTheFirstAttemptFromTheFirstTickOn) {
  Rig rig(configWith("pick_hand_over_place"));
  rig.tick(false);
  EXPECT_EQ(rig.model().exercise.status, ExerciseStatus::kWaiting);
  EXPECT_EQ(rig.model().exercise.attempt, 1);
  EXPECT_EQ(rig.model().exercise.step, 1U);
}

TEST(ExerciseRunner, TriggersSeeNoStepBeforeTheTimerRuns) {
  Rig rig(configWith("camera_clutch"));  // this exercise begins with the first pedal-down
  ASSERT_TRUE(rig.home());
  EXPECT_EQ(rig.model().exercise.step, 1U);
  EXPECT_EQ(rig.model().faults.signals.step, 0U);
  rig.tick(true);
  EXPECT_EQ(rig.model().exercise.status, ExerciseStatus::kRunning);
  EXPECT_EQ(rig.model().faults.signals.step, 0U) << "signals are those of the tick before";
  rig.tick(true);
  EXPECT_EQ(rig.model().faults.signals.step, 1U) << "the fault engines see the step now";
}

TEST(ExerciseRunner, TellsItsEventsToWhoeverLooks) {
  Rig rig(configWith("pick_hand_over_place"));
  ASSERT_TRUE(rig.home());
  ASSERT_EQ(ask(&rig, RequestKind::kStartExercise, 7), PlanningAnswer::kAccepted);
  const ExerciseNews news = rig.shared->exercise_news.load();
  ASSERT_EQ(news.count, 2U) << "one event for each of the two attempts";
  for (std::uint64_t n = 1; n <= news.count; ++n)
    EXPECT_EQ(news.newest[n].event.kind, ExerciseEventKind::kStarted);
  EXPECT_GT(news.newest[2].tick, news.newest[1].tick);
  EXPECT_EQ(news.newest[2].tick, rig.model().tick);
}

TEST(ExerciseRunner, BeginsAnewWithTheSceneAsItWas) {
  Rig rig(configWith("pick_hand_over_place"));
  ASSERT_TRUE(rig.home());
  const Vec3 ring = rig.model().bodies[0].p;
  const auto moved = [&] { return (toEigen(rig.model().bodies[0].p) - toEigen(ring)).norm(); };
  for (int i = 0; i < 6000 && moved() < 5e-3; ++i)
    rig.tick(goldTowards(rig, ring));
  for (int i = 0; i < 50; ++i)
    rig.tick(false);
  ASSERT_GT(moved(), 4e-3) << "the tool must have moved the ring";
  EXPECT_EQ(ask(&rig, RequestKind::kStartExercise, 7), PlanningAnswer::kAccepted);
  EXPECT_EQ(rig.model().exercise.attempt, 2);
  EXPECT_EQ(rig.model().exercise.status, ExerciseStatus::kWaiting);
  EXPECT_LT(moved(), 1e-3);
}

TEST(ExerciseRunner, DoesNotBeginAnewWhileTheHandMoves) {
  Rig rig(configWith("pick_hand_over_place"));
  ASSERT_TRUE(rig.home());
  for (int i = 0; i < 200; ++i)
    rig.tick(true);
  Request request;
  request.kind = RequestKind::kStartExercise;
  request.id = 8;
  ASSERT_TRUE(rig.shared->requests.tryPush(request));
  rig.tick(true);
  EXPECT_EQ(rig.model().planning.answer, PlanningAnswer::kNotNow);
  EXPECT_EQ(rig.model().exercise.attempt, 1);
}

TEST(ExerciseRunner, DoesNotBeginAnewWithThePedalDownWhereItMovesNothing) {
  Rig rig(configWith("pick_hand_over_place"));
  for (int i = 0; i < 10; ++i)
    rig.tick(i > 4);
  ASSERT_EQ(rig.model().mode, Mode::kWaiting);
  Request request;
  request.kind = RequestKind::kStartExercise;
  request.id = 8;
  ASSERT_TRUE(rig.shared->requests.tryPush(request));
  rig.tick(true);
  EXPECT_EQ(rig.model().planning.answer, PlanningAnswer::kNotNow);
  EXPECT_EQ(rig.model().exercise.attempt, 1);
}

TEST(ExerciseRunner, AVirtualTrialIsNoPartOfTheAttempt) {
  Rig rig(configWith("camera_clutch"));  // this exercise begins with the first pedal-down
  ASSERT_TRUE(rig.home());
  for (int i = 0; i < 200; ++i)
    rig.tick(false);
  ASSERT_EQ(ask(&rig, RequestKind::kBeginTrial, 7), PlanningAnswer::kAccepted);
  for (int i = 0; i < 20; ++i)
    rig.tick(true);
  ASSERT_EQ(rig.model().mode, Mode::kTrial);
  EXPECT_EQ(rig.model().exercise.status, ExerciseStatus::kWaiting);
  for (int i = 0; i < 20; ++i)
    rig.tick(false);
  ASSERT_EQ(ask(&rig, RequestKind::kDiscardTrial, 8), PlanningAnswer::kAccepted);
  for (int i = 0; i < 6000 && rig.model().mode != Mode::kPedalUp; ++i)
    rig.tick(false);
  EXPECT_EQ(rig.model().exercise.status, ExerciseStatus::kWaiting);
  rig.tick(true);
  EXPECT_EQ(rig.model().exercise.status, ExerciseStatus::kRunning);
}

TEST(ExerciseRunner, CountsEventsThatTheJudgeHadNoRoomFor) {
  TrainerConfig config = configWith("camera_clutch");
  const model::RavenModel raven = model::loadRavenModel(config);
  const model::SceneModel scene = model::loadSceneModel(config);
  physics::RavenWorld world(raven, scene, config.model);
  const std::vector<std::string>& names = world.bodyNames();
  ASSERT_GE(names.size(), 6U);
  WatchRule rule;
  rule.mistake = Mistake::kCollision;
  rule.names_a = {names[0], names[1], names[2], names[3]};
  rule.names_b = {names[4], names[5]};
  config.exercise.rules.assign(kMaxWatchRules, rule);  // every rule sees a touch
  ContactList contacts;
  for (std::uint16_t a = 0; a < 4; ++a) {
    for (const std::uint16_t b : {4, 5}) {
      Contact& touch = contacts.contacts[contacts.count++];
      touch.a = a;
      touch.b = b;
      touch.n_W = touch.f_W = {0.0, 0.0, 1.0};
    }
  }
  const auto shared = std::make_unique<SharedState>();
  ExerciseRunner runner(config, scene, config.render.cameras.front(), &world, shared.get());
  ModelState state;
  state.mode = Mode::kTeleoperating;
  state.pedal = 1;
  const auto pass = [&](int ticks, const ContactList& seen) {
    for (int i = 0; i < ticks; ++i, ++state.tick)
      runner.tick(&state, seen, false);
    return shared->exercise_records.counts().dropped;
  };
  const std::uint64_t once = pass(3, contacts);
  EXPECT_GT(once, 0U);
  const RingCounts counts = shared->exercise_records.counts();
  // Events: started, began, and a touch and a mistake for each entry of the judge's table of touches.
  const std::size_t seen = state.exercise.mistakes[static_cast<std::size_t>(Mistake::kCollision)];
  EXPECT_GE(seen, kMaxWatchRules);
  EXPECT_EQ(counts.pushed + counts.dropped, 2U + 2U * seen);
  const std::uint64_t before = pass(2000, ContactList{});
  EXPECT_EQ(pass(3, contacts) - before, once - 2U) << "the touches come again, but started and began come once";
}

TEST(ExerciseRunner, WithoutAnExerciseThereIsNothingToBegin) {
  Rig rig(configWith("none"));
  EXPECT_EQ(ask(&rig, RequestKind::kStartExercise, 9), PlanningAnswer::kNotNow);
  EXPECT_EQ(rig.model().exercise.status, ExerciseStatus::kNone);
}

TEST(ExerciseRunner, EveryShippedExerciseCanBegin) {
  for (const char* name : {"pick_hand_over_place", "ring_tower_transfer", "ring_along_loops", "peg_transfer",
                           "retrieve_and_reach", "camera_clutch"}) {
    Rig rig(configWith(name));
    for (int i = 0; i < 100; ++i)
      rig.tick(false);
    EXPECT_EQ(rig.model().exercise.status, ExerciseStatus::kWaiting) << name;
    EXPECT_EQ(rig.model().exercise.mistakes, (std::array<std::uint32_t, kMistakeCount>{})) << name;
  }
}

/** A hazard may wait for a tool change in an exercise, too. */
TEST(ExerciseRunner, TriggersSeeToolChangesBesideItsOwnSignals) {
  Rig rig(configWith("camera_clutch"));  // this exercise begins with the first pedal-down
  ASSERT_TRUE(rig.home());
  for (std::uint32_t change = 1; change <= 2; ++change) {
    ASSERT_EQ(ask(&rig, RequestKind::kToolChange, 6 + change), PlanningAnswer::kAccepted);
    rig.tick(false);
    EXPECT_EQ(rig.model().faults.signals.tool_changes, change);
  }
  for (int i = 0; i < 3; ++i)
    rig.tick(true);
  EXPECT_EQ(rig.model().faults.signals.step, 1U);
  EXPECT_EQ(rig.model().faults.signals.tool_changes, 2U);
}

}  // namespace
}  // namespace raven2_trainer::loop
