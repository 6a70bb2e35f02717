#include "ros/bridge/training_messages.h"

#include <gtest/gtest.h>

#include <set>

#include "raven2_trainer/loop/exercise_news.h"
#include "ros/pictures/camera_view.h"

namespace raven2_trainer::ros_bridge {
namespace {

const ros::Time kStamp(100, 5);

/** Two tracks, the second after the first. */
Exercise twoTracks() {
  Exercise exercise;
  exercise.name = "two_tracks";
  exercise.title = "Two tracks";
  exercise.time_limit = 90.0;
  exercise.tracks.resize(2);
  exercise.tracks[0] = {"first", 0, kNobody, {{"lift", {}, 0.0}, {"place", {}, 0.0}}};
  exercise.tracks[1] = {"second", 1, 0, {{"lift", {}, 0.0}, {"hand_over", {}, 0.0}, {"place", {}, 0.0}}};
  return exercise;
}

ModelState running() {
  ModelState model;
  model.tick = 7250;
  model.exercise.status = ExerciseStatus::kRunning;
  model.exercise.attempt = 3;
  model.exercise.step = 2;
  model.exercise.done = {1, 0};
  model.exercise.began = 5000;
  model.exercise.mistakes[static_cast<std::size_t>(Mistake::kDrop)] = 4;
  model.exercise.progress = 0.25;
  return model;
}

TEST(ExerciseProgressMessage, TellsStepsMistakesAndTime) {
  const ExerciseProgress message = exerciseProgress(running(), twoTracks(), kStamp);
  EXPECT_EQ(message.header.stamp, kStamp);
  EXPECT_EQ(message.exercise, "two_tracks");
  EXPECT_EQ(message.title, "Two tracks");
  EXPECT_EQ(message.status, "running");
  EXPECT_EQ(message.failure, "none");
  EXPECT_EQ(message.attempt, 3U);
  EXPECT_EQ(message.step, 2U);
  EXPECT_EQ(message.steps, 5U);
  EXPECT_EQ(message.tracks, (std::vector<std::string>{"first", "second"}));
  EXPECT_EQ(message.done, (std::vector<std::uint32_t>{1, 0}));
  EXPECT_EQ(message.current, (std::vector<std::string>{"place", ""})) << "the second waits for the first";
  ASSERT_EQ(message.mistakes.size(), message.mistake_counts.size());
  EXPECT_EQ(message.mistakes.at(2), "drop");
  EXPECT_EQ(message.mistake_counts.at(2), 4U);
  EXPECT_DOUBLE_EQ(message.elapsed, 2.25);
  EXPECT_DOUBLE_EQ(message.time_limit, 90.0);
  EXPECT_DOUBLE_EQ(message.progress, 0.25);
}

TEST(ExerciseProgressMessage, TheNextTrackHasItsTurnOnceTheOneBeforeIsDone) {
  ModelState model = running();
  model.exercise.done = {2, 1};
  EXPECT_EQ(exerciseProgress(model, twoTracks(), kStamp).current, (std::vector<std::string>{"", "hand_over"}));
  model.exercise.done = {2, 3};
  EXPECT_EQ(exerciseProgress(model, twoTracks(), kStamp).current, (std::vector<std::string>{"", ""}));
}

TEST(ExerciseProgressMessage, TheTimerRunsFromItsBeginningToItsEnd) {
  ModelState model = running();
  model.exercise.ended = 6500;
  model.exercise.status = ExerciseStatus::kFailed;
  model.exercise.failure = ExerciseFailure::kBrokeOff;
  const ExerciseProgress message = exerciseProgress(model, twoTracks(), kStamp);
  EXPECT_DOUBLE_EQ(message.elapsed, 1.5);
  EXPECT_EQ(message.failure, "broke_off");
  model.exercise.began = model.exercise.ended = -1;
  EXPECT_EQ(exerciseProgress(model, twoTracks(), kStamp).elapsed, 0.0) << "the exercise has not begun";
}

TEST(ExerciseProgressMessage, WithoutAnExerciseThereIsNone) {
  const ExerciseProgress message = exerciseProgress(ModelState{}, Exercise{}, kStamp);
  EXPECT_EQ(message.exercise, "");
  EXPECT_EQ(message.status, "none");
  EXPECT_TRUE(message.tracks.empty());
}

ExerciseEventStamped told(const ExerciseEvent& event) {
  return exerciseEvent(12, {34, event}, twoTracks(), {"world", "ring", "tower"}, kStamp);
}

TEST(ExerciseEvents, AStepIsNamed) {
  ExerciseEvent event;
  event.kind = ExerciseEventKind::kStepDone;
  event.track = 1;
  event.step = 1;
  const ExerciseEventStamped message = told(event);
  EXPECT_EQ(message.number, 12U);
  EXPECT_EQ(message.tick, 34);
  EXPECT_EQ(message.event, "step_done");
  EXPECT_EQ(message.track, "second");
  EXPECT_EQ(message.step, "hand_over");
  EXPECT_EQ(message.arm, "");
  EXPECT_EQ(message.mistake, "");
  EXPECT_EQ(message.a, "");
}

TEST(ExerciseEvents, ATouchTellsBodiesForceAndDuration) {
  ExerciseEvent event;
  event.kind = ExerciseEventKind::kTouchEnded;
  event.mistake = Mistake::kCollision;
  event.a = 1;
  event.b = 2;
  event.value = 0.4;
  event.force = 1.5;
  const ExerciseEventStamped message = told(event);
  EXPECT_EQ(message.event, "touch_ended");
  EXPECT_EQ(message.mistake, "collision");
  EXPECT_EQ(message.a, "ring");
  EXPECT_EQ(message.b, "tower");
  EXPECT_EQ(message.value, 0.4);
  EXPECT_EQ(message.force, 1.5);
  EXPECT_EQ(message.track, "");
}

TEST(ExerciseEvents, AnArmIsToldWhereThereIsOne) {
  ExerciseEvent event;
  event.kind = ExerciseEventKind::kHeld;
  event.arm = Hand::kGreen;
  event.a = 1;
  EXPECT_EQ(told(event).arm, "green");
  EXPECT_EQ(told(event).mistake, "") << "not wire_touch, which is only the first of the list";
  event.kind = ExerciseEventKind::kBegan;
  EXPECT_EQ(told(event).arm, "");
}

TEST(ExerciseEvents, ValuesThatAreNoneOfTheirEnumerationsDoNoHarm) {
  ExerciseEvent event;
  event.kind = static_cast<ExerciseEventKind>(200);
  event.track = 1;
  event.step = 200;
  event.a = 3;
  const ExerciseEventStamped message = told(event);
  EXPECT_EQ(message.event, "unknown");
  EXPECT_EQ(message.track, "second");
  EXPECT_EQ(message.step, "");
  EXPECT_EQ(message.a, "");
}

TEST(TrainerModeMessage, TellsWhatTheDaemonDoes) {
  ModelState model;
  model.mode = Mode::kTrial;
  model.pedal = 1;
  model.engaged = 0;
  model.view = 1;
  model.trial_ticks = 1500;
  const TrainerMode message = trainerMode(model, kStamp);
  EXPECT_EQ(message.mode, "trial");
  EXPECT_TRUE(message.pedal);
  EXPECT_FALSE(message.engaged);
  EXPECT_FALSE(message.linked);
  EXPECT_EQ(message.view, "real");
  EXPECT_DOUBLE_EQ(message.trial_time, 1.5);
}

TEST(Changes, WhatAMessageTellsIsSeenAndWhatGoesOnInEveryTickIsNot) {
  const ModelState model = running();
  ModelState later = model;
  later.tick += 100;
  later.trial_ticks += 100;
  later.exercise.progress = 0.5;
  EXPECT_TRUE(isSameMode(model, later));
  EXPECT_TRUE(isSameProgress(model.exercise, later.exercise));
  later.exercise.done[0] = 2;
  EXPECT_FALSE(isSameProgress(model.exercise, later.exercise));
  later = model;
  later.exercise.mistakes[0] = 1;
  EXPECT_FALSE(isSameProgress(model.exercise, later.exercise));
  later.view = 1;
  EXPECT_FALSE(isSameMode(model, later));
}

/** Numbers of the events that a reader gets after the first `seen`. The tick of an event shows its number. */
std::vector<std::uint64_t> unseen(const ExerciseNews& news, std::uint64_t seen) {
  std::vector<std::uint64_t> numbers;
  for (std::uint64_t n = news.firstAfter(seen); n <= news.count; ++n) {
    EXPECT_EQ(news.newest[n % ExerciseNews::kKept].tick, static_cast<Tick>(1000 + n));
    numbers.push_back(n);
  }
  return numbers;
}

TEST(ExerciseNewsCell, AReaderGetsEachEventOnceAndSeesWhichOnesItMissed) {
  ExerciseNews news;
  EXPECT_TRUE(unseen(news, 0).empty());
  for (Tick n = 1; n <= 5; ++n)
    news.add({1000 + n, {}});
  EXPECT_EQ(unseen(news, 0), (std::vector<std::uint64_t>{1, 2, 3, 4, 5}));
  EXPECT_EQ(unseen(news, 3), (std::vector<std::uint64_t>{4, 5}));
  EXPECT_TRUE(unseen(news, 5).empty());
  for (Tick n = 6; n <= 200; ++n)
    news.add({1000 + n, {}});
  const std::vector<std::uint64_t> kept = unseen(news, 5);
  EXPECT_EQ(kept.front(), 137U) << "the last 64 are kept";
  EXPECT_EQ(kept.back(), 200U);
}

TEST(RealPictures, AreShownIfAllTheirBytesAreThere) {
  sensor_msgs::Image picture;
  EXPECT_FALSE(isWhole(picture));
  picture.width = 4;
  picture.height = 2;
  picture.step = 12;
  picture.data.assign(24, 0);
  EXPECT_TRUE(isWhole(picture));
  picture.data.pop_back();
  EXPECT_FALSE(isWhole(picture));
  picture.data.clear();
  picture.step = 0;
  EXPECT_FALSE(isWhole(picture));
}

/** Each fact in a message counts as a change. */
TEST(Changes, EveryFactOfTheModeIsOne) {
  const std::vector<void (*)(ModelState*)> changes{
      [](ModelState* m) { m->mode = Mode::kPaused; }, [](ModelState* m) { m->pedal = 1; },
      [](ModelState* m) { m->engaged = 0; }, [](ModelState* m) { m->linked = 1; }, [](ModelState* m) { m->view = 1; }};
  for (std::size_t i = 0; i < changes.size(); ++i) {
    ModelState changed;
    changes[i](&changed);
    EXPECT_FALSE(isSameMode(ModelState{}, changed)) << i;
    EXPECT_FALSE(isSameMode(changed, ModelState{})) << i;
  }
}

TEST(Changes, EveryFactOfTheProgressIsOne) {
  const std::vector<void (*)(ExerciseState*)> changes{[](ExerciseState* s) { s->status = ExerciseStatus::kDone; },
                                                      [](ExerciseState* s) { s->failure = ExerciseFailure::kBrokeOff; },
                                                      [](ExerciseState* s) { ++s->attempt; },
                                                      [](ExerciseState* s) { ++s->step; },
                                                      [](ExerciseState* s) { ++s->done.back(); },
                                                      [](ExerciseState* s) { ++s->began; },
                                                      [](ExerciseState* s) { ++s->ended; },
                                                      [](ExerciseState* s) { ++s->mistakes.back(); }};
  for (std::size_t i = 0; i < changes.size(); ++i) {
    ExerciseState changed = running().exercise;
    changes[i](&changed);
    EXPECT_FALSE(isSameProgress(running().exercise, changed)) << i;
  }
}

TEST(TrainerModeMessage, EachFlagIsItsOwn) {
  for (const bool engaged : {true, false}) {
    ModelState model;
    model.engaged = engaged ? 1 : 0;
    model.linked = engaged ? 0 : 1;
    const TrainerMode message = trainerMode(model, kStamp);
    EXPECT_EQ(message.engaged != 0, engaged);
    EXPECT_EQ(message.linked != 0, !engaged);
    EXPECT_FALSE(message.pedal);
    EXPECT_EQ(message.view, "virtual");
  }
}

TEST(RealPictures, OfRowsShorterThanThePictureAreNotShown) {
  sensor_msgs::Image picture;
  picture.width = 4;
  picture.height = 2;
  picture.step = 3;
  picture.data.assign(6, 0);
  EXPECT_FALSE(isWhole(picture));
  picture.step = 4;
  picture.data.assign(8, 0);
  EXPECT_TRUE(isWhole(picture)) << "one byte a pixel";
}

}  // namespace
}  // namespace raven2_trainer::ros_bridge
