#include "raven2_trainer/loop/relay_channel.h"

#include <gtest/gtest.h>

#include <vector>

#include "support/rig.h"

namespace raven2_trainer::loop {
namespace {

constexpr std::int64_t kMillisecond = 1'000'000;

class RelayChannelTest : public ::testing::Test {
 protected:
  /** Passes one packet a millisecond; packet n moves n micrometres. @param[in] impairment 0: none, else preset + 1. */
  void pass(int count, std::uint32_t impairment) {
    for (int i = 0; i < count; ++i) {
      RelayPacket packet;
      packet.impairment = impairment;
      packet.command.sequence = ++passed;
      packet.command.dp_I[0][0] = 1e-6 * passed;
      now_ns += kMillisecond;
      channel.pass(packet, now_ns, [this](const wire::ItpPacket& sent) { came.push_back(sent); });
    }
  }

  /** Whether passed + added = came + lost + held. */
  bool addsUp() const {
    const FaultedPackets c = channel.counts();
    return passed + c.added == came.size() + c.lost + c.held;
  }

  std::uint32_t impair(Impairment impairment) {
    config.impairments.push_back(impairment);
    return static_cast<std::uint32_t>(config.impairments.size());
  }

  TrainerConfig config{raven2_trainer::testing::packagedConfig()};
  RelayChannel channel{config};
  std::vector<wire::ItpPacket> came;
  std::uint32_t passed{0};
  std::int64_t now_ns{0};
};

TEST_F(RelayChannelTest, IsAStraightWayWithoutAnImpairment) {
  pass(100, 0);
  ASSERT_EQ(came.size(), 100U);
  for (std::uint32_t i = 0; i < 100; ++i) {
    EXPECT_EQ(came[i].sequence, i + 1);
    EXPECT_EQ(came[i].delx_um[0], static_cast<std::int32_t>(i + 1));
  }
  EXPECT_TRUE(addsUp());
}

TEST_F(RelayChannelTest, AccountsForEveryPacketWhateverHappensOnTheWay) {
  Impairment bad;
  bad.duplicate = 0.2;
  bad.truncate = 0.1;
  bad.delay.constant_ns = 30 * kMillisecond;
  const std::uint32_t first = impair(bad), second = impair(bad);
  pass(1000, first);
  EXPECT_TRUE(addsUp());
  const FaultedPackets during = channel.counts();
  EXPECT_NEAR(static_cast<double>(during.added), 200.0, 60.0);
  EXPECT_NEAR(static_cast<double>(during.lost), 120.0, 40.0)
      << "a tenth of all packets is truncated, also of the copies";
  EXPECT_GE(during.held, 29U);
  pass(1, second);
  EXPECT_TRUE(addsUp()) << "the packets that the first impairment still held are lost";
  EXPECT_GE(channel.counts().lost, during.lost + 28);
  pass(100, 0);
  EXPECT_EQ(channel.counts().held, 0U);
  EXPECT_TRUE(addsUp());
}

TEST_F(RelayChannelTest, LetsNothingOfABadNetworkComeBehindAPacketThatIsHeldClean) {
  Impairment slow;
  slow.delay.constant_ns = 400 * kMillisecond;
  pass(100, impair(slow));
  EXPECT_TRUE(came.empty());
  RelayPacket clean;
  clean.command.sequence = ++passed;
  clean.is_held = 1;
  for (int i = 0; i < 500; ++i) {
    now_ns += kMillisecond;
    const auto take = [this](const wire::ItpPacket& sent) { came.push_back(sent); };
    if (i == 0) channel.pass(clean, now_ns, take);
    channel.flush(now_ns, take);
  }
  ASSERT_EQ(came.size(), 1U);
  EXPECT_EQ(came[0].sequence, 101U);
  EXPECT_EQ(channel.counts().lost, 100U);
  EXPECT_TRUE(addsUp());
}

}  // namespace
}  // namespace raven2_trainer::loop
