#include "render/chapters.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace raven2_trainer::render {
namespace {

constexpr Tick kOrigin = 2500;  // model tick of the first pedal down
constexpr ChapterChoice kAll{0, 60'000};

session::LogHeader header() {
  session::LogHeader out;
  out.scenarios = {"sudden_jump", "net_delay"};
  out.step_names = {{"lift", "hand_over"}};
  return out;
}

/** A record of a tick, with the pedal down unless `pedal` is false. */
TickRecord tickAt(Tick session_tick, bool pedal = true) {
  TickRecord record;
  record.model.session_tick = session_tick;
  record.model.tick = kOrigin + session_tick;
  record.model.pedal = pedal ? 1 : 0;
  return record;
}

ExerciseRecord eventAt(Tick session_tick, ExerciseEventKind kind, std::uint8_t step = 0) {
  ExerciseRecord record;
  record.tick = kOrigin + session_tick;
  record.event.kind = kind;
  record.event.track = 0;
  record.event.step = step;
  return record;
}

std::vector<std::string> told(const std::vector<Chapter>& chapters) {
  std::vector<std::string> out;
  for (const Chapter& chapter : chapters)
    out.push_back(std::to_string(chapter.start_ms) + " " + chapter.title);
  return out;
}

using Told = std::vector<std::string>;

TEST(ChapterList, StepsHazardsAndThePedalAreTold) {
  ChapterList list;
  list.add(eventAt(-2000, ExerciseEventKind::kStarted));  // from before the session
  for (Tick t = 0; t < 10'000; ++t) {
    if (t == 1500) list.add(eventAt(t, ExerciseEventKind::kBegan));
    if (t == 4000) list.add(eventAt(t, ExerciseEventKind::kStepDone, 1));
    if (t == 4500) list.add(eventAt(t, ExerciseEventKind::kMistake));
    if (t == 9000) list.add(eventAt(t, ExerciseEventKind::kDone));
    TickRecord record = tickAt(t, t < 7000 || t >= 8000);
    if (t >= 5000 && t < 5300) record.robot.active_fault = 1;
    list.add(record);
  }
  EXPECT_EQ(
      told(list.chapters(header(), kAll)),
      (Told{"0 Beginning, Pedal down", "1500 Exercise begins", "4000 Step done: hand over", "5000 Hazard: sudden jump",
            "5300 Hazard ends: sudden jump", "7000 Pedal up", "8000 Pedal down", "9000 Exercise done"}));
}

TEST(ChapterList, AFaultThatOnlyTheDaemonSeesIsOneAndOneFollowsTheOther) {
  ChapterList list;
  for (Tick t = 0; t < 3000; ++t) {
    TickRecord record = tickAt(t);
    if (t >= 1000 && t < 2000) record.model.faults.active = 2;
    if (t >= 2000) record.model.faults.active = 77;
    list.add(record);
  }
  EXPECT_EQ(told(list.chapters(header(), kAll)), (Told{"0 Beginning, Pedal down", "1000 Hazard: net delay",
                                                       "2000 Hazard ends: net delay, Hazard: unknown"}));
}

TEST(ChapterList, APartOfASessionHasItsOwnTimes) {
  ChapterList list;
  for (Tick t = 0; t < 9000; ++t) {
    TickRecord record = tickAt(t);
    if (t >= 2000 && t < 6000) record.robot.active_fault = 2;
    list.add(record);
  }
  EXPECT_EQ(told(list.chapters(header(), {2000, 6000})), (Told{"0 Beginning, Hazard: net delay"}));
  EXPECT_EQ(told(list.chapters(header(), {5000, 8000})), (Told{"0 Beginning", "1000 Hazard ends: net delay"}));
}

TEST(ChapterList, APedalThatIsPressedOftenIsNoChapter) {
  for (const Tick period : {1000, 900}) {  // 20 changes and 23 changes
    ChapterList list;
    for (Tick t = 0; t < 20 * 1000; ++t)
      list.add(tickAt(t, t / period % 2 == 0));
    EXPECT_EQ(list.chapters(header(), kAll).size(), period == 1000 ? 20U : 1U);
  }
}

TEST(ChapterList, WhatAViewerCannotTellApartIsOneChapter) {
  ChapterList list;
  for (Tick t = 0; t < 5000; ++t) {
    TickRecord record = tickAt(t);
    if (t >= 3000 && t < 3000 + ChapterList::kNearest - 1) record.robot.active_fault = 1;
    if (t >= 4000 && t < 4000 + ChapterList::kNearest) record.robot.active_fault = 1;
    list.add(record);
  }
  EXPECT_EQ(told(list.chapters(header(), kAll)),
            (Told{"0 Beginning, Pedal down", "3000 Hazard: sudden jump, Hazard ends: sudden jump",
                  "4000 Hazard: sudden jump", "4100 Hazard ends: sudden jump"}));
}

TEST(ChapterList, WithoutTheHazardsNamesNothingTellsOfThem) {
  ChapterList list;
  for (Tick t = 0; t < 3000; ++t) {
    TickRecord record = tickAt(t);
    if (t >= 1000 && t < 2000) record.robot.active_fault = 1;
    if (t >= 1500) record.model.mode = Mode::kStopped;
    list.add(record);
  }
  EXPECT_EQ(told(list.chapters(header(), {0, 3000, /*names_hazards=*/false})),
            (Told{"0 Beginning, Pedal down", "1500 Robot stopped"}));
}

TEST(ChapterList, StopsLostTimeAndPlansAreTold) {
  ChapterList list;
  for (Tick t = 0; t < 9000; ++t) {
    TickRecord record = tickAt(t);
    if (t >= 1000 && t < 3000) record.model.mode = Mode::kExecuting;
    if (t >= 5000 && t < 5500) record.model.mode = Mode::kStopped;
    if (t >= 7000) record.model.mode = Mode::kPaused;
    list.add(record);
  }
  EXPECT_EQ(told(list.chapters(header(), kAll)), (Told{"0 Beginning, Pedal down", "1000 Plan begins", "3000 Plan ends",
                                                       "5000 Robot stopped", "7000 Time was lost"}));
}

TEST(ChapterList, EventsBeforeAndBehindAPauseAreWhereTheyWereInTheSession) {
  constexpr Tick kPause = 4000;  // begins at session tick 2000
  ChapterList list;
  for (Tick t = 0; t < 9000; ++t) {
    TickRecord record = tickAt(t < 2000 ? t : std::max<Tick>(1999, t - kPause));
    record.model.tick = kOrigin + t;
    list.add(record);
  }
  list.add(eventAt(1000, ExerciseEventKind::kBegan));  // times are on the model's clock; event records may be late
  list.add(eventAt(3000 + kPause, ExerciseEventKind::kDone));
  EXPECT_EQ(told(list.chapters(header(), kAll)),
            (Told{"0 Beginning, Pedal down", "1000 Exercise begins", "3000 Exercise done"}));
}

/** A hazard begins or ends every 200 ms. */
ChapterList manyHazards(Tick edges) {
  ChapterList list;
  for (Tick t = 0; t < edges * 200; ++t) {
    TickRecord record = tickAt(t);
    record.robot.active_fault = t / 200 % 2 == 0 ? 0 : 1;
    list.add(record);
  }
  list.add(eventAt(edges * 200 - 1, ExerciseEventKind::kDone));
  return list;
}

TEST(ChapterList, WhereThereAreTooManyWhatEndsGoesFirst) {
  const auto chapters = manyHazards(400).chapters(header(), {0, 1'000'000});
  EXPECT_EQ(chapters.size(), 1U + 200U + 1U);
  EXPECT_EQ(chapters[1].title, "Hazard: sudden jump");
  EXPECT_EQ(chapters[2].title, "Hazard: sudden jump");
  EXPECT_EQ(chapters.back().title, "Exercise done");
}

TEST(ChapterList, NoMoreThanAnMp4Holds) {
  const auto chapters = manyHazards(600).chapters(header(), {0, 1'000'000});
  EXPECT_EQ(chapters.size(), ChapterList::kMaxChapters);
  EXPECT_EQ(chapters[1].start_ms, 200);
}

TEST(ChapterList, TracksAndUnknownStepsHaveNames) {
  session::LogHeader two = header();
  two.step_names.push_back({"put_down"});
  ChapterList list;
  list.add(tickAt(0));
  ExerciseRecord event = eventAt(1000, ExerciseEventKind::kStepDone);
  event.event.track = 1;
  list.add(event);
  event.event.step = 9;
  event.tick += 1000;
  list.add(event);
  EXPECT_EQ(told(list.chapters(two, kAll)),
            (Told{"0 Beginning, Pedal down", "1000 Step done: put down (2)", "2000 Step done: unknown"}));
}

TEST(ChapterList, NothingHasOneChapter) {
  EXPECT_EQ(told(ChapterList().chapters(header(), kAll)), Told{"0 Beginning"});
}

}  // namespace
}  // namespace raven2_trainer::render
