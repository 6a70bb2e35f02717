// Compares the packets that the daemon accepts from a bad link with a second implementation of the rule in doc/wire.md.
// A packet counts if it is newer than every packet that counted before, and at most 64 ahead of the newest.

#include <gtest/gtest.h>

#include <cstring>
#include <memory>
#include <tuple>
#include <vector>

#include "raven2_trainer/core/random.h"
#include "raven2_trainer/impair/channel.h"
#include "raven2_trainer/loop/master_ingest.h"
#include "raven2_trainer/wire/itp.h"
#include "support/effort.h"

namespace raven2_trainer::loop {
namespace {

constexpr std::int64_t kMillisecond = 1'000'000;
constexpr std::int64_t kWindow = 64;

wire::ItpBytes packet(std::uint32_t sequence, Random* random) {
  wire::ItpPacket p;
  p.sequence = sequence;
  p.surgeon_mode = 1;
  for (std::size_t arm = 0; arm < 2; ++arm) {
    p.delx_um[arm] = static_cast<std::int32_t>(random->uniform(-500.0, 500.0));
    p.dely_um[arm] = static_cast<std::int32_t>(random->uniform(-500.0, 500.0));
    p.delz_um[arm] = static_cast<std::int32_t>(random->uniform(-500.0, 500.0));
  }
  p.checksum = wire::itpChecksum(p);
  return wire::encodeItp(p);
}

/** One combination: each kind of impairment is on or off. */
using Cell = std::tuple<bool, bool, bool, bool>;

class ImpairedIngest : public ::testing::TestWithParam<Cell> {
 protected:
  Impairment impairment() const {
    const auto [delay, jitter, reorder, duplicate] = GetParam();
    Impairment c;
    if (delay) c.delay.constant_ns = 40 * kMillisecond;
    if (jitter) {
      c.delay.constant_ns += 5 * kMillisecond;
      c.delay.uniform_ns = 5 * kMillisecond;
      c.delay.overtaking = true;
    }
    if (reorder) c.reordering = {0.05, 3, 100 * kMillisecond};
    if (duplicate) c.duplicate = 0.1;
    return c;
  }
};

TEST_P(ImpairedIngest, AppliesEveryAcceptedPacketOnceAndNoOther) {
  const auto packets = static_cast<std::uint32_t>(raven2_trainer::testing::effort(3000, 20000));
  const auto shared = std::make_unique<SharedState>();
  ItpRules rules;
  rules.max_increment_um = 5000;
  rules.max_rotation = 0.1;
  rules.max_rate = 1e6;
  rules.max_burst = 10000;
  rules.master_timeout = 0.2;
  MasterIngest ingest(rules, nullptr, shared.get());
  MasterCommand command;
  const wire::ItpBytes first =
      wire::encodeItp(wire::ItpPacket{});  // number 0, pedal up: the master is known from now on
  ASSERT_EQ(ingest.receive({first.data(), first.size(), 1, 0}), Reject::kNone);
  ASSERT_TRUE(shared->master_commands.tryPop(&command));
  impair::Channel channel(impairment(), 5, 0, 0);
  Random random(9);
  std::vector<std::uint32_t> arrivals, applied;
  double sum = 0.0, expected_sum = 0.0;
  std::vector<double> sent(packets + 1);
  std::int64_t now = 0;
  const auto deliver = [&] {
    while (const auto out = channel.take(now)) {
      wire::ItpPacket arrived;
      ASSERT_EQ(wire::decodeItp(out->bytes.data(), out->bytes.size(), &arrived), Reject::kNone);
      arrivals.push_back(arrived.sequence);
      ingest.receive({out->bytes.data(), out->bytes.size(), 1, now});
    }
    while (shared->master_commands.tryPop(&command)) {
      applied.push_back(command.sequence);
      for (const Vec3& dp : command.dp_I)
        sum += dp[0] + dp[1] + dp[2];
    }
  };
  for (std::uint32_t sequence = 1; sequence <= packets; ++sequence, now += kMillisecond) {
    const wire::ItpBytes bytes = packet(sequence, &random);
    channel.offer(bytes.data(), bytes.size(), now);
    deliver();
  }
  for (; channel.nextDue(); now += kMillisecond)
    deliver();

  // The second implementation of the rule, in the order of arrival.
  Random again(9);
  std::vector<wire::ItpBytes> all;
  for (std::uint32_t sequence = 1; sequence <= packets; ++sequence)
    all.push_back(packet(sequence, &again));
  std::vector<std::uint32_t> accepted;
  for (const std::uint32_t sequence : arrivals) {
    const std::int64_t ahead = accepted.empty() ? 1 : std::int64_t{sequence} - std::int64_t{accepted.back()};
    if (ahead >= 1 && ahead <= kWindow) accepted.push_back(sequence);
  }
  for (const std::uint32_t sequence : accepted) {
    for (const std::size_t arm : {0U, 1U}) {
      double three = 0.0;
      for (const std::size_t offset : {12U, 20U, 28U}) {  // delx, dely, delz (doc/wire.md)
        std::int32_t um = 0;
        std::memcpy(&um, all[sequence - 1].data() + offset + 4 * arm, sizeof(um));
        three = offset == 12U ? um / 1e6 : three + um / 1e6;
      }
      expected_sum += three;
    }
  }
  EXPECT_EQ(applied, accepted);
  EXPECT_EQ(sum, expected_sum) << "the sums agree bit by bit";
  EXPECT_EQ(ingest.counts().received, 1 + arrivals.size());
  EXPECT_EQ(ingest.counts().applied, 1 + accepted.size());
  EXPECT_TRUE(ingest.counts().addsUp());
  const auto [delay, jitter, reorder, duplicate] = GetParam();
  EXPECT_EQ(arrivals.size() > packets, duplicate);
  EXPECT_EQ(accepted.size() < packets, jitter || reorder);
}

INSTANTIATE_TEST_SUITE_P(
    DelayJitterReorderDuplicate,
    ImpairedIngest,
    ::testing::Combine(::testing::Bool(), ::testing::Bool(), ::testing::Bool(), ::testing::Bool()));

}  // namespace
}  // namespace raven2_trainer::loop
