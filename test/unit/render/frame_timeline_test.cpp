#include "render/frame_timeline.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::render {
namespace {

constexpr Tick kOrigin = 2500;  // model tick of the first pedal down

TickRecord tickAt(Tick session_tick) {
  TickRecord record;
  record.model.session_tick = session_tick;
  record.model.tick = kOrigin + session_tick;
  return record;
}

HapticRecord hapticAt(Tick session_tick, double force) {
  HapticRecord record;
  record.haptic.tick = kOrigin + session_tick;
  record.haptic.force_B[0] = {force, 0.0, 0.0};
  return record;
}

void addTicks(Tick count, FrameTimeline* timeline) {
  for (Tick t = 0; t < count; ++t)
    timeline->add(tickAt(t));
}

TEST(FrameTimeline, FrameKShowsTheNewestTickAtItsTime) {
  for (const int fps : {24, 25, 30, 60, 120}) {
    FrameTimeline timeline(fps, 0.0, -1.0);
    addTicks(2000, &timeline);
    const auto frames = timeline.frames({});
    ASSERT_EQ(frames.size(), static_cast<std::size_t>(2 * fps));
    for (std::size_t k = 0; k < frames.size(); ++k) {
      EXPECT_EQ(frames[k].model.session_tick, static_cast<Tick>(k * 1000 / static_cast<std::size_t>(fps)))
          << fps << " " << k;
    }
  }
}

TEST(FrameTimeline, TheNumberOfFramesIsTheRoundedDurationTimesTheRate) {
  for (const auto& [ticks, frames] :
       {std::pair<Tick, std::size_t>{1000, 30}, {1016, 30}, {1017, 31}, {10, 0}, {17, 1}}) {
    FrameTimeline timeline(30, 0.0, -1.0);
    addTicks(ticks, &timeline);
    EXPECT_EQ(timeline.frames({}).size(), frames) << ticks;
    EXPECT_EQ(timeline.sessionFrames(), static_cast<std::int64_t>(frames));
  }
}

TEST(FrameTimeline, TicksBeforeTheFirstPedalDownAreLeftOut) {
  FrameTimeline timeline(30, 0.0, -1.0);
  for (Tick t = 0; t < kOrigin; ++t) {
    TickRecord record;
    record.model.tick = t;
    timeline.add(record);
  }
  EXPECT_EQ(timeline.sessionFrames(), 0);
  addTicks(100, &timeline);
  EXPECT_EQ(timeline.frames({}).size(), 3U);
  EXPECT_EQ(timeline.frames({}).front().model.session_tick, 0);
}

TEST(FrameTimeline, AMissingStretchRepeatsTheLastFrameBeforeIt) {
  FrameTimeline timeline(100, 0.0, -1.0);
  addTicks(50, &timeline);
  timeline.add(tickAt(99));
  const auto frames = timeline.frames({});
  ASSERT_EQ(frames.size(), 10U);
  EXPECT_EQ(frames[5].model.session_tick, 49);
  EXPECT_EQ(frames[9].model.session_tick, 49);
}

TEST(FrameTimeline, TheOrderOfRecordsDoesNotMatter) {
  FrameTimeline timeline(30, 0.0, -1.0);
  for (Tick t = 999; t >= 0; --t)
    timeline.add(tickAt(t));
  const auto frames = timeline.frames({});
  ASSERT_EQ(frames.size(), 30U);
  EXPECT_EQ(frames[1].model.session_tick, 33);
}

TEST(FrameTimeline, ASpanKeepsTheFramesOfItsTimes) {
  FrameTimeline timeline(30, 0.5, 0.8);
  addTicks(1000, &timeline);
  const auto frames = timeline.frames({});
  ASSERT_EQ(frames.size(), 9U);
  EXPECT_EQ(frames.front().model.session_tick, 500);
  EXPECT_EQ(frames.back().model.session_tick, 766);
  EXPECT_EQ(timeline.sessionFrames(), 30);
}

TEST(FrameTimeline, TheForceIsTheNewestAtTheFrame) {
  FrameTimeline timeline(100, 0.0, -1.0);
  addTicks(60, &timeline);
  for (Tick t = 0; t < 36; ++t)
    timeline.add(hapticAt(t, static_cast<double>(t)));
  const auto frames = timeline.frames({});
  ASSERT_EQ(frames.size(), 6U);
  EXPECT_EQ(frames[2].haptic.force_B[0][0], 20.0);
  EXPECT_EQ(frames[3].haptic.force_B[0][0], 30.0);
  EXPECT_EQ(frames[4].haptic.force_B[0][0], 35.0);
  EXPECT_EQ(frames[5].haptic.force_B[0][0], 35.0);
}

TEST(FrameTimeline, TheFaultIsNamedWhileItActs) {
  FrameTimeline timeline(100, 0.0, -1.0);
  for (Tick t = 0; t < 50; ++t) {
    TickRecord record = tickAt(t);
    record.robot.active_fault = t >= 15 && t < 35 ? 2 : 0;
    if (t >= 35) record.robot.active_fault = 77;
    timeline.add(record);
  }
  const auto frames = timeline.frames({"sudden_jump", "stuck"});
  EXPECT_EQ(frames[1].fault, "");
  EXPECT_EQ(frames[2].fault, "stuck");
  EXPECT_EQ(frames[4].fault, "unknown") << "the log has no name for this number";
}

TEST(FrameTimeline, AFaultOfAMillisecondIsNamedForTwoSeconds) {
  for (const int fps : {25, 30, 60}) {
    FrameTimeline timeline(fps, 0.0, -1.0);
    for (Tick t = 0; t < 4000; ++t) {
      TickRecord record = tickAt(t);
      record.robot.active_fault = t == 1001 ? 1 : 0;  // between two frames at each frame rate
      timeline.add(record);
    }
    const auto frames = timeline.frames({"sudden_jump"});
    std::vector<std::size_t> named;
    for (std::size_t k = 0; k < frames.size(); ++k) {
      if (frames[k].fault == "sudden_jump") named.push_back(k);
    }
    const auto rate = static_cast<std::size_t>(fps);
    ASSERT_EQ(named.size(), 2 * rate) << fps;
    EXPECT_EQ(named.front(), rate + 1) << "the first frame that is not before the fault";
    EXPECT_EQ(named.back(), 3 * rate);
  }
}

TEST(FrameTimeline, AnotherFaultTakesTheNameAtOnce) {
  FrameTimeline timeline(100, 0.0, -1.0);
  for (Tick t = 0; t < 3500; ++t) {
    TickRecord record = tickAt(t);
    record.robot.active_fault = t < 10 ? 1 : t >= 500 && t < 1000 ? 2 : 0;
    timeline.add(record);
  }
  const auto frames = timeline.frames({"one", "other"});
  EXPECT_EQ(frames[49].fault, "one");
  EXPECT_EQ(frames[51].fault, "other");
  EXPECT_EQ(frames[250].fault, "other");
  EXPECT_EQ(frames[310].fault, "");
}

PlanRecord answerAt(Tick session_tick, std::uint32_t id, PlanStatus status) {
  PlanRecord record;
  record.tick = kOrigin + session_tick;
  record.result.id = id;
  record.result.status = status;
  return record;
}

TEST(FrameTimeline, NewsOfPlansComeWithTheTickThatHeardOfThem) {
  FrameTimeline timeline(100, 0.0, -1.0);
  timeline.add(answerAt(-100, 1, PlanStatus::kSuccess));  // before the first pedal down
  timeline.add(answerAt(20, 2, PlanStatus::kSuccess));
  timeline.add(answerAt(41, 3, PlanStatus::kCancelled));
  ExecutionRecord execution;
  execution.tick = kOrigin + 30;
  execution.report.plan = 2;
  timeline.add(execution);
  addTicks(60, &timeline);
  const auto frames = timeline.frames({});
  ASSERT_EQ(frames.size(), 6U);
  const std::uint32_t answers[] = {1, 1, 2, 2, 2, 3}, paths[] = {1, 1, 2, 2, 2, 2};
  for (std::size_t k = 0; k < frames.size(); ++k) {
    ASSERT_TRUE(frames[k].plans.answer && frames[k].plans.path) << k;
    EXPECT_EQ(frames[k].plans.answer->id, answers[k]) << k;
    EXPECT_EQ(frames[k].plans.path->id, paths[k]) << k;
    EXPECT_EQ(frames[k].plans.execution != nullptr, k >= 3) << k;
  }
  EXPECT_EQ(frames[2].plans.path.get(), frames[5].plans.path.get()) << "all frames share one copy";
}

TEST(FrameTimeline, ARequestThatWasRefusedIsNoNewsOfPlans) {
  FrameTimeline timeline(100, 0.0, -1.0);
  timeline.add(answerAt(10, 1, PlanStatus::kSuccess));
  PlanRecord refusal = answerAt(20, 2, PlanStatus::kCancelled);
  refusal.refused = 1;
  timeline.add(refusal);
  addTicks(40, &timeline);
  const auto frames = timeline.frames({});
  ASSERT_EQ(frames.size(), 4U);
  ASSERT_TRUE(frames[3].plans.answer);
  EXPECT_EQ(frames[3].plans.answer->id, 1U) << "a second request while a plan is executed does not cancel the first";
}

TEST(FrameTimeline, NewsOfPlansMayComeInAnyOrder) {
  FrameTimeline timeline(100, 0.0, -1.0);
  addTicks(40, &timeline);
  for (const Tick t : {30, 10, 20})
    timeline.add(answerAt(t, static_cast<std::uint32_t>(t), PlanStatus::kSuccess));
  const auto frames = timeline.frames({});
  ASSERT_EQ(frames.size(), 4U);
  EXPECT_FALSE(frames[0].plans.path);
  for (std::size_t k = 1; k < 4; ++k)
    EXPECT_EQ(frames[k].plans.path->id, 10 * k);
}

TEST(FrameTimeline, ContactsAreThoseOfTheTickThatIsShown) {
  const ToolContacts tools({"dome", "grasper1_L", "grasper1_R"});
  FrameTimeline timeline(100, 0.0, -1.0);
  const auto touch = [&](Tick session_tick, std::uint16_t arm, double newton) {
    ContactRecord record;
    record.tick = kOrigin + session_tick;
    record.a = 0;
    record.b = arm;
    record.f_W = {-newton, 0.0, 0.0};
    timeline.add(record, tools);
  };
  touch(0, 1, 9.0);  // before the first tick
  for (Tick t = 0; t < 40; ++t) {
    timeline.add(tickAt(t));
    if (t < 20) touch(t, 1, 1.0 + static_cast<double>(t));
    if (t == 10) touch(t, 1, 0.5);
    if (t == 10) touch(t, 2, 2.0);
    if (t == 29) touch(t, 2, 3.0);
  }
  const auto frames = timeline.frames({});
  ASSERT_EQ(frames.size(), 4U);
  EXPECT_EQ(frames[0].contact_W[0][0], 1.0);
  EXPECT_EQ(frames[1].contact_W[0][0], 11.5) << "the sum of this tick's contacts alone";
  EXPECT_EQ(frames[1].contact_W[1][0], 2.0);
  EXPECT_EQ(frames[2].contact_W[0][0], 0.0) << "the touch ended at tick 19";
  EXPECT_EQ(frames[3].contact_W[1][0], 0.0) << "this touch has ended too";
}

TEST(FrameTimeline, ForcesAreWhereTheyWereInTheSessionThoughItWasPaused) {
  FrameTimeline timeline(100, 0.0, -1.0);
  for (Tick t = 0; t < 60; ++t) {  // a pause of 20 ticks at session tick 19
    TickRecord record = tickAt(t < 20 ? t : std::max<Tick>(19, t - 20));
    record.model.tick = kOrigin + t;
    timeline.add(record);
  }
  for (Tick t = 0; t < 60; ++t)
    timeline.add(hapticAt(t, static_cast<double>(t)));
  const auto frames = timeline.frames({});
  ASSERT_EQ(frames.size(), 4U);
  EXPECT_EQ(frames[1].haptic.force_B[0][0], 10.0);
  EXPECT_EQ(frames[3].haptic.force_B[0][0], 50.0);
}

TEST(FrameTimeline, KeepsWhatWasBeforeTheSpanAsFarAsItIsAskedTo) {
  for (const auto& [lead, kept] : {std::pair{0.1, 3}, {0.0, 0}, {99.0, 15}}) {
    FrameTimeline timeline(30, 0.5, 0.7, lead);
    addTicks(1000, &timeline);
    EXPECT_EQ(timeline.firstFrame(), 15);
    ASSERT_EQ(timeline.leadFrames(), kept);
    const auto frames = timeline.frames({});
    ASSERT_EQ(frames.size(), static_cast<std::size_t>(kept) + 6);
    EXPECT_EQ(frames[static_cast<std::size_t>(kept)].model.session_tick, 500);
    EXPECT_EQ(frames[0].model.session_tick, (15 - kept) * 1000 / 30);
  }
}

TEST(FrameTimeline, AHostileTickCannotTakeTheMemory) {
  FrameTimeline timeline(30, 0.0, -1.0);
  EXPECT_THROW(timeline.add(tickAt(Tick{1} << 39)), SessionException);
  EXPECT_NO_THROW(timeline.add(tickAt(std::int64_t{1} << 60)));
  EXPECT_EQ(timeline.frames({}).size() < 1000, true);
}

}  // namespace
}  // namespace raven2_trainer::render
