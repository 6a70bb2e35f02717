#include "raven2_trainer/runtime/robot_link.h"

#include <gtest/gtest.h>

#include <array>

#include "raven2_trainer/kinematics/arm_kinematics.h"
#include "raven2_trainer/runtime/fault_director.h"
#include "support/rig.h"

namespace raven2_trainer::runtime {
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

TEST_F(RobotLinkTest, WhateverDoesNotSayVirtualIsReal) {
  link.connected();
  hello(false);
  state(RobotState{}, 1);
  EXPECT_EQ(shared->robot.load().is_virtual, 0);
  FaultDirector director(config, shared.get());
  EXPECT_GT(shared->faults.load().count, 0U);
  EXPECT_EQ(link.pendingFrame(buffer.data()), 0U) << "no fault ever goes to a real robot";
}

TEST_F(RobotLinkTest, AStateBeforeTheHelloIsCountedAndNotUsed) {
  link.connected();
  EXPECT_TRUE(state(RobotState{}, 1));
  EXPECT_EQ(shared->robot.load().frame, 0U);
  EXPECT_EQ(link.counts().rejectedTotal(), 1U);
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
  EXPECT_EQ(link.pendingFrame(buffer.data()), 0U) << "nothing before the hello";
  hello(true);
  EXPECT_GT(link.pendingFrame(buffer.data()), 0U);
  EXPECT_EQ(link.pendingFrame(buffer.data()), 0U);
  link.disconnected();
  link.connected();
  hello(true);
  EXPECT_GT(link.pendingFrame(buffer.data()), 0U);
}

TEST_F(RobotLinkTest, StartAndStopOfAHazardChangeThePlan) {
  config.hazard = "none";
  FaultDirector director(config, shared.get());
  EXPECT_EQ(shared->faults.load().count, 0U);
  shared->fault_requests.tryPush({1, 1});
  director.tick();
  ASSERT_EQ(shared->faults.load().count, 1U);
  EXPECT_EQ(shared->faults.load().faults[0].id, 1U);
  const std::uint64_t armed = shared->faults.load().generation;
  shared->fault_requests.tryPush({0, 0});
  director.tick();
  EXPECT_EQ(shared->faults.load().count, 0U);
  EXPECT_GT(shared->faults.load().generation, armed);
}

}  // namespace
}  // namespace raven2_trainer::runtime
