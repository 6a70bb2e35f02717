#include "ros/planning/planning_client.h"

#include <gtest/gtest.h>

#include <set>

#include "fake_loop.h"

namespace raven2_trainer::ros_bridge {
namespace {

class PlanningClientTest : public ::testing::Test {
 protected:
  FakeLoop loop;
  PlanningClient client{&loop.shared, [this] { loop.tick(); }};
};

TEST_F(PlanningClientTest, EachRequestGetsAnIdOfItsOwnAndTheAnswerToIt) {
  loop.on_request = [this](const Request& request) {
    const bool begins = request.kind == RequestKind::kBeginPlanning;
    loop.answer(request, begins ? PlanningAnswer::kAccepted : PlanningAnswer::kNotNow);
  };
  const PlanningClient::Asked begin = client.ask(requestOf(RequestKind::kBeginPlanning));
  const PlanningClient::Asked end = client.ask(requestOf(RequestKind::kEndPlanning));
  EXPECT_EQ(begin.answer, PlanningAnswer::kAccepted);
  EXPECT_EQ(end.answer, PlanningAnswer::kNotNow);
  ASSERT_EQ(loop.seen.size(), 2U);
  EXPECT_EQ(loop.seen[0].id, begin.id);
  EXPECT_EQ(loop.seen[1].id, end.id);
  EXPECT_NE(begin.id, end.id);
}

TEST_F(PlanningClientTest, AnAnswerToSomebodyElseIsNone) {
  loop.on_tick = [this](int) { loop.shared.answers.tryPush({999, PlanningAnswer::kAccepted}); };
  EXPECT_EQ(client.ask(requestOf(RequestKind::kExecutePlan)).answer, PlanningAnswer::kNone);
  EXPECT_GE(loop.ticks, 250) << "a loop may be late for as long as max_backlog";
  EXPECT_LE(loop.ticks, 1000) << "the client does not wait for ever";
}

TEST_F(PlanningClientTest, AnExecutionThatWasNotAnsweredIsCalledOff) {
  EXPECT_EQ(client.ask(requestOf(RequestKind::kExecutePlan)).answer, PlanningAnswer::kNone);
  loop.tick();
  ASSERT_EQ(loop.seen.size(), 2U);
  EXPECT_EQ(loop.seen[0].kind, RequestKind::kExecutePlan);
  EXPECT_EQ(loop.seen[1].kind, RequestKind::kCancelPlan) << "it follows the order, whenever the loop goes on";
}

TEST_F(PlanningClientTest, SoIsARepetition) {
  EXPECT_EQ(client.ask(requestOf(RequestKind::kRepeatTrial)).answer, PlanningAnswer::kNone);
  loop.tick();
  ASSERT_EQ(loop.seen.size(), 2U);
  EXPECT_EQ(loop.seen[1].kind, RequestKind::kCancelPlan);
}

TEST_F(PlanningClientTest, WhatArmsNothingIsNotCalledOff) {
  EXPECT_EQ(client.ask(requestOf(RequestKind::kBeginTrial)).answer, PlanningAnswer::kNone);
  loop.tick();
  EXPECT_EQ(loop.seen.size(), 1U);
}

/** The mode that a stop leads to is over before the client looks, or was there before. Only the answer counts. */
TEST_F(PlanningClientTest, AStopIsConfirmedByItsAnswerInAnyMode) {
  const auto stop = [this] {
    return client.askBy([this](std::uint32_t id) {
      Request request = requestOf(RequestKind::kEmergencyStop);
      request.id = id;
      return client.post(request);
    });
  };
  loop.on_request = [this](const Request& request) { loop.answer(request, PlanningAnswer::kAccepted); };
  loop.mode = Mode::kPedalUp;
  loop.tell();
  EXPECT_EQ(stop().answer, PlanningAnswer::kAccepted);
  EXPECT_EQ(loop.ticks, 1);
  loop.on_request = [](const Request&) {};
  loop.mode = Mode::kStopped;
  loop.tell();
  EXPECT_EQ(stop().answer, PlanningAnswer::kNone);
}

TEST_F(PlanningClientTest, APauseIsAnsweredWithTheModeAfterIt) {
  std::uint32_t asked_id = 0;
  loop.on_tick = [&](int tick) {
    if (tick == 3) loop.shared.answers.tryPush({asked_id, PlanningAnswer::kAccepted, Mode::kPaused});
  };
  const PlanningClient::Asked asked = client.askBy([&](std::uint32_t id) {
    asked_id = id;
    return true;
  });
  EXPECT_EQ(asked.id, asked_id);
  EXPECT_EQ(asked.answer, PlanningAnswer::kAccepted);
  EXPECT_EQ(asked.mode, Mode::kPaused);
  EXPECT_EQ(loop.ticks, 3);
  EXPECT_EQ(client.askBy([](std::uint32_t) { return false; }).answer, PlanningAnswer::kNone);
  EXPECT_EQ(loop.ticks, 3) << "the client waited for what was never sent";
}

TEST_F(PlanningClientTest, AnAnswerStaysWhateverComesAfterIt) {
  loop.on_request = [this](const Request& request) {
    loop.answer(request, PlanningAnswer::kAccepted);
    loop.plan(request.id, PlanStatus::kNoPath);
    loop.plan(request.id + 1, PlanStatus::kSuccess);
    loop.report(request.id, ExecutionEnd::kReleased);
    loop.report(request.id + 1, ExecutionEnd::kFinished);
  };
  const std::uint32_t id = client.ask(requestOf(RequestKind::kPlan)).id;
  ASSERT_TRUE(client.awaitPlan(id, 1.0));
  EXPECT_EQ(client.plan(id)->status, PlanStatus::kNoPath);
  EXPECT_EQ(client.plan(id + 1)->status, PlanStatus::kSuccess);
  ASSERT_TRUE(client.execution(id));
  EXPECT_EQ(client.execution(id)->end, ExecutionEnd::kReleased);
  EXPECT_EQ(client.execution(id + 1)->end, ExecutionEnd::kFinished);
}

/** Answers that nobody fetched do not fill the rings for later requests. */
TEST_F(PlanningClientTest, AHundredRequestsInARowGetTheirAnswers) {
  loop.on_request = [this](const Request& request) {
    loop.answer(request, PlanningAnswer::kAccepted);
    loop.plan(request.id, PlanStatus::kSuccess);
    loop.report(request.id, ExecutionEnd::kFinished);
  };
  std::uint32_t id = 0;
  for (int i = 0; i < 100; ++i) {
    const PlanningClient::Asked asked = client.ask(requestOf(RequestKind::kPlan));
    ASSERT_EQ(asked.answer, PlanningAnswer::kAccepted) << i;
    id = asked.id;
  }
  EXPECT_TRUE(client.plan(id));
  EXPECT_TRUE(client.execution(id));
}

TEST_F(PlanningClientTest, AFullRingIsNoAnswerAtOnce) {
  while (client.post(requestOf(RequestKind::kEngage))) {
  }
  EXPECT_EQ(client.ask(requestOf(RequestKind::kPlan)).answer, PlanningAnswer::kNone);
  EXPECT_EQ(loop.ticks, 0) << "the client waited for a request that was never posted";
}

TEST_F(PlanningClientTest, WhatShowsInTheStateIsNoAnswer) {
  loop.on_request = [this](const Request& request) { loop.planning.plan = loop.planning.answered = request.id; };
  EXPECT_EQ(client.ask(requestOf(RequestKind::kPlan)).answer, PlanningAnswer::kNone);
}

TEST_F(PlanningClientTest, WaitsForItsOwnPlan) {
  loop.on_tick = [this](int tick) {
    if (tick == 20) loop.plan(7, PlanStatus::kSuccess);
    if (tick == 40) loop.plan(8, PlanStatus::kNoPath);
  };
  const std::optional<PlanResult> result = client.awaitPlan(8, 0.1);
  ASSERT_TRUE(result);
  EXPECT_EQ(result->status, PlanStatus::kNoPath);
  EXPECT_EQ(loop.ticks, 40);
  EXPECT_FALSE(client.awaitPlan(9, 0.1));
  EXPECT_EQ(loop.ticks, 140);
}

TEST_F(PlanningClientTest, APlanThatTookLongerThanManyBehindItIsFound) {
  loop.on_request = [this](const Request& request) { loop.answer(request, PlanningAnswer::kAccepted); };
  const std::uint32_t slow = client.ask(requestOf(RequestKind::kPlan)).id;
  for (int i = 0; i < 20; ++i) {
    const std::uint32_t quick = client.ask(requestOf(RequestKind::kPlan)).id;
    loop.plan(quick, PlanStatus::kFailed);
    ASSERT_TRUE(client.plan(quick));
  }
  EXPECT_FALSE(client.plan(slow));
  loop.plan(slow, PlanStatus::kSuccess);
  ASSERT_TRUE(client.plan(slow));
  EXPECT_EQ(client.plan(slow)->status, PlanStatus::kSuccess);
}

TEST_F(PlanningClientTest, CancellingAnswersWhenThePlanUnderWayHasEnded) {
  loop.planning.status = PlanningStatus::kPlanning;
  loop.planning.plan = 5;
  loop.tell();
  int asked_at = 0;
  loop.on_request = [&](const Request& request) {
    EXPECT_EQ(request.kind, RequestKind::kCancelPlan);
    loop.planning.status = PlanningStatus::kIdle;
    loop.planning.plan = 0;
    loop.answer(request, PlanningAnswer::kAccepted);
    asked_at = loop.ticks;
  };
  loop.on_tick = [&](int tick) {
    if (tick == asked_at + 20) loop.plan(5, PlanStatus::kCancelled);
  };
  const PlanningClient::Cancelled cancelled = client.cancel();
  EXPECT_EQ(cancelled.answer, PlanningAnswer::kAccepted);
  EXPECT_EQ(cancelled.was, PlanningStatus::kPlanning);
  EXPECT_TRUE(cancelled.has_ended);
  EXPECT_EQ(loop.ticks, asked_at + 20);
}

TEST_F(PlanningClientTest, CancellingAPlannerThatDoesNotEndIsAnsweredInTimeAndNotAsIfItHad) {
  loop.planning.status = PlanningStatus::kPlanning;
  loop.planning.plan = 5;
  loop.tell();
  loop.on_request = [&](const Request& request) { loop.answer(request, PlanningAnswer::kAccepted); };
  const PlanningClient::Cancelled cancelled = client.cancel();
  EXPECT_EQ(cancelled.answer, PlanningAnswer::kAccepted);
  EXPECT_FALSE(cancelled.has_ended);
  EXPECT_LE(loop.ticks, 100);
}

TEST_F(PlanningClientTest, WhereNothingIsPlannedCancellingWaitsForNothing) {
  loop.planning.status = PlanningStatus::kArmed;
  loop.tell();
  loop.on_request = [&](const Request& request) { loop.answer(request, PlanningAnswer::kAccepted); };
  const PlanningClient::Cancelled cancelled = client.cancel();
  EXPECT_EQ(cancelled.was, PlanningStatus::kArmed);
  EXPECT_TRUE(cancelled.has_ended);
  EXPECT_EQ(loop.ticks, 1);
}

TEST_F(PlanningClientTest, WhoeverWaitsIsLetGoAtTheEnd) {
  loop.on_tick = [this](int tick) {
    if (tick == 3) client.stop();
  };
  EXPECT_FALSE(client.awaitPlan(1, 3600.0));
  EXPECT_EQ(loop.ticks, 3);
  EXPECT_EQ(client.ask(requestOf(RequestKind::kPlan)).answer, PlanningAnswer::kNone);
  EXPECT_EQ(loop.ticks, 3);
}

TEST_F(PlanningClientTest, ALaterClientDoesNotTakeOldAnswersForItsOwn) {
  const auto acceptAll = [this](const Request& request) { loop.answer(request, PlanningAnswer::kAccepted); };
  loop.on_request = acceptAll;
  std::set<std::uint32_t> ids{client.ask(requestOf(RequestKind::kPlan)).id};
  PlanningClient later(&loop.shared, [this] { loop.tick(); });
  EXPECT_GT(later.ask(requestOf(RequestKind::kPlan)).id, *ids.begin());
  EXPECT_GT(*ids.begin(), kOwnRequestIds);
}

}  // namespace
}  // namespace raven2_trainer::ros_bridge
