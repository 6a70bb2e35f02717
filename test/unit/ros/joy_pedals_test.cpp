#include "ros/devices/joy_pedals.h"

#include <gtest/gtest.h>

#include <vector>

#include "fake_loop.h"
#include "raven2_trainer/config/load_config.h"

namespace raven2_trainer::ros_bridge {
namespace {

constexpr std::int64_t kMillisecond = 1000000;

sensor_msgs::Joy joyOf(const std::vector<int>& buttons) {
  sensor_msgs::Joy joy;
  joy.buttons = buttons;
  return joy;
}

/** Three buttons are used: 0 the stop, 1 the trial, 4 the camera; the other buttons have no function. */
JoyConfig mapping() {
  JoyConfig config;
  config.topic = "pedals";
  config.timeout = 0.5;
  config.buttons.fill(-1);
  config.buttons[static_cast<std::size_t>(Pedal::kCamera)] = 4;
  config.buttons[static_cast<std::size_t>(Pedal::kTrial)] = 1;
  config.buttons[static_cast<std::size_t>(Pedal::kStop)] = 0;
  return config;
}

class JoyPedalsTest : public ::testing::Test {
 protected:
  JoyPedalsTest() { loop.tell(); }

  /** @return the requests of a message that comes one millisecond after the one before. */
  std::vector<Request> hear(const std::vector<int>& buttons) {
    now_ns += kMillisecond;
    pedals.hear(joyOf(buttons), now_ns);
    return asked();
  }

  std::vector<Request> asked() {
    loop.seen.clear();
    loop.tick();
    return loop.seen;
  }

  FakeLoop loop;
  PlanningClient client{&loop.shared, [] {}};
  JoyPedals pedals{mapping(), loop.shared, &client, true};
  std::int64_t now_ns{10 * kMillisecond};
};

TEST(HeldPedals, ThePackagedMappingIsTheOrderOfThePacket) {
  const JoyConfig packaged = config::loadTrainerConfig(RAVEN2_TRAINER_SOURCE_DIR "/config/trainer.yaml").network.joy;
  EXPECT_FALSE(packaged.topic.empty());
  for (std::size_t i = 0; i < kPedalCount; ++i) {
    std::vector<int> buttons(kPedalCount, 0);
    buttons[i] = 1;
    EXPECT_EQ(heldPedals(joyOf(buttons), packaged), 1U << i) << kPedalNames[i];
  }
}

TEST(HeldPedals, ButtonsThatAreNotThereAreUpAndOthersAreNobodys) {
  EXPECT_EQ(heldPedals(joyOf({}), mapping()), 0U);
  EXPECT_EQ(heldPedals(joyOf({0, 1}), mapping()), bit(Pedal::kTrial));
  EXPECT_EQ(heldPedals(joyOf({0, 0, 1, 1}), mapping()), 0U);
  EXPECT_EQ(heldPedals(joyOf({1, 1, 1, 1, 1, 1}), mapping()),
            bit(Pedal::kTrial) | bit(Pedal::kCamera) | bit(Pedal::kStop));
  EXPECT_EQ(heldPedals(joyOf({0, -1}), mapping()), bit(Pedal::kTrial)) << "any value but 0 is a held button";
}

TEST_F(JoyPedalsTest, AnEdgeAsksOnceForWhatThePacketsPedalAsksFor) {
  EXPECT_TRUE(hear({0, 0, 0, 0, 0}).empty());
  const std::vector<Request> begun = hear({0, 1});
  ASSERT_EQ(begun.size(), 1U);
  EXPECT_EQ(begun[0].kind, RequestKind::kBeginTrial);
  EXPECT_EQ(begun[0].id, 0U) << "no client waits for an answer";
  EXPECT_TRUE(hear({0, 1}).empty());
  EXPECT_TRUE(hear({0, 0}).empty());
  loop.mode = Mode::kTrialHeld;
  loop.tell();
  const std::vector<Request> ended = hear({0, 1});
  ASSERT_EQ(ended.size(), 1U);
  EXPECT_EQ(ended[0].kind, RequestKind::kEndTrial);
}

TEST_F(JoyPedalsTest, SilenceLetsTheCameraGo) {
  const std::vector<Request> pressed = hear({0, 0, 0, 0, 1});
  ASSERT_EQ(pressed.size(), 1U);
  EXPECT_EQ(pressed[0].kind, RequestKind::kSetCameraPedal);
  EXPECT_EQ(pressed[0].enabled, 1);
  pedals.idle(now_ns + 499 * kMillisecond);
  EXPECT_TRUE(asked().empty());
  pedals.idle(now_ns + 501 * kMillisecond);
  const std::vector<Request> released = asked();
  ASSERT_EQ(released.size(), 1U);
  EXPECT_EQ(released[0].kind, RequestKind::kSetCameraPedal);
  EXPECT_EQ(released[0].enabled, static_cast<std::uint8_t>(CameraPedal::kSilent));
  now_ns += 600 * kMillisecond;
  EXPECT_EQ(hear({0, 0, 0, 0, 1}).size(), 1U) << "a source that comes back with the button held presses it";
}

TEST_F(JoyPedalsTest, BeforeAnybodySpokeNothingIsAskedFor) {
  pedals.idle(now_ns);
  pedals.idle(now_ns + 10000 * kMillisecond);
  EXPECT_TRUE(asked().empty());
}

TEST_F(JoyPedalsTest, ANetworkIsHeardToStopAndNothingElse) {
  JoyPedals open(mapping(), loop.shared, &client, false);
  open.hear(joyOf({1, 1, 1, 1, 1}), now_ns);
  const std::vector<Request> requests = asked();
  ASSERT_EQ(requests.size(), 1U);
  EXPECT_EQ(requests[0].kind, RequestKind::kEmergencyStop);
}

/** Button 3 is the view here. The request of a press depends on the view that is shown. */
TEST_F(JoyPedalsTest, ThePedalOfTheViewGoesBothWays) {
  JoyConfig config = mapping();
  config.buttons[static_cast<std::size_t>(Pedal::kView)] = 3;
  JoyPedals both(config, loop.shared, &client, true);
  for (const std::uint8_t view : {0, 1, 0}) {
    loop.view = view;
    loop.tell();
    both.hear(joyOf({0, 0, 0, 0}), ++now_ns);
    both.hear(joyOf({0, 0, 0, 1}), ++now_ns);
    const std::vector<Request> requests = asked();
    ASSERT_EQ(requests.size(), 1U);
    EXPECT_EQ(requests[0].kind, RequestKind::kSetView);
    EXPECT_EQ(requests[0].enabled, view == 0 ? 1 : 0);
  }
}

}  // namespace
}  // namespace raven2_trainer::ros_bridge
