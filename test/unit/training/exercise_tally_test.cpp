#include "raven2_trainer/training/exercise_tally.h"

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "gtest/gtest.h"
#include "motion_support.h"
#include "raven2_trainer/training/session_metrics.h"

namespace raven2_trainer::training {
namespace {

/** A tick of an attempt whose timer starts `began` milliseconds into the session. */
TickRecord makeTick(Tick k, std::uint8_t attempt, ExerciseStatus status, Tick began = -1) {
  TickRecord record = makeRecord(k);
  record.model.exercise.attempt = attempt;
  record.model.exercise.status = status;
  record.model.exercise.step = 1;
  record.model.exercise.began = began < 0 ? -1 : kFirstTick + began;
  return record;
}

ExerciseRecord makeEvent(Tick k, ExerciseEventKind kind) {
  ExerciseRecord record;
  record.tick = kFirstTick + k;
  record.event.kind = kind;
  return record;
}

std::uint64_t count(const ExerciseAttempt& attempt, ExerciseEventKind kind) {
  return attempt.events[static_cast<std::size_t>(kind)];
}

/** A failed attempt of 400 ms, of which 100 are paused, and one that runs when the log ends. */
template <typename Sink>
void feedTwoAttempts(Sink* sink) {
  for (Tick k = 0; k < 100; ++k) {
    if (k == 0) sink->add(makeEvent(0, ExerciseEventKind::kStarted));
    sink->add(makeTick(k, 1, ExerciseStatus::kWaiting));
  }
  for (Tick k = 100; k < 500; ++k) {
    if (k == 100) sink->add(makeEvent(100, ExerciseEventKind::kBegan));
    if (k == 250) sink->add(makeEvent(250, ExerciseEventKind::kMistake));
    TickRecord record = makeTick(k, 1, ExerciseStatus::kRunning, 100);
    if (k >= 300 && k < 400) record.model.mode = Mode::kPaused;
    record.model.exercise.mistakes[static_cast<std::size_t>(Mistake::kDrop)] = k >= 250 ? 1 : 0;
    record.model.exercise.step = k >= 200 ? 2 : 1;
    sink->add(record);
  }
  TickRecord failed = makeTick(500, 1, ExerciseStatus::kFailed, 100);
  failed.model.exercise.mistakes[static_cast<std::size_t>(Mistake::kDrop)] = 1;
  failed.model.exercise.step = 2;
  failed.model.exercise.failure = ExerciseFailure::kMistakes;
  failed.model.exercise.ended = kFirstTick + 500;
  sink->add(makeEvent(500, ExerciseEventKind::kFailed));
  sink->add(failed);
  sink->add(makeEvent(501, ExerciseEventKind::kStarted));
  for (Tick k = 501; k < 600; ++k)
    sink->add(makeTick(k, 2, ExerciseStatus::kRunning, 501));
}

/** The tally's ticks are those of the model. */
struct TallySink {
  ExerciseTally tally;
  void add(const ExerciseRecord& record) { tally.add(record); }
  void add(const TickRecord& record) { tally.add(record.model); }
};

TEST(ExerciseTally, KeepsEachAttemptAsItEnded) {
  TallySink sink;
  feedTwoAttempts(&sink);
  const auto& attempts = sink.tally.attempts();
  ASSERT_EQ(attempts.size(), 2u);
  EXPECT_EQ(attempts[0].state.failure, ExerciseFailure::kMistakes);
  EXPECT_EQ(attempts[0].began, 100);
  EXPECT_EQ(attempts[0].ended, 500);
  EXPECT_EQ(attempts[0].ticks, 300) << "without the pause";
  EXPECT_EQ(attempts[1].state.status, ExerciseStatus::kRunning);
  EXPECT_EQ(attempts[1].ended, -1);
  EXPECT_EQ(attempts[1].ticks, 99);
}

TEST(ExerciseTally, ItsTimeStandsStillWhereTheTimerDoes) {
  ExerciseTally tally;
  Tick k = 0;
  for (const Mode mode : {Mode::kTeleoperating, Mode::kWaiting, Mode::kPaused, Mode::kReplaying, Mode::kPedalUp}) {
    for (const Tick end = k + 10; k < end; ++k) {
      TickRecord record = makeTick(k, 1, ExerciseStatus::kRunning, 0);
      record.model.mode = mode;
      tally.add(record.model);
    }
  }
  EXPECT_EQ(tally.attempts()[0].ticks, 20) << "teleoperating and with the pedal up";
}

TEST(ExerciseTally, CountsEventsWithTheAttemptOfTheirTick) {
  TallySink sink;
  feedTwoAttempts(&sink);
  const auto& attempts = sink.tally.attempts();
  EXPECT_EQ(count(attempts[0], ExerciseEventKind::kStarted), 1u);
  EXPECT_EQ(count(attempts[0], ExerciseEventKind::kMistake), 1u);
  EXPECT_EQ(count(attempts[0], ExerciseEventKind::kFailed), 1u);
  EXPECT_EQ(count(attempts[1], ExerciseEventKind::kStarted), 1u);
  EXPECT_EQ(count(attempts[1], ExerciseEventKind::kMistake), 0u);
}

TEST(ExerciseTally, WithoutAnExerciseHasNone) {
  ExerciseTally tally;
  for (Tick k = 0; k < 10; ++k)
    tally.add(makeRecord(k).model);
  EXPECT_TRUE(tally.attempts().empty());
}

TEST(ExerciseTally, ATimerThatRanBeforeTheSessionHasNoSessionTick) {
  ExerciseTally tally;
  tally.add(makeTick(20, 1, ExerciseStatus::kRunning, -1).model);
  EXPECT_EQ(tally.attempts()[0].began, -1);
  TickRecord early = makeTick(30, 1, ExerciseStatus::kRunning);
  early.model.exercise.began = kFirstTick - 5;
  tally.add(early.model);
  EXPECT_EQ(tally.attempts()[0].began, -1);
}

/** Model ticks go on in a pause, session ticks do not. */
TEST(ExerciseTally, APauseLeavesTheTimesOfAnAttemptAsTheyWere) {
  ExerciseTally tally;
  for (Tick k = 0; k < 2000; ++k) {
    TickRecord record = makeTick(k, 1, k < 900 ? ExerciseStatus::kRunning : ExerciseStatus::kDone, 100);
    if (k >= 900) record.model.exercise.ended = kFirstTick + 900;
    const Tick paused = std::clamp<Tick>(k - 300, 0, 500) + std::clamp<Tick>(k - 1000, 0, 500);
    record.model.session_tick = k - paused;
    tally.add(record.model);
  }
  EXPECT_EQ(tally.attempts()[0].began, 100);
  EXPECT_EQ(tally.attempts()[0].ended, 400);
}

TEST(ExerciseTally, AttemptsBeyondTheLongestListAreCounted) {
  ExerciseTally tally;
  for (Tick k = 0; k < static_cast<Tick>(kMaxAttempts) + 7; ++k)
    tally.add(makeTick(k, static_cast<std::uint8_t>(k), ExerciseStatus::kWaiting).model);
  EXPECT_EQ(tally.attempts().size(), kMaxAttempts);
  EXPECT_EQ(tally.beyond(), 7u);
  EXPECT_EQ(tally.attempts().back().state.attempt, static_cast<std::uint8_t>(kMaxAttempts - 1)) << "not of those";
}

TEST(MetricsFile, TellsOfTheExercise) {
  session::LogHeader header;
  header.exercise = "peg_transfer";
  MetricsAccumulator metrics(header);
  feedTwoAttempts(&metrics);
  const std::filesystem::path path =
      std::filesystem::temp_directory_path() / ("exercise_tally_" + std::to_string(::getpid()) + ".json");
  writeMetrics(path.string(), metrics.result());
  std::ifstream file(path);
  const nlohmann::json exercise = nlohmann::json::parse(file).at("exercise");
  std::filesystem::remove(path);
  EXPECT_EQ(exercise.at("name"), "peg_transfer");
  EXPECT_TRUE(exercise.at("drill").is_null());
  ASSERT_EQ(exercise.at("attempts").size(), 2u);
  const nlohmann::json& first = exercise.at("attempts")[0];
  EXPECT_EQ(first.at("status"), "failed");
  EXPECT_EQ(first.at("failure"), "mistakes");
  EXPECT_EQ(first.at("time_s"), 0.3);
  EXPECT_EQ(first.at("steps_done"), 1);
  EXPECT_EQ(first.at("mistakes").at("drop"), 1);
  EXPECT_EQ(first.at("events").at("mistake"), 1);
  EXPECT_TRUE(exercise.at("attempts")[1].at("ended_tick").is_null());
}

}  // namespace
}  // namespace raven2_trainer::training
