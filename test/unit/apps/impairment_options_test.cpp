#include "apps/common/impairment_options.h"

#include <gtest/gtest.h>

#include <CLI/CLI.hpp>

#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::apps {
namespace {

runtime::ProxyOptions parsed(const std::string& arguments) {
  CLI::App app;
  ImpairmentOptions options;
  options.add(&app);
  app.parse(arguments);
  return options.load();
}

TEST(ImpairmentOptions, LinksAreReadWithAndWithoutAnAddress) {
  const auto options = parsed("--udp 36020:127.0.0.1:36010 --udp 0.0.0.0:36021:10.0.0.2:36001 --tcp 36120:host:36100");
  ASSERT_EQ(options.links.size(), 3U);
  EXPECT_EQ(options.links[0].listen_address, "127.0.0.1");
  EXPECT_EQ(options.links[0].listen_port, 36020);
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

TEST(ImpairmentOptions, AProfileOfItsOwnForTheWayBackIsLeftAsItIs) {
  const auto link = parsed("--udp 1:h:2 --back-profile none --loss 0.3").links[0];
  EXPECT_EQ(link.forward.loss, 0.3);
  EXPECT_EQ(link.back.loss, 0.0);
}

TEST(ImpairmentOptions, WhatMakesNoSenseIsRefused) {
  for (const char* bad : {"--loss 0.1", "--udp 36020:36010", "--udp 70000:h:1", "--udp 1:h:0", "--udp x:h:1",
                          "--udp 1:h:2 --burst 0.1,nan", "--udp 1:h:2 --burst 1.1,0.1", "--udp 1:h:2 --runs 0.1,0",
                          "--udp 1:h:2 --cut 1,2", "--udp 1:h:2 --profile nothing_like_it"}) {
    EXPECT_THROW(parsed(bad), ConfigException) << bad;
  }
  EXPECT_THROW(parsed("--udp 1:h:2 --loss 1.5"), CLI::ParseError);
}

}  // namespace
}  // namespace raven2_trainer::apps
