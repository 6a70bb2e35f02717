#include "raven2_trainer/loop/robot_link.h"

#include <gtest/gtest.h>

#include <zlib.h>

#include <array>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include "raven2_trainer/kinematics/arm_kinematics.h"
#include "raven2_trainer/loop/fault_director.h"
#include "support/rig.h"

namespace raven2_trainer::loop {
namespace {

class RobotLinkTest : public ::testing::Test {
 protected:
  RobotLinkTest() : config(raven2_trainer::testing::packagedConfig()), shared(std::make_unique<SharedState>()) {}

  bool hello(bool is_virtual) {
    return link.receive(buffer.data(), wire::encodeHello(1, is_virtual, buffer.data()), 5);
  }
  bool state(const RobotState& robot, std::int64_t now) {
    return link.receive(buffer.data(), wire::encodeState(2, robot, buffer.data()), now);
  }
  bool cycle(std::uint64_t number, std::int64_t time_ns) {
    RobotState robot;
    robot.cycle = number;
    robot.time_ns = time_ns;
    return state(robot, 1);
  }
  std::uint64_t rejected(Reject reason) const { return link.counts().rejected[static_cast<std::size_t>(reason)]; }
  /** Sends a hello with `word`. */
  void say(const std::string& word) {
    const std::size_t size = wire::encodeHello(1, true, buffer.data());
    ASSERT_EQ(size, wire::kFrameHeaderSize + 8);
    const auto length = static_cast<std::uint32_t>(word.size());
    std::memcpy(buffer.data() + 8, &length, sizeof(length));
    std::memcpy(buffer.data() + wire::kFrameHeaderSize, word.data(), word.size());
    const uLong header = crc32(0, buffer.data(), 16);
    const auto crc = static_cast<std::uint32_t>(crc32(header, buffer.data() + wire::kFrameHeaderSize, length));
    std::memcpy(buffer.data() + 16, &crc, sizeof(crc));
    ASSERT_TRUE(link.receive(buffer.data(), wire::kFrameHeaderSize + word.size(), 5));
  }

