#include "ros/bridge/replay_task.h"

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>
#include <vector>

#include "fake_loop.h"

namespace raven2_trainer::ros_bridge {
namespace {

/** All sessions are in one folder of the tests. The running session need not be there. */
class ReplayTaskTest : public ::testing::Test {
 protected:
  std::uint32_t open(const std::string& path) {
    opened.push_back(path);
    if (!refusal.empty()) throw std::runtime_error(refusal);
    return 7;
  }

  void answerAll(PlanningAnswer answer) {
    loop.on_request = [this, answer](const Request& request) { loop.answer(request, answer); };
  }

  const std::string folder{::testing::TempDir()};
  FakeLoop loop;
  PlanningClient client{&loop.shared, [this] { loop.tick(); }};
  std::vector<std::string> opened;
  std::string refusal;
  ReplayTask task{&client, [this](const std::string& path) { return open(path); }, folder + "running"};
};

TEST_F(ReplayTaskTest, OpensTheSessionAndAsksWithTheNumberItGot) {
  answerAll(PlanningAnswer::kAccepted);
  loop.tell();
  const ReplayTask::Outcome outcome = task.begin(folder);
  EXPECT_EQ(outcome.code, ErrorCode::kSuccess);
  EXPECT_EQ(outcome.status, "accepted");
  EXPECT_EQ(opened, std::vector<std::string>{folder});
  ASSERT_EQ(loop.seen.size(), 1U);
  EXPECT_EQ(loop.seen[0].kind, RequestKind::kBeginReplay);
  EXPECT_EQ(loop.seen[0].plan, 7U);
}

TEST_F(ReplayTaskTest, LooksForARelativeDirectoryBesideTheRunningSession) {
  answerAll(PlanningAnswer::kAccepted);
  loop.tell();
  EXPECT_EQ(task.begin(".").code, ErrorCode::kSuccess);
  ReplayTask same(
      &client, [this](const std::string& path) { return open(path); }, folder + "running/");
  EXPECT_EQ(same.begin(".").code, ErrorCode::kSuccess);
  EXPECT_EQ(opened, (std::vector<std::string>{folder + ".", folder + "."}));
}

TEST_F(ReplayTaskTest, WhatIsNoDirectoryIsNotOpened) {
  loop.tell();
  for (const std::string& path : {std::string(), std::string("nowhere"), std::string("/dev/zero")}) {
    const ReplayTask::Outcome outcome = task.begin(path);
    EXPECT_EQ(outcome.code, ErrorCode::kFailure) << path;
    EXPECT_NE(outcome.status.find("no directory of a session"), std::string::npos) << outcome.status;
  }
  EXPECT_TRUE(opened.empty());
  EXPECT_TRUE(loop.seen.empty());
}

TEST_F(ReplayTaskTest, TellsWhyASessionCannotBeShown) {
  loop.tell();
  refusal = "session.rlog: was recorded in another scene than this session's";
  const ReplayTask::Outcome outcome = task.begin(folder);
  EXPECT_EQ(outcome.code, ErrorCode::kFailure);
  EXPECT_EQ(outcome.status, refusal);
  EXPECT_TRUE(loop.seen.empty()) << "no request is sent";
}

TEST_F(ReplayTaskTest, InAnotherModeNothingIsOpenedForTheOneThatIsShownWouldEnd) {
  for (const Mode mode : {Mode::kReplaying, Mode::kTeleoperating, Mode::kTrialHeld, Mode::kStopped}) {
    loop.mode = mode;
    loop.tell();
    const ReplayTask::Outcome outcome = task.begin(folder);
    EXPECT_EQ(outcome.code, ErrorCode::kInvalidRobotState);
    EXPECT_EQ(outcome.status, "not_now");
  }
  EXPECT_TRUE(opened.empty());
}

TEST_F(ReplayTaskTest, TellsWhatTheLoopAnswered) {
  answerAll(PlanningAnswer::kNotNow);
  loop.mode = Mode::kWaiting;
  loop.tell();
  EXPECT_EQ(task.begin(folder).status, "not_now");
  loop.on_request = [](const Request&) {};
  EXPECT_EQ(task.begin(folder).code, ErrorCode::kCommunicationFailure);
}

}  // namespace
}  // namespace raven2_trainer::ros_bridge
