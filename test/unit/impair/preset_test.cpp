// The presets act as their files say: published means and shares (sources.md 4.2), an hour of each.

#include <gtest/gtest.h>

#include <cstdio>

#include "raven2_trainer/config/load_impairment.h"
#include "unit/impair/channel_support.h"

namespace raven2_trainer::impair {
namespace {

using testing::Outcome;
using testing::send;

const std::string kFolder = RAVEN2_TRAINER_SOURCE_DIR "/config/impairments";
constexpr int kHour = 360'000;  // packets, one every 10 ms: 3,600 draws of a delay that holds for a second

Outcome hourOf(const std::string& preset) {
  Channel channel(config::findImpairment(kFolder, preset), 1, 0, 0);
  return send(&channel, kHour, 10 * testing::kMillisecond);
}

TEST(PresetTest, TheDelaysHaveTheirPublishedMeans) {
  // The mean of 3,600 draws has a deviation of 1.7 % of the spread at most: five of them are 9 ms. Keeping the order
  // adds (1/2) m^2 / 1000 ms with m the mean above the lower bound: 5 ms at the most.
  EXPECT_NEAR(hourOf("net_delay_1").meanDelay() * 1e-6, 100.0, 5.0);
  EXPECT_NEAR(hourOf("net_delay_2").meanDelay() * 1e-6, 300.0, 13.0);
  EXPECT_NEAR(hourOf("net_delay_3").meanDelay() * 1e-6, 500.0, 14.0);
}

TEST(PresetTest, TheDelayLawsHaveTheirPublishedLowerBoundsAndExactMeans) {
  for (const auto& [preset, bound, mean] :
       {std::tuple{"net_delay_1", 70.0, 100.0}, std::tuple{"net_delay_2", 210.0, 300.0},
        std::tuple{"net_delay_3", 406.0, 500.0}}) {
    const DelayLaw law = config::findImpairment(kFolder, preset).delay;
    double sum = static_cast<double>(law.constant_ns);
    EXPECT_EQ(sum, bound * 1e6);
    for (const ExponentialBranch& branch : law.branches)
      sum += branch.weight * branch.mean_ns;
    EXPECT_NEAR(sum * 1e-6, mean, 1.1) << preset;
  }
}

TEST(PresetTest, TheLossesHaveTheirPublishedShares) {
  EXPECT_NEAR(hourOf("net_loss_10").lostShare(), 0.10, 0.01);
  EXPECT_NEAR(hourOf("net_loss_30").lostShare(), 0.30, 0.02);
  EXPECT_NEAR(hourOf("net_loss_50").lostShare(), 0.50, 0.02);
}

TEST(PresetTest, TheCutsTakeTheShareOfTimeThatTheirFiguresGive) {
  EXPECT_NEAR(hourOf("comm_loss_10").lostShare(), 0.15, 0.025);
  EXPECT_NEAR(hourOf("comm_loss_30").lostShare(), 1.0 / 3.0, 0.025);
  EXPECT_NEAR(hourOf("comm_loss_50").lostShare(), 0.5, 0.025);
}

TEST(PresetTest, AMinuteOfEachAtAThousandPacketsASecond) {
  for (const std::string& preset : config::impairmentNames(kFolder)) {
    Channel channel(config::findImpairment(kFolder, preset), 1, 0, 0);
    const Outcome outcome = send(&channel, 60'000);
    EXPECT_TRUE(outcome.counts.addsUp()) << preset;
    EXPECT_LT(outcome.lostShare(), 0.7) << preset;
    std::printf("%-14s mean delay %6.1f ms, lost %5.2f %%, doubled %llu, reordered %llu\n", preset.c_str(),
                outcome.meanDelay() * 1e-6, 100.0 * outcome.lostShare(),
                static_cast<unsigned long long>(outcome.counts.doubled),
                static_cast<unsigned long long>(outcome.counts.reordered));
  }
}

}  // namespace
}  // namespace raven2_trainer::impair
