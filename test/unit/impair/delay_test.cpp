#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "raven2_trainer/impair/delay_model.h"
#include "unit/impair/channel_support.h"

namespace raven2_trainer::impair {
namespace {

using testing::kMillisecond;
using testing::Outcome;
using testing::send;

constexpr int kPackets = 100000;

bool isInOrder(const Outcome& outcome) {
  return std::is_sorted(outcome.out.begin(), outcome.out.end(),
                        [](const Delivery& a, const Delivery& b) { return a.fate.number < b.fate.number; });
}

double deviation(const Outcome& outcome) {
  const double mean = outcome.meanDelay();
  double sum = 0.0;
  for (const Delivery& packet : outcome.out)
    sum += std::pow(static_cast<double>(packet.due_ns - packet.in_ns) - mean, 2);
  return std::sqrt(sum / static_cast<double>(outcome.out.size()));
}

Impairment overtaking(const DelayLaw& law) {
  Impairment impairment;
  impairment.delay = law;
  impairment.delay.overtaking = true;
  return impairment;
}

TEST(DelayTest, AConstantDelayIsThatToTheNanosecond) {
  Impairment impairment;
  impairment.delay.constant_ns = 12'345'678;
  for (const Delivery& packet : send(impairment, 1000).out)
    ASSERT_EQ(packet.due_ns - packet.in_ns, 12'345'678);
}

TEST(DelayTest, EveryLawHasItsMeanAndDeviation) {
  DelayLaw uniform;
  uniform.constant_ns = 20 * kMillisecond;
  uniform.uniform_ns = 6 * kMillisecond;
  Outcome outcome = send(overtaking(uniform), kPackets);
  EXPECT_NEAR(outcome.meanDelay(), 20e6, 0.06e6);
  EXPECT_NEAR(deviation(outcome), 6e6 / std::sqrt(3.0), 0.03e6);

  DelayLaw normal;
  normal.constant_ns = 50 * kMillisecond;
  normal.normal_ns = 4 * kMillisecond;
  outcome = send(overtaking(normal), kPackets);
  EXPECT_NEAR(outcome.meanDelay(), 50e6, 0.07e6);
  EXPECT_NEAR(deviation(outcome), 4e6, 0.05e6);

  DelayLaw pareto;  // Lomax: mean s / (a - 1), variance s^2 a / ((a - 1)^2 (a - 2))
  pareto.pareto_alpha = 5.0;
  pareto.pareto_scale_ns = 8 * kMillisecond;
  outcome = send(overtaking(pareto), kPackets);
  EXPECT_NEAR(outcome.meanDelay(), 2e6, 0.05e6);
  EXPECT_NEAR(deviation(outcome), 8e6 * std::sqrt(5.0 / (16.0 * 3.0)), 0.2e6);

  DelayLaw branches;  // mean sum(w m), second moment sum(2 w m^2)
  branches.branches = {{0.7, 10e6}, {0.3, 40e6}};
  outcome = send(overtaking(branches), kPackets);
  EXPECT_NEAR(outcome.meanDelay(), 19e6, 0.5e6);
  EXPECT_NEAR(deviation(outcome), std::sqrt(2.0 * (0.7 * 100.0 + 0.3 * 1600.0) - 361.0) * 1e6, 0.9e6);
  branches.branches = {{0.5, 10e6}, {0.3, 40e6}, {0.2, 100e6}};
  EXPECT_NEAR(send(overtaking(branches), kPackets).meanDelay(), 37e6, 1e6);
}

TEST(DelayTest, WithoutOvertakingPacketsKeepTheirOrderHoweverTheDelayJumps) {
  Impairment impairment;
  impairment.delay.constant_ns = 30 * kMillisecond;
  impairment.delay.normal_ns = 10 * kMillisecond;
  EXPECT_TRUE(isInOrder(send(impairment, 20000)));
  impairment.delay.overtaking = true;
  EXPECT_FALSE(isInOrder(send(impairment, 20000)));
}

TEST(DelayTest, ADrawHoldsForItsInterval) {
  DelayLaw law;
  law.uniform_ns = 10 * kMillisecond;
  law.constant_ns = 10 * kMillisecond;
  law.interval_ns = 100 * kMillisecond;
  const Outcome outcome = send(overtaking(law), 1000);
  std::vector<std::int64_t> delays(1000);
  for (const Delivery& packet : outcome.out)
    delays[packet.fate.number] = packet.due_ns - packet.in_ns;
  for (std::size_t i = 0; i < 1000; ++i)
    EXPECT_EQ(delays[i], delays[i - i % 100]) << i;
  EXPECT_EQ(std::unique(delays.begin(), delays.end()) - delays.begin(), 10);
}

TEST(DelayTest, ADrawHoldsForItsIntervalFromWheneverItWasDrawn) {
  DelayLaw law;
  law.constant_ns = law.uniform_ns = 10 * kMillisecond;
  law.interval_ns = 100 * kMillisecond;
  for (const std::int64_t start :
       {std::int64_t{0}, 5'000'000 * kMillisecond}) {  // a computer that is up for 83 minutes
    DelayModel model(law, 1, 0);
    const std::int64_t first = model.next(start);
    EXPECT_EQ(model.next(start + 99 * kMillisecond), first);
    const std::int64_t after_a_pause = model.next(start + 1000 * kMillisecond);
    EXPECT_NE(after_a_pause, first);
    EXPECT_EQ(model.next(start + 1099 * kMillisecond), after_a_pause);
    EXPECT_NE(model.next(start + 1100 * kMillisecond), after_a_pause);
  }
}

TEST(DelayTest, ABottleneckSpacesPacketsAndDropsThoseThatWouldWaitTooLong) {
  Impairment impairment;
  // 124 + 28 bytes = 1216 bits; at 608 kbit/s one takes 2 ms, and one comes every millisecond.
  impairment.rate = {608e3, 20 * kMillisecond};
  const Outcome outcome = send(impairment, 2000);
  for (std::size_t i = 1; i < outcome.out.size(); ++i)
    ASSERT_GE(outcome.out[i].due_ns - outcome.out[i - 1].due_ns, 2 * kMillisecond);
  EXPECT_NEAR(outcome.lostShare(), 0.5, 0.01);
  EXPECT_EQ(outcome.counts.dropped[static_cast<std::size_t>(Loss::kQueueFull)], outcome.lost());
  for (const Delivery& packet : outcome.out)
    ASSERT_LE(packet.due_ns - packet.in_ns, 22 * kMillisecond);
}

TEST(DelayTest, AReorderedPacketIsOvertakenByNoMoreThanTheDepth) {
  Impairment impairment;
  impairment.reordering = {0.05, 3, 100 * kMillisecond};
  const Outcome outcome = send(impairment, 20000);
  EXPECT_EQ(outcome.out.size(), 20000U);
  std::vector<std::int64_t> place(20000);
  for (std::size_t i = 0; i < outcome.out.size(); ++i)
    place[outcome.out[i].fate.number] = static_cast<std::int64_t>(i);
  std::uint64_t reordered = 0;
  std::array<int, 4> overtaken_by{};
  for (std::size_t i = 0; i < 20000; ++i) {
    if (!outcome.fates[i].is_reordered) continue;
    ++reordered;
    int overtakers = 0;
    for (std::size_t later = i + 1; later < std::min<std::size_t>(i + 10, 20000); ++later)
      overtakers += place[later] < place[i] && !outcome.fates[later].is_reordered ? 1 : 0;
    if (i + 10 < 20000) {
      ASSERT_GE(overtakers, 1) << i;
      ASSERT_LE(overtakers, 3) << i;
      ++overtaken_by[static_cast<std::size_t>(overtakers)];
    }
  }
  EXPECT_EQ(outcome.counts.reordered, reordered);
  EXPECT_NEAR(static_cast<double>(reordered), 1000.0, 160.0);
  for (const int by : {1, 2, 3})
    EXPECT_GT(overtaken_by[static_cast<std::size_t>(by)], 200) << by;
}

TEST(DelayTest, AReorderedPacketIsLetGoIfNoneComesToOvertakeIt) {
  Impairment impairment;
  impairment.reordering = {1.0, 1, 40 * kMillisecond};
  Channel channel(impairment, 1, 0, 0);
  const std::uint8_t byte = 1;
  channel.offer(&byte, 1, 5 * kMillisecond);
  EXPECT_EQ(channel.nextDue(), 45 * kMillisecond);
  EXPECT_FALSE(channel.take(45 * kMillisecond - 1));
  EXPECT_TRUE(channel.take(45 * kMillisecond));
  EXPECT_FALSE(channel.nextDue());
}

TEST(DelayTest, JitterBelowZeroIsNoDelayAndNeverATimeBeforeTheOffer) {
  for (const bool is_normal : {false, true}) {
    DelayLaw law;
    law.constant_ns = kMillisecond;
    (is_normal ? law.normal_ns : law.uniform_ns) = 10 * kMillisecond;
    int at_once = 0, late = 0;
    for (const Delivery& packet : send(overtaking(law), 2000).out) {
      ASSERT_GE(packet.due_ns, packet.in_ns);
      at_once += packet.due_ns == packet.in_ns ? 1 : 0;
      late += packet.due_ns - packet.in_ns > 5 * kMillisecond ? 1 : 0;
    }
    // uniform in [-9, 11] ms, 45 % of it; normal about 1 ms with 10 ms, Phi(-0.1) = 46 %
    EXPECT_NEAR(at_once, 910, 130);
    EXPECT_GT(late, 400);
  }
}

TEST(DelayTest, OfAllPacketsThatWaitTheEarliestIsDueNext) {
  // GIVEN three packets that nobody overtakes, let go 40 ms after each was sent, and a fourth under way for 60 ms
  Impairment impairment;
  impairment.reordering = {1.0, 1, 40 * kMillisecond};
  Channel channel(impairment, 1, 0, 0);
  const std::uint8_t byte = 1;
  for (const std::int64_t ms : {5, 10, 20})
    channel.offer(&byte, 1, ms * kMillisecond);
  for (const std::int64_t ms : {45, 50, 60}) {
    ASSERT_EQ(channel.nextDue(), ms * kMillisecond);
    const auto packet = channel.take(ms * kMillisecond);
    ASSERT_TRUE(packet);
    EXPECT_EQ(packet->due_ns, ms * kMillisecond);
  }
  EXPECT_FALSE(channel.nextDue());
}

TEST(DelayTest, AReorderedPacketComesRightBehindItsLastOvertakerAndNotEarlier) {
  Impairment impairment;
  impairment.delay.constant_ns = 30 * kMillisecond;
  impairment.reordering = {0.3, 1, 500 * kMillisecond};
  const Outcome outcome = send(impairment, 2000);
  int followed = 0;
  for (std::size_t i = 1; i < outcome.out.size(); ++i) {
    const Delivery& packet = outcome.out[i];
    if (!packet.fate.is_reordered || packet.fate.number + 50 > 2000) continue;
    std::uint64_t overtaker = packet.fate.number + 1;  // the next one that is not held back itself
    while (outcome.fates[overtaker].is_reordered)
      ++overtaker;
    ASSERT_EQ(packet.due_ns, static_cast<std::int64_t>(overtaker) * kMillisecond + 30 * kMillisecond);
    ++followed;
  }
  EXPECT_GT(followed, 400);
}

}  // namespace
}  // namespace raven2_trainer::impair
