#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include "unit/impair/channel_support.h"

namespace raven2_trainer::impair {
namespace {

using testing::Outcome;
using testing::send;

constexpr int kPackets = 100000;

/** Five standard deviations of a share of independent events. */
double spread(double share, int n) {
  return 5.0 * std::sqrt(share * (1.0 - share) / n);
}

/** Lengths of the runs of lost packets. */
std::vector<int> lossRuns(const Outcome& outcome) {
  std::vector<int> runs;
  int length = 0;
  for (const Fate& fate : outcome.fates) {
    if (fate.loss != Loss::kNone) {
      ++length;
    } else if (length > 0) {
      runs.push_back(length);
      length = 0;
    }
  }
  return runs;
}

double mean(const std::vector<int>& values) {
  double sum = 0.0;
  for (const int v : values)
    sum += v;
  return sum / static_cast<double>(values.size());
}

TEST(LossTest, APerfectLinkPassesEveryPacketAtOnceInOrderAndUnchanged) {
  const Outcome outcome = send(Impairment{}, 1000);
  ASSERT_EQ(outcome.out.size(), 1000U);
  for (std::size_t i = 0; i < outcome.out.size(); ++i) {
    EXPECT_EQ(outcome.out[i].bytes, testing::numbered(i, 124));
    EXPECT_EQ(outcome.out[i].due_ns, outcome.out[i].in_ns);
  }
}

TEST(LossTest, IndependentLossHasItsShareAndNoMemory) {
  for (const double share : {0.01, 0.05, 0.3}) {
    Impairment impairment;
    impairment.loss = share;
    const Outcome outcome = send(impairment, kPackets);
    EXPECT_NEAR(outcome.lostShare(), share, spread(share, kPackets));
    // Without memory the runs are geometric: mean 1 / (1 - p).
    EXPECT_NEAR(mean(lossRuns(outcome)), 1.0 / (1.0 - share), 0.05) << share;
  }
}

TEST(LossTest, AGilbertElliottChainHasItsStationaryShareAndGeometricBursts) {
  Impairment impairment;
  impairment.gilbert_elliott = {0.01, 1.0 / 30.0, 0.0, 1.0};
  const Outcome outcome = send(impairment, 4 * kPackets);
  // p / (p + r), and 1 / r in the mean; some 3,000 bursts, so five deviations of their mean are 2.7.
  EXPECT_NEAR(outcome.lostShare(), 0.01 / (0.01 + 1.0 / 30.0), 0.02);
  EXPECT_NEAR(mean(lossRuns(outcome)), 30.0, 2.7);
  EXPECT_EQ(outcome.counts.dropped[static_cast<std::size_t>(Loss::kBurst)], outcome.lost());
}

TEST(LossTest, TheStatesOfAChainLoseTheirOwnShares) {
  Impairment impairment;
  impairment.gilbert_elliott = {0.1, 0.3, 0.02, 0.6};  // a quarter of the time bad
  EXPECT_NEAR(send(impairment, 4 * kPackets).lostShare(), 0.75 * 0.02 + 0.25 * 0.6, 0.01);
}

TEST(LossTest, AChainThatStaysGoodLosesItsShareAllTheSame) {
  Impairment impairment;
  impairment.gilbert_elliott = {0.0, 0.3, 0.1, 0.9};
  EXPECT_NEAR(send(impairment, kPackets).lostShare(), 0.1, 0.01);
}

TEST(LossTest, RunsLoseExactlySoManyInARow) {
  Impairment impairment;
  impairment.loss_runs = {0.001, 30};
  const std::vector<int> runs = lossRuns(send(impairment, kPackets));
  ASSERT_GT(runs.size(), 50U);
  for (const int run : runs)
    EXPECT_EQ(run % 30, 0) << "a run may begin right behind another";
}

/** P(floor(X) >= k) of a Pareto type II law. */
double tail(const ParetoTwo& law, int k) {
  return std::pow(1.0 + k / law.lambda, -law.alpha);
}

/**
 * Share of packets lost by Pareto bursts, from the definition alone. A cycle is a burst of b packets and the packet
 * that passes. The state at the draw of the next cycle is b + 1 steps of the chain later. The stationary state at the
 * draws is found by iteration, and the share is E[b] / (E[b] + 1).
 */
double expectedShare(const ParetoBursts& law) {
  constexpr int kLongest = 20000;
  const double memory = 1.0 - law.to_bad - law.to_good;  // second eigenvalue of the chain
  const double stationary = law.to_bad / (law.to_bad + law.to_good);
  double bad = stationary;
  double burst = 0.0;
  for (int round = 0; round < 60; ++round) {
    double next_bad = 0.0;
    burst = 0.0;
    for (const bool is_bad : {false, true}) {
      const ParetoTwo& x = is_bad ? law.bad : law.good;
      const double weight = is_bad ? bad : 1.0 - bad;
      double decay = memory;
      for (int b = 0; b < kLongest; ++b, decay *= memory) {
        const double p = tail(x, b) - tail(x, b + 1);
        next_bad += weight * p * (stationary + ((is_bad ? 1.0 : 0.0) - stationary) * decay);
        burst += weight * p * b;
      }
    }
    bad = next_bad;
  }
  return burst / (burst + 1.0);
}

TEST(LossTest, ParetoBurstsHaveTheShareThatTheirLawsGive) {
  Impairment impairment;
  impairment.pareto_bursts = {true, 0.05, 0.10, {4.604, 3.552}, {3.901, 1.466}};
  const double expected = expectedShare(impairment.pareto_bursts);
  EXPECT_NEAR(send(impairment, 4 * kPackets).lostShare(), expected, 0.01);
}

TEST(LossTest, ABurstOfParetoLengthIsFollowedByAPacketThatPasses) {
  Impairment impairment;
  impairment.pareto_bursts = {true, 0.0, 0.0, {4.0, 2.0}, {}};
  const Outcome outcome = send(impairment, kPackets);
  // Every passing packet ends a cycle, so the shares of cycles with at least k losses are the law's tail.
  int cycles = 0, at_least_three = 0, length = 0;
  for (const Fate& fate : outcome.fates) {
    if (fate.loss != Loss::kNone) {
      ++length;
      continue;
    }
    ++cycles;
    at_least_three += length >= 3 ? 1 : 0;
    length = 0;
  }
  const double expected = tail({4.0, 2.0}, 3);
  EXPECT_NEAR(static_cast<double>(at_least_three) / cycles, expected, spread(expected, cycles));
}

TEST(LossTest, AnotherModelSwitchedOnLeavesTheLossesOfTheFirstAsTheyWere) {
  Impairment plain;
  plain.loss = 0.1;
  Impairment rich = plain;
  rich.delay.constant_ns = 50 * testing::kMillisecond;
  rich.delay.normal_ns = 5 * testing::kMillisecond;
  rich.duplicate = 0.2;
  rich.corruption = {0.3, 4, false};
  const Outcome a = send(plain, 5000), b = send(rich, 5000);
  for (std::size_t i = 0; i < a.fates.size(); ++i)
    ASSERT_EQ(a.fates[i].loss, b.fates[i].loss) << i;
}

TEST(LossTest, RepeatedCutsTakeTheirShareOfTheTime) {
  Impairment impairment;
  impairment.cuts = {0, 0, 1'000 * testing::kMillisecond, 1'000 * testing::kMillisecond};
  Channel channel(impairment, 1, 0, 0);
  const Outcome outcome = send(&channel, 2 * kPackets, 10 * testing::kMillisecond);  // 2,000 s, some 1,330 cuts
  EXPECT_NEAR(outcome.lostShare(), 1.0 / 3.0, 0.03);
  EXPECT_EQ(outcome.counts.dropped[static_cast<std::size_t>(Loss::kCut)], outcome.lost());
}

/** For each of 600 packets, one a millisecond from a channel's start on: whether it is cut off. */
std::vector<bool> cutsFrom(const Impairment& impairment, std::int64_t start_ns) {
  Channel channel(impairment, 1, 0, start_ns);
  std::vector<bool> cut;
  const std::uint8_t byte = 1;
  for (std::int64_t i = 0; i < 600; ++i)
    cut.push_back(channel.offer(&byte, 1, start_ns + i * testing::kMillisecond).loss == Loss::kCut);
  return cut;
}

TEST(LossTest, OutagesAreCountedFromTheStartOfTheChannel) {
  Impairment scripted, repeated;
  scripted.outages = {{100 * testing::kMillisecond, 200 * testing::kMillisecond}};
  repeated.cuts = {50 * testing::kMillisecond, 30 * testing::kMillisecond, 30 * testing::kMillisecond,
                   70 * testing::kMillisecond};
  for (const std::int64_t start_ns : {std::int64_t{0}, std::int64_t{150'000'000}, std::int64_t{86'400'000'000'000}}) {
    const std::vector<bool> script = cutsFrom(scripted, start_ns), repeat = cutsFrom(repeated, start_ns);
    for (std::size_t i = 0; i < 600; ++i) {
      EXPECT_EQ(script[i], i >= 100 && i < 200) << i << " from " << start_ns;
      EXPECT_EQ(repeat[i], i >= 50 && (i - 50) % 100 < 30) << i << " from " << start_ns;
    }
  }
}

TEST(LossTest, AStreamWaitsForTheEndOfTheLongestOfOutagesThatOverlap) {
  for (const bool is_longer_first : {false, true}) {
    Impairment impairment;
    const Outage longer{100 * testing::kMillisecond, 400 * testing::kMillisecond};
    const Outage shorter{150 * testing::kMillisecond, 200 * testing::kMillisecond};
    impairment.outages = {longer, shorter};
    if (!is_longer_first) std::swap(impairment.outages[0], impairment.outages[1]);
    constexpr std::int64_t kStart = 7'000 * testing::kMillisecond;
    Channel channel(impairment, 1, 0, kStart, Medium::kStream);
    const std::uint8_t byte = 1;
    channel.offer(&byte, 1, kStart + 160 * testing::kMillisecond);
    EXPECT_EQ(channel.nextDue(), kStart + 400 * testing::kMillisecond);
  }
}

TEST(LossTest, EachLossIsCountedUnderItsCause) {
  Impairment alone, bursts;
  alone.loss = 0.2;
  bursts.loss_runs = {0.02, 10};
  for (const auto& [impairment, cause] : {std::pair{alone, Loss::kIndependent}, {bursts, Loss::kBurst}}) {
    const Outcome outcome = send(impairment, 2000);
    EXPECT_GT(outcome.lost(), 100U);
    EXPECT_EQ(outcome.counts.dropped[static_cast<std::size_t>(cause)], outcome.lost());
  }
}

TEST(LossTest, AScriptedOutageTakesExactlyThePacketsInIt) {
  Impairment impairment;
  impairment.outages = {{100 * testing::kMillisecond, 200 * testing::kMillisecond}};
  const Outcome outcome = send(impairment, 300);
  for (std::size_t i = 0; i < 300; ++i)
    EXPECT_EQ(outcome.fates[i].loss, i >= 100 && i < 200 ? Loss::kCut : Loss::kNone) << i;
}

}  // namespace
}  // namespace raven2_trainer::impair