  TrainerConfig config;
  std::unique_ptr<SharedState> shared;
  RobotLink link{config, shared.get()};
  std::array<std::uint8_t, wire::kMaxFrame> buffer{};
};

TEST_F(RobotLinkTest, FillsInTipAndVelocityByTheKinematicChain) {
  link.connected();
  hello(true);
  RobotState sent;
  sent.arms[0].q = config.arms.geometry.home;
  sent.arms[1].q = config.arms.geometry.home;
  sent.arms[0].dq[kInsertion] = 0.1;
  ASSERT_TRUE(state(sent, 77));
  const RobotState got = shared->robot.load();
  EXPECT_EQ(got.frame, 1U);
  EXPECT_EQ(got.received_ns, 77);
  EXPECT_EQ(got.connected, 1);
  EXPECT_EQ(got.is_virtual, 1);
  EXPECT_NEAR(got.arms[0].p_BT[0], -0.077947, 1e-6);  // raven2.md 2.4, home
  EXPECT_NEAR(toEigen(got.arms[0].v_BT).norm(), 0.1, 1e-9);
}

TEST_F(RobotLinkTest, TheVelocityOfEitherTipIsTheDerivativeOfItsPlace) {
  constexpr double kStep = 1e-6;  // [s]
  const JointArray rate{0.2, -0.3, 0.04, 0.5, -0.6, 0.7, -0.1};
  RobotState sent;
  for (const Arm arm : kArms) {
    at(sent.arms, arm).q = config.arms.geometry.home;
    at(sent.arms, arm).dq = rate;
  }
  link.connected();
  ASSERT_TRUE(state(sent, 77));
  for (const Arm arm : kArms) {
    const auto placeAfter = [&](double seconds) {
      JointArray q = config.arms.geometry.home;
      for (std::size_t j = 0; j < kJointCount; ++j)
        q[j] += seconds * rate[j];
      return kinematics::forward(config.arms.geometry, arm, q).p;
    };
    const Vector3 expected = (placeAfter(kStep) - placeAfter(-kStep)) / (2.0 * kStep);
    EXPECT_NEAR((toEigen(at(shared->robot.load().arms, arm).v_BT) - expected).norm(), 0.0, 1e-8) << name(arm);
  }
}

TEST_F(RobotLinkTest, TheFaultPlanIsOfTheLinksSession) {
  constexpr std::uint32_t kSession = 4711;
  FaultDirector director(config, shared.get());
  RobotLink own(config, shared.get(), kSession);
  own.connected();
  own.receive(buffer.data(), wire::encodeHello(1, true, buffer.data()), 5);
  wire::FrameParser parser;
  wire::Frame frame;
  FaultPlan plan;
  for (std::size_t size = 0; (size = own.pendingFrame(buffer.data())) > 0;) {
    parser.feed(buffer.data(), size);
    ASSERT_EQ(parser.next(&frame), wire::FrameParser::Result::kFrame);
    wire::decodeFaultPlan(frame, &plan);
  }
  EXPECT_EQ(plan.generation, shared->faults.load().generation) << "the robot must receive the plan";
  EXPECT_EQ(plan.session, kSession);
}

TEST_F(RobotLinkTest, WhateverDoesNotSayVirtualIsReal) {
  link.connected();
  hello(false);
  state(RobotState{}, 1);
  EXPECT_EQ(shared->robot.load().is_virtual, 0);
  FaultDirector director(config, shared.get());
  EXPECT_GT(shared->faults.load().count, 0U);
  EXPECT_EQ(link.pendingFrame(buffer.data()), 0U) << "a real robot never receives a fault";
}

TEST_F(RobotLinkTest, AnotherWordAnEmptyOneAndNoneAreARealRobotsAndNeverGetAFault) {
  FaultDirector director(config, shared.get());
  ASSERT_GT(shared->faults.load().count, 0U);
  for (const std::string& word : {std::string("davinci"), std::string(""), std::string("Virtual\0", 8),
                                  std::string("virtual"), std::string("virtual\0\0", 9)}) {
    link.connected();
    say(word);
    state(RobotState{}, 1);
    EXPECT_EQ(shared->robot.load().connected, 1) << "it still counts as a robot";
    EXPECT_EQ(shared->robot.load().is_virtual, 0) << word;
    EXPECT_EQ(link.pendingFrame(buffer.data()), 0U) << word;
    link.disconnected();
  }
  link.connected();
  state(RobotState{}, 1);  // without a hello
  EXPECT_EQ(shared->robot.load().connected, 1);
  EXPECT_EQ(shared->robot.load().is_virtual, 0);
  EXPECT_EQ(link.counts().rejectedTotal(), 0U);
  hello(true);  // a later hello does not make it virtual
  cycle(1, 0);
  EXPECT_EQ(shared->robot.load().is_virtual, 0);
  EXPECT_EQ(rejected(Reject::kOutOfOrder), 1U);
  EXPECT_EQ(link.pendingFrame(buffer.data()), 0U);
}

TEST_F(RobotLinkTest, CyclesRiseAndTheTimeStampNeverGoesBack) {
  link.connected();
  hello(true);
  EXPECT_TRUE(cycle(100, 5000));
  EXPECT_TRUE(cycle(100, 6000));
  EXPECT_EQ(rejected(Reject::kDuplicate), 1U);
  EXPECT_TRUE(cycle(99, 6000));
  EXPECT_EQ(rejected(Reject::kOutOfOrder), 1U);
  EXPECT_TRUE(cycle(101, 4999));
  EXPECT_EQ(rejected(Reject::kOutOfOrder), 2U);
  EXPECT_EQ(shared->robot.load().cycle, 100U);
  EXPECT_TRUE(cycle(105, 5000)) << "frames in between were dropped";
  EXPECT_EQ(shared->robot.load().cycle, 105U);
  EXPECT_EQ(shared->robot.load().frame, 2U);
  // a robot that restarted counts from one again, on a new connection
  link.disconnected();
  link.connected();
  EXPECT_TRUE(cycle(1, 0));
  EXPECT_EQ(shared->robot.load().cycle, 1U);
  EXPECT_EQ(link.counts().received, 7U);
  EXPECT_TRUE(link.counts().addsUp());
  EXPECT_EQ(shared->robot_link.load().received, 7U);
}

TEST_F(RobotLinkTest, AStateThatWaitedOnItsWayIsAsOldAsItIs) {
  constexpr std::int64_t kMs = 1'000'000;
  constexpr std::int64_t kRobotClock = 500'000 * kMs;  // independent of our clock
  link.connected();
  hello(true);
  RobotState robot;
  std::int64_t now = 0;
  const auto send = [&](std::int64_t delay) {
    ++robot.cycle;
    now += kMs;
    robot.time_ns = kRobotClock + now;
    return state(robot, now + delay);
  };
  for (int i = 0; i < 100; ++i)
    send(0);
  EXPECT_EQ(shared->robot.load().received_ns, now);
  send(30 * kMs);
  EXPECT_NEAR(static_cast<double>(shared->robot.load().received_ns), static_cast<double>(now), 1e3)
      << "the time of receipt does not count the 30 ms of waiting";
  const std::uint64_t cycle = robot.cycle;
  send(51 * kMs);
  send(4000 * kMs);
  EXPECT_EQ(rejected(Reject::kStale), 2U);
  EXPECT_EQ(shared->robot.load().cycle, cycle);
  EXPECT_TRUE(send(0)) << "the stream is still intact";
  EXPECT_EQ(shared->robot.load().cycle, cycle + 3);
  EXPECT_TRUE(link.counts().addsUp());
  EXPECT_EQ(link.counts().applied, 103U);  // the hello, 100 states, the one of 30 ms, the last one
}

TEST_F(RobotLinkTest, WhatWaitedIsKnownOnTheNextConnectionTooUnlessTheRobotStartedAnew) {
  link.connected();
  RobotState robot;
  robot.cycle = 10;
  robot.time_ns = 5'000'000'000;
  state(robot, 5'000'000'000);
  link.disconnected();
  link.connected();
  robot.cycle = 11;
  robot.time_ns += 1'000'000;
  state(robot, 5'061'000'000);
  EXPECT_EQ(rejected(Reject::kStale), 1U);
  robot.cycle = 1;  // started again: its clock is unknown
  state(robot, 5'062'000'000);
  EXPECT_EQ(rejected(Reject::kStale), 1U);
  EXPECT_EQ(shared->robot.load().received_ns, 5'062'000'000);
}

TEST_F(RobotLinkTest, ARobotWithoutAnAppliedStateForASecondIsSilent) {
  link.connected();
  constexpr std::int64_t kBegin = 7'000'000'000;
  EXPECT_FALSE(link.isSilent(kBegin)) << "the second begins with the connection";
  EXPECT_FALSE(link.isSilent(kBegin + RobotLink::kSilenceNs - 1));
  EXPECT_TRUE(link.isSilent(kBegin + RobotLink::kSilenceNs));
  RobotState robot;
  robot.cycle = 1;
  robot.time_ns = 1;
  state(robot, kBegin + 900'000'000);
  EXPECT_FALSE(link.isSilent(kBegin + 1'899'999'999));
  robot.arms[0].q[0] = std::nan("");  // frames that cannot be applied are no sign of life
  robot.cycle = 2;
  state(robot, kBegin + 1'800'000'000);
  EXPECT_TRUE(link.isSilent(kBegin + 1'900'000'000));
  link.disconnected();
  link.connected();
  EXPECT_FALSE(link.isSilent(kBegin + 9'000'000'000)) << "a new connection begins a new second";
}

TEST_F(RobotLinkTest, SendsTheFaultPlanAgainWhenAskedTo) {
  FaultDirector director(config, shared.get());
  link.connected();
  hello(true);
  const std::size_t size = link.pendingFrame(buffer.data());
  ASSERT_GT(size, 0U);
  link.resendPlan();
  EXPECT_EQ(link.pendingFrame(buffer.data()), size);
  EXPECT_EQ(link.pendingFrame(buffer.data()), 0U);
}

TEST_F(RobotLinkTest, EveryBadStateIsCountedByItsReasonAndTheLastGoodOneStays) {
  link.connected();
  hello(true);
  cycle(7, 0);
  RobotState bad;
  bad.cycle = 8;
  bad.arms[0].q[0] = std::nan("");
  EXPECT_TRUE(state(bad, 9));
  EXPECT_EQ(rejected(Reject::kNotFinite), 1U);
  bad.arms[0].q[0] = 2e4;
  EXPECT_TRUE(state(bad, 9));
  EXPECT_EQ(rejected(Reject::kOutOfRange), 1U);
  EXPECT_EQ(shared->robot.load().cycle, 7U);
  EXPECT_EQ(shared->robot.load().received_ns, 1) << "a bad frame does not make the state fresh";
  EXPECT_TRUE(link.counts().addsUp());
}

TEST_F(RobotLinkTest, AnotherMajorVersionIsRefusedAndTold) {
  link.connected();
  const std::size_t size = wire::encodeHello(1, true, buffer.data());
  buffer[5] = 9;
  EXPECT_FALSE(link.receive(buffer.data(), size, 1));
  EXPECT_EQ(rejected(Reject::kBadVersion), 1U);
  EXPECT_EQ(shared->robot_version_refused.load(), 9U << 8U | wire::kFrameMinor);
  link.disconnected();
  link.connected();
  hello(true);
  EXPECT_EQ(shared->robot_version_refused.load(), 0U) << "a robot of our version connected";
}

TEST_F(RobotLinkTest, ABrokenStreamIsGivenUp) {
  link.connected();
  std::array<std::uint8_t, 64> junk{};
  junk.fill(0x5a);
  EXPECT_FALSE(link.receive(junk.data(), junk.size(), 1));
  EXPECT_TRUE(link.counts().addsUp());
}

TEST_F(RobotLinkTest, SendsTheFaultPlanOnceAndAgainToANewRobot) {
  FaultDirector director(config, shared.get());
  link.connected();
  EXPECT_EQ(link.pendingFrame(buffer.data()), 0U) << "nothing is sent before the hello";
  hello(true);
  EXPECT_GT(link.pendingFrame(buffer.data()), 0U);
  EXPECT_EQ(link.pendingFrame(buffer.data()), 0U);
  link.disconnected();
  link.connected();
  hello(true);
  EXPECT_GT(link.pendingFrame(buffer.data()), 0U);
}

TEST_F(RobotLinkTest, HandsOnWhatTheRobotSaysOfItsFaultsAndCountsWhatIsMissing) {
  link.connected();
  hello(true);
  const auto tell = [&](std::uint64_t number) {
    FaultChange change;
    change.number = number;
    change.cycle = 100 * number;
    change.acts = 1;
    ASSERT_TRUE(link.receive(buffer.data(), wire::encodeFaultChange(3, change, buffer.data()), 5));
  };
  for (const std::uint64_t number : {7, 8, 8, 12})
    tell(number);
  std::vector<std::uint64_t> cycles;
  FaultChange change;
  while (shared->fault_changes.tryPop(&change))
    cycles.push_back(change.cycle);
  EXPECT_EQ(cycles, (std::vector<std::uint64_t>{700, 800, 1200}));
  EXPECT_EQ(shared->fault_changes_lost.value(), 3U);
  EXPECT_EQ(rejected(Reject::kOutOfOrder), 1U);
  link.connected();  // a new connection, perhaps a new robot: no change counts as lost
  tell(30);
  EXPECT_EQ(shared->fault_changes_lost.value(), 3U);
  EXPECT_TRUE(link.counts().addsUp());
}

TEST_F(RobotLinkTest, PassesOverWhatTheRobotSaysOfAnothersFaults) {
  link.connected();
  hello(true);
  for (std::uint64_t number = 1; number <= 2; ++number) {
    FaultChange change;
    change.number = number;
    change.session = number == 1 ? 55 : 0;  // this link's session is 0
    link.receive(buffer.data(), wire::encodeFaultChange(3, change, buffer.data()), 5);
  }
  FaultChange change;
  ASSERT_TRUE(shared->fault_changes.tryPop(&change));
  EXPECT_EQ(change.number, 2U);
  EXPECT_FALSE(shared->fault_changes.tryPop(&change));
  EXPECT_EQ(shared->fault_changes_lost.value(), 0U);
}

TEST_F(RobotLinkTest, AHelloBehindAnyOtherFrameIsNone) {
  for (int first = 0; first < 2; ++first) {
    link.connected();
    const std::size_t size = first == 0 ? wire::encodeFaultChange(1, FaultChange{1, 0, 0, 0}, buffer.data())
                                        : wire::encodePlanAnswer(1, true, buffer.data());
    link.receive(buffer.data(), size, 5);
    hello(true);
    state(RobotState{}, 1);
    EXPECT_EQ(shared->robot.load().is_virtual, 0);
  }
}

TEST_F(RobotLinkTest, ASignalThatIsNoNumberIsSentOnce) {
  FaultDirector director(config, shared.get());
  ModelState model;
  model.faults.signals.tissue_distance = std::numeric_limits<double>::quiet_NaN();
  shared->model.store(model);
  link.connected();
  hello(true);
  int frames = 0;
  while (frames < 10 && link.pendingFrame(buffer.data()) > 0)
    ++frames;
  EXPECT_EQ(frames, 2) << "one frame of signals and one of the plan";
}

TEST_F(RobotLinkTest, KnowsWhetherItsPlanIsRefused) {
  link.connected();
  hello(true);
  for (const bool is_armed : {false, true, false}) {
    link.receive(buffer.data(), wire::encodePlanAnswer(3, is_armed, buffer.data()), 5);
    EXPECT_EQ(shared->plan_refused.load(), is_armed ? 0 : 1);
  }
  link.disconnected();
  EXPECT_EQ(shared->plan_refused.load(), 0) << "no robot is left to refuse the plan";
}

TEST_F(RobotLinkTest, SignalsGoAheadOfThePlanAndAgainOnANewConnection) {
  FaultDirector director(config, shared.get());
  ASSERT_GT(shared->faults.load().count, 0U);
  ModelState model;
  model.faults.signals.step = 4;
  shared->model.store(model);
  for (int connection = 0; connection < 2; ++connection) {
    link.connected();
    hello(true);
    state(RobotState{}, 1);
    std::vector<int> types;
    while (const std::size_t size = link.pendingFrame(buffer.data())) {
      ASSERT_GT(size, 8U);
      types.push_back(buffer[6]);
    }
    EXPECT_EQ(types, (std::vector<int>{4, 3}));
  }
}

TEST_F(RobotLinkTest, StartAndStopOfAHazardChangeThePlan) {
  config.hazard = "none";
  FaultDirector director(config, shared.get());
  EXPECT_EQ(shared->faults.load().count, 0U);
  shared->fault_requests.tryPush({FaultOrder::kArm, 1});
  director.tick();
  ASSERT_EQ(shared->faults.load().count, 1U);
  EXPECT_EQ(shared->faults.load().faults[0].id, 1U);
  const std::uint64_t armed = shared->faults.load().generation;
  shared->fault_requests.tryPush({FaultOrder::kClear, 0});
  director.tick();
  EXPECT_EQ(shared->faults.load().count, 0U);
  EXPECT_GT(shared->faults.load().generation, armed);
}

}  // namespace
}  // namespace raven2_trainer::loop
