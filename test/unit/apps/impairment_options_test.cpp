#include "apps/common/impairment_options.h"

#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <fstream>
#include <nlohmann/json.hpp>

#include "apps/common/impairment_report.h"
#include "raven2_trainer/core/exceptions.h"
#include "support/scratch_path.h"

namespace raven2_trainer::apps {
namespace {

proxy::ProxyOptions parsed(const std::string& arguments) {
  CLI::App app;
  ImpairmentOptions options;
  options.add(&app);
  app.parse(arguments);
  return options.load();
}

TEST(ImpairmentOptions, LinksAreReadWithAndWithoutAnAddress) {
  const auto options = parsed("--udp 26020:127.0.0.1:36010 --udp 0.0.0.0:26021:10.0.0.2:36001 --tcp 26120:host:26100");
  ASSERT_EQ(options.links.size(), 3U);
  EXPECT_EQ(options.links[0].listen_address, "127.0.0.1");
  EXPECT_EQ(options.links[0].listen_port, 26020);
  EXPECT_EQ(options.links[0].target_port, 36010);
  EXPECT_EQ(options.links[1].listen_address, "0.0.0.0");
  EXPECT_EQ(options.links[1].target_host, "10.0.0.2");
  EXPECT_EQ(options.links[2].medium, impair::Medium::kStream);
  EXPECT_EQ(options.links[2].target_host, "host");
}

TEST(ImpairmentOptions, SingleValuesReplaceThoseOfTheProfileInBothDirections) {
  const auto link = parsed("--udp 1:h:2 --profile net_delay_1 --delay-ms 12.5 --burst 0.01,0.2 --cut 10,0.5").links[0];
  for (const Impairment& impairment : {link.forward, link.back}) {
    EXPECT_EQ(impairment.delay.constant_ns, 12'500'000);
    EXPECT_EQ(impairment.delay.branches.size(), 2U) << "of the profile";
    EXPECT_EQ(impairment.gilbert_elliott.to_good, 0.2);
    EXPECT_EQ(impairment.cuts.pause_ns, 9'500'000'000);
    EXPECT_EQ(impairment.cuts.longest_ns, 500'000'000);
  }
}

TEST(ImpairmentOptions, AZeroSwitchesOffWhatTheProfileDoes) {
  ASSERT_GT(impairmentByName("worst").corruption.probability, 0.0);
  ASSERT_GT(impairmentByName("worst").rate.bits_per_s, 0.0);
  const auto link = parsed("--udp 1:h:2 --profile worst --corrupt-bits 0 --rate-kbit 0").links[0];
  EXPECT_EQ(link.forward.corruption.probability, 0.0);
  EXPECT_EQ(link.forward.rate.bits_per_s, 0.0);
  const auto as_it_is = parsed("--udp 1:h:2 --profile worst").links[0];
  EXPECT_GT(as_it_is.forward.corruption.probability, 0.0);
  EXPECT_GT(as_it_is.forward.rate.bits_per_s, 0.0);
}

TEST(ImpairmentOptions, AProfileOfItsOwnForTheWayBackIsLeftAsItIs) {
  const auto link = parsed("--udp 1:h:2 --back-profile none --loss 0.3").links[0];
  EXPECT_EQ(link.forward.loss, 0.3);
  EXPECT_EQ(link.back.loss, 0.0);
}

TEST(ImpairmentOptions, WhatMakesNoSenseIsRefused) {
  for (const char* bad : {"--loss 0.1", "--udp 26020:36010", "--udp 70000:h:1", "--udp 1:h:0", "--udp x:h:1",
                          "--udp 1:h:2 --burst 0.1,nan", "--udp 1:h:2 --burst 1.1,0.1", "--udp 1:h:2 --runs 0.1,0",
                          "--udp 1:h:2 --cut 1,2", "--udp 1:h:2 --profile nothing_like_it"}) {
    EXPECT_THROW(parsed(bad), ConfigException) << bad;
  }
  EXPECT_THROW(parsed("--udp 1:h:2 --loss 1.5"), CLI::ParseError);
}

/** Each option changes its own figure, in nanoseconds, packets and bits a second, and nothing else. */
TEST(ImpairmentOptions, EachOptionIsItsOwnFigure) {
  const auto forward = [](const std::string& option) { return parsed("--udp 1:h:2 " + option).links[0].forward; };
  EXPECT_EQ(forward("--jitter-ms 2.5").delay.uniform_ns, 2'500'000);
  EXPECT_EQ(forward("--jitter-ms 2.5").delay.constant_ns, 0);
  EXPECT_EQ(forward("--delay-ms 2.5").delay.uniform_ns, 0);
  EXPECT_TRUE(forward("--overtaking").delay.overtaking);
  EXPECT_EQ(forward("--duplicate 0.25").duplicate, 0.25);
  EXPECT_EQ(forward("--duplicate 0.25").loss, 0.0);
  EXPECT_EQ(forward("--reorder 0.5").reordering.probability, 0.5);
  EXPECT_EQ(forward("--reorder 0.5").reordering.depth, 3) << "up to three others (--help)";
  EXPECT_EQ(forward("--rate-kbit 1216").rate.bits_per_s, 1'216'000.0);
  EXPECT_EQ(forward("--runs 0.1,7").loss_runs.packets, 7);
  EXPECT_EQ(forward("--runs 0.1,7").loss_runs.probability, 0.1);
  EXPECT_EQ(forward("--corrupt-bits 3").corruption.probability, 0.01);
  EXPECT_EQ(forward("--corrupt-bits 3 --corrupt-share 0.2").corruption.probability, 0.2);
  EXPECT_EQ(forward("--corrupt-bits 3").corruption.bits, 3);
  EXPECT_EQ(forward("--burst 0.01,0.2").gilbert_elliott.to_bad, 0.01);
  EXPECT_EQ(forward("--burst 0.01,0.2").gilbert_elliott.loss_bad, 1.0);
  EXPECT_EQ(forward("--burst 0.01,0.2").gilbert_elliott.loss_good, 0.0);
  EXPECT_EQ(parsed("--udp 1:h:2 --seed 9").seed, 9U);
}

TEST(ImpairmentOptions, AnOutageLastsFromItsBeginningToItsEnd) {
  const auto outages = parsed("--udp 1:h:2 --outage 1,2.5 --outage 4,5").links[0].forward.outages;
  ASSERT_EQ(outages.size(), 2U);
  EXPECT_EQ(outages[0].from_ns, 1'000'000'000);
  EXPECT_EQ(outages[0].to_ns, 2'500'000'000);
  EXPECT_EQ(outages[1].from_ns, 4'000'000'000);
  for (const char* bad : {"--outage 2,1", "--outage 2,2", "--outage 1,2,3", "--outage -1,2"})
    EXPECT_THROW(parsed(std::string("--udp 1:h:2 ") + bad), ConfigException) << bad;
}

/** Two profiles, each in its own direction. */
TEST(ImpairmentOptions, EachDirectionHasItsOwnProfile) {
  const auto link = parsed("--tcp 1:h:2 --profile net_delay_1 --back-profile net_loss_10").links[0];
  EXPECT_EQ(link.forward.name, "net_delay_1");
  EXPECT_EQ(link.back.name, "net_loss_10");
}

TEST(ImpairmentReport, EachFigureHasItsOwnName) {
  proxy::ProxyReport report;
  report.link = "udp 1";
  report.direction = "back";
  impair::ChannelCounts& c = report.counts;
  const std::vector<std::pair<const char*, std::uint64_t*>> figures{{"in", &c.in},
                                                                    {"forwarded", &c.forwarded},
                                                                    {"held", &c.held},
                                                                    {"doubled", &c.doubled},
                                                                    {"duplicates", &c.duplicates},
                                                                    {"held_copies", &c.held_copies},
                                                                    {"reordered", &c.reordered},
                                                                    {"truncated", &c.truncated},
                                                                    {"corrupted", &c.corrupted},
                                                                    {"stalled", &c.stalled},
                                                                    {"unsent", &report.unsent},
                                                                    {"connections", &report.connections}};
  std::uint64_t n = 100;
  for (const auto& figure : figures)
    *figure.second = ++n;
  for (std::size_t i = 1; i < impair::kLossCount; ++i)
    c.dropped[i] = i;
  const std::string path = raven2_trainer::testing::scratchPath("impair.json");
  writeReports(path, parsed("--udp 1:h:2 --seed 9 --profile net_delay_1 --back-profile net_loss_10"), {report});
  std::ifstream file(path);
  const nlohmann::json json = nlohmann::json::parse(file);
  EXPECT_EQ(json["seed"], 9);
  EXPECT_EQ(json["profile"], "net_delay_1");
  EXPECT_EQ(json["back_profile"], "net_loss_10");
  const nlohmann::json& link = json["links"][0];
  EXPECT_EQ(link["link"], "udp 1");
  EXPECT_EQ(link["direction"], "back");
  for (const auto& figure : figures)
    EXPECT_EQ(link[figure.first], *figure.second) << figure.first;
  for (std::size_t i = 1; i < impair::kLossCount; ++i)
    EXPECT_EQ(link["dropped"][impair::kLossNames[i]], i);
}

}  // namespace
}  // namespace raven2_trainer::apps
