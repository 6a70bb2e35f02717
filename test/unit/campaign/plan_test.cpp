#include "raven2_trainer/campaign/plan.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <regex>
#include <set>

#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/core/fault_variables.h"

namespace raven2_trainer::campaign {
namespace {

const std::string kHead = R"(name: test
title: Test
source: none
plant: identified
homing: quick
arm_contacts: false
cpu_limit: 20
horizon_ticks: {homing: 6000, pedal_down: 3000}
limits: {masked: 0.0001, jump: 0.001, still: 0.0003, moved: 0.001, force: 0.05}
scenarios:
)";

const std::string kScenario = R"(  - scenario: dac
    injection: 11
    number: 12
    observed: abrupt jump
    published: [unsafe_jump]
    phase: pedal_down
    repetitions: 3
    faults:
      - {host: robot, site: put_usb_packet, variable: dac, kind: stuck_at, arm: [gold, green], channel: shoulder, value: [-1000, 0, 1000, 2000], start: {trigger: pedal_down, first_tick: 1000}, duration_ticks: [4, 64]}
)";

Campaign read(const std::string& scenarios, std::uint64_t seed = 1) {
  return readCampaign(kHead + scenarios, "campaign.yaml", seed, {});
}

std::string replaced(const std::string& text, const std::string& pattern, const std::string& by) {
  const std::string result = std::regex_replace(text, std::regex(pattern), by);
  EXPECT_NE(result, text) << pattern;
  return result;
}

std::string refusal(const std::string& text) {
  try {
    readCampaign(text, "campaign.yaml", 1, {});
  } catch (const ConfigException& e) {
    return e.what();
  }
  return "";
}

TEST(Plan, AGridIsEveryCombinationTimesTheRepetitions) {
  const Campaign campaign = read(kScenario);
  ASSERT_EQ(campaign.runs.size(), 2u * 4u * 2u * 3u);
  std::map<std::tuple<int, double, std::int64_t>, int> seen;
  for (std::size_t i = 0; i < campaign.runs.size(); ++i) {
    const CampaignRun& run = campaign.runs[i];
    EXPECT_EQ(run.number, i + 1);
    ASSERT_EQ(run.plan.count, 1u);
    const Fault& fault = run.plan.faults[0];
    EXPECT_TRUE(isSound(fault));
    EXPECT_EQ(fault.variable, FaultVariable::kDac);
    ++seen[{fault.arm, fault.value, fault.duration_ticks}];
  }
  EXPECT_EQ(seen.size(), 16u);
  for (const auto& [point, times] : seen)
    EXPECT_EQ(times, 3);
}

TEST(Plan, RowsOfOneScenarioAreCombined) {
  const std::string row =
      "      - {host: robot, site: put_usb_packet, variable: dac, kind: add, arm: green, channel: "
      "elbow, value: [1, 2], start: {trigger: pedal_down, first_tick: 700}, duration_ticks: 0}\n";
  const Campaign campaign = read(kScenario + row);
  EXPECT_EQ(campaign.runs.size(), 2u * 48u);
  EXPECT_EQ(campaign.runs[0].plan.count, 2u);
  EXPECT_EQ(campaign.runs[0].offset_ticks, 700) << "before the first of them";
}

TEST(Plan, TheForkIsTheLastTickBeforeTheFault) {
  EXPECT_EQ(read(kScenario).runs[0].offset_ticks, 1000) << "robot cycles: exact";
  const std::string packets = replaced(kScenario, "trigger: pedal_down", "trigger: packet");
  EXPECT_EQ(read(packets).runs[0].offset_ticks, 1000 - 64) << "packets begin before the robot's PEDAL_DN";
  const std::string homing =
      replaced(replaced(kScenario, "phase: pedal_down", "phase: homing"), "trigger: pedal_down", "trigger: power_on");
  EXPECT_EQ(read(homing).runs[0].offset_ticks, 0);
  EXPECT_EQ(read(homing).runs[0].horizon_ticks, 6000);
}

TEST(Plan, StartsMayBeAnAxis) {
  const Campaign campaign =
      read(replaced(kScenario, "start: \\{trigger: pedal_down, first_tick: 1000\\}",
                    "start: [{trigger: pedal_down, first_tick: 5}, {trigger: packet, first_tick: 2000}]"));
  std::set<std::int64_t> offsets;
  for (const CampaignRun& run : campaign.runs)
    offsets.insert(run.offset_ticks);
  EXPECT_EQ(offsets, (std::set<std::int64_t>{5, 2000 - 64}));
}

TEST(Plan, TheSameSeedGivesTheSameRunsAndAnotherSeedOthers) {
  const Campaign first = read(kScenario, 1), again = read(kScenario, 1), other = read(kScenario, 2);
  std::set<std::uint64_t> seeds, motions;
  for (std::size_t i = 0; i < first.runs.size(); ++i) {
    EXPECT_EQ(first.runs[i].seed, again.runs[i].seed);
    EXPECT_EQ(first.runs[i].motion_seed, again.runs[i].motion_seed);
    EXPECT_NE(first.runs[i].seed, other.runs[i].seed);
    EXPECT_EQ(first.runs[i].plan.faults[0].seed, first.runs[i].seed);
    seeds.insert(first.runs[i].seed);
    motions.insert(first.runs[i].motion_seed);
  }
  EXPECT_EQ(seeds.size(), first.runs.size());
  EXPECT_EQ(motions.size(), 3u) << "one a repetition";
}

TEST(Plan, DrawsAreOfEachRunAndInTheirRange) {
  const std::string drawn = replaced(kScenario, "value: \\[-1000, 0, 1000, 2000\\], ", "");
  const std::string scenario = replaced(replaced(drawn, "repetitions: 3",
                                                 "repetitions: 500\n    random: {value: {low: "
                                                 "-300, high: 300, whole: true}}"),
                                        "duration_ticks: \\[4, 64\\]", "duration_ticks: 4");
  const Campaign campaign = read(scenario);
  ASSERT_EQ(campaign.runs.size(), 1000u);
  std::set<double> values;
  double sum = 0.0;
  for (const CampaignRun& run : campaign.runs) {
    const double value = run.plan.faults[0].value;
    EXPECT_TRUE(value >= -300 && value < 300 && value == std::floor(value)) << value;
    values.insert(value);
    sum += value;
  }
  // 1000 draws of 600 numbers hit 600 (1 - e^(-1000/600)) = 487 of them, standard deviation about 9; the mean of the
  // draws has the standard deviation 173 / sqrt(1000) = 5.5.
  EXPECT_NEAR(static_cast<double>(values.size()), 487.0, 45.0);
  EXPECT_NEAR(sum / 1000.0, -0.5, 28.0);
}

/** As doc/campaign.md has it: drawn for each run, and put into every row. */
TEST(Plan, ADrawIsTheSameInEveryRowOfARun) {
  const std::string drawn =
      replaced(kScenario, "repetitions: 3", "repetitions: 3\n    random: {value: {low: -300, high: 300, whole: true}}");
  const std::string first = replaced(drawn, "value: \\[-1000, 0, 1000, 2000\\], ", "");
  const Campaign campaign = read(first +
                                 "      - {host: robot, site: put_usb_packet, variable: dac, kind: stuck_at, arm: "
                                 "gold, channel: elbow, start: {trigger: pedal_down, first_tick: 1000}, "
                                 "duration_ticks: 4}\n");
  ASSERT_EQ(campaign.runs.size(), 12u);
  std::set<double> values;
  for (const CampaignRun& run : campaign.runs) {
    ASSERT_EQ(run.plan.count, 2u);
    EXPECT_EQ(run.plan.faults[0].value, run.plan.faults[1].value) << run.number;
    values.insert(run.plan.faults[0].value);
  }
  EXPECT_GT(values.size(), 6u) << "each run has its own";
}

TEST(Plan, ANameThatIsNoFileNameIsRefused) {
  EXPECT_NE(refusal(replaced(kHead, "name: test", "name: mine/test") + kScenario).find("holds a /"), std::string::npos);
}

TEST(Plan, ShardsAreAPartition) {
  const Campaign campaign = read(kScenario);
  for (const std::size_t shards : {1u, 2u, 7u, 48u, 100u}) {
    std::set<std::uint32_t> seen;
    std::size_t runs = 0, largest = 0;
    for (std::size_t shard = 1; shard <= shards; ++shard) {
      const std::vector<CampaignRun> part = shardOf(campaign.runs, shard, shards);
      largest = std::max(largest, part.size());
      runs += part.size();
      for (const CampaignRun& run : part)
        seen.insert(run.number);
    }
    EXPECT_EQ(runs, 48u);
    EXPECT_EQ(seen.size(), 48u);
    EXPECT_LE(largest, 48u / shards + 1u);
  }
  EXPECT_THROW(shardOf(campaign.runs, 0, 2), ConfigException);
  EXPECT_THROW(shardOf(campaign.runs, 3, 2), ConfigException);
}

TEST(Plan, RunsOfOneGoldenRunStandTogetherInTheOrderOfTheirForks) {
  const std::vector<CampaignRun> ordered = inOrderOfForks(read(kScenario).runs);
  std::set<std::uint32_t> finished;
  for (std::size_t i = 1; i < ordered.size(); ++i) {
    const CampaignRun &before = ordered[i - 1], &run = ordered[i];
    if (run.repetition != before.repetition) finished.insert(before.repetition);
    EXPECT_EQ(finished.count(run.repetition), 0u);
    if (run.repetition == before.repetition) {
      EXPECT_LE(before.offset_ticks, run.offset_ticks);
    }
  }
}

TEST(Plan, WhatIsWrongIsRefusedWithItsPlace) {
  const std::multimap<std::string, std::pair<std::string, std::string>> wrong{
      {"campaign.yaml:19: scenarios[0]/faults[0]/channel", {"channel: shoulder", "channel: knee"}},
      {"campaign.yaml:19: scenarios[0]/faults[0]/value", {"-1000, 0", "-1e9, 0"}},
      {"campaign.yaml:19: scenarios[0]/faults[0]/value", {"value: \\[-1000, 0, 1000, 2000\\]", "value: []"}},
      {"campaign.yaml:19: scenarios[0]/faults[0]/value", {"value: \\[-1000, 0, 1000, 2000\\], ", ""}},
      {"campaign.yaml:19: unknown key scenarios[0]/faults[0]/speed",
       {"channel: shoulder", "channel: shoulder, speed: 3"}},
      {"campaign.yaml:16: scenarios[0]/phase", {"phase: pedal_down", "phase: homing"}},
      {"campaign.yaml:15: scenarios[0]/published", {"\\[unsafe_jump\\]", "[explosion]"}},
      {"campaign.yaml:15: scenarios[0]/published", {"\\[unsafe_jump\\]", "[no_outcome]"}},
      {"campaign.yaml:11: scenarios[0]/scenario", {"scenario: dac", "scenario: \"dac, stuck\""}},
      {"campaign.yaml:17: scenarios[0]/repetitions", {"repetitions: 3", "repetitions: 0"}},
      {"campaign.yaml:12: unknown key scenarios[0]/speed", {"injection: 11", "speed: 1\n    injection: 11"}},
      {"campaign.yaml:8: horizon_ticks/homing", {"homing: 6000", "homing: 0"}},
  };
  for (const auto& [place, change] : wrong) {
    const std::string said = refusal(replaced(kHead + kScenario, change.first, change.second));
    EXPECT_NE(said.find(place), std::string::npos) << change.second << "\n  expected " << place << "\n  said " << said;
  }
}

TEST(Plan, AGridThatWouldFillTheMemoryIsRefused) {
  std::string many;
  for (int i = 1; i <= 400; ++i)
    many += (i == 1 ? "" : ", ") + std::to_string(i);
  const std::string square =
      replaced(replaced(kScenario, "\\[-1000, 0, 1000, 2000\\]", "[" + many + "]"), "\\[4, 64\\]", "[" + many + "]");
  EXPECT_NE(refusal(kHead + square).find("more than 100,000 points"), std::string::npos);
  const std::string repeated = replaced(kScenario, "repetitions: 3", "repetitions: 10000");
  EXPECT_NE(refusal(kHead + repeated).find("more than 100,000 runs"), std::string::npos);
}

TEST(Plan, TheShippedCampaignsAreOfTheSizeThatTheirSourcesHad) {
  const std::string folder = RAVEN2_TRAINER_SOURCE_DIR "/config";
  const auto impairments = config::loadTrainerConfig(folder + "/trainer.yaml").impairment_names;
  const auto load = [&](const std::string& name) {
    return loadCampaign(folder + "/campaigns/" + name + ".yaml", 1, impairments);
  };
  const Campaign safecomp = load("safecomp15");
  EXPECT_GE(safecomp.runs.size(), 2146u);
  std::set<std::int64_t> injections;
  for (const CampaignRun& run : safecomp.runs)
    injections.insert(safecomp.experiments[run.experiment].injection);
  EXPECT_EQ(injections.size(), 45u);
  EXPECT_EQ(*injections.begin(), 1);
  EXPECT_EQ(*injections.rbegin(), 45);
  EXPECT_GE(load("dsn16_inputs").runs.size(), 1925u);
  EXPECT_GE(load("dsn16_dac").runs.size(), 1361u);
}

TEST(Plan, TheHeadsNumbersAreTheCampaigns) {
  const Campaign campaign = read(kScenario);
  EXPECT_EQ(campaign.limits.masked, 0.0001);
  EXPECT_EQ(campaign.limits.jump, 0.001);
  EXPECT_EQ(campaign.limits.still, 0.0003);
  EXPECT_EQ(campaign.limits.moved, 0.001);
  EXPECT_EQ(campaign.limits.force, 0.05);
  EXPECT_EQ(campaign.cpu_limit, 20);
  EXPECT_EQ(campaign.plant, "identified");
  EXPECT_FALSE(campaign.full_homing);
  EXPECT_FALSE(campaign.arm_contacts);
  const std::string moved = replaced(kHead, "moved: 0.001", "moved: 0.002");
  EXPECT_EQ(readCampaign(moved + kScenario, "campaign.yaml", 1, {}).limits.moved, 0.002);
  EXPECT_TRUE(readCampaign(replaced(kHead, "quick", "full") + kScenario, "campaign.yaml", 1, {}).full_homing);
  const std::string touching = replaced(kHead, "arm_contacts: false", "arm_contacts: true");
  EXPECT_TRUE(readCampaign(touching + kScenario, "campaign.yaml", 1, {}).arm_contacts);
}

TEST(Plan, AScenariosOwnHorizonAndDrawsAreNotTheNextOnes) {
  const std::string own = replaced(kScenario, "repetitions: 3",
                                   "repetitions: 3\n    horizon_ticks: 700\n    random: {value: {low: -300, high: "
                                   "300, whole: true}}");
  const std::string first = replaced(own, "value: \\[-1000, 0, 1000, 2000\\], ", "");
  const Campaign campaign = read(first + kScenario);
  ASSERT_EQ(campaign.runs.size(), 12u + 48u);
  for (const CampaignRun& run : campaign.runs)
    EXPECT_EQ(run.horizon_ticks, run.experiment == 0 ? 700 : 3000) << run.number;
  std::map<double, int> values;
  for (std::size_t i = 12; i < campaign.runs.size(); ++i)
    ++values[campaign.runs[i].plan.faults[0].value];
  EXPECT_EQ(values, (std::map<double, int>{{-1000, 12}, {0, 12}, {1000, 12}, {2000, 12}}));
}

TEST(Plan, TheForkIsBeforeTheFirstOfItsFaultsInWhateverOrder) {
  const auto row = [](const std::string& first_tick) {
    return "      - {host: robot, site: put_usb_packet, variable: dac, kind: add, arm: green, channel: elbow, value: "
           "1, "
           "start: {trigger: pedal_down, first_tick: " +
           first_tick + "}, duration_ticks: 0}\n";
  };
  EXPECT_EQ(read(kScenario + row("700")).runs[0].offset_ticks, 700);
  EXPECT_EQ(read(kScenario + row("1700")).runs[0].offset_ticks, 1000);
}

TEST(Plan, TheDaemonsClocksRunBeforeTheRobotsPedalDown) {
  const std::string row =
      "site: put_usb_packet, variable: dac, kind: stuck_at, arm: \\[gold, green\\], channel: shoulder";
  for (const std::string host : {"relay", "master"}) {
    const std::string scenario = replaced(
        replaced(kScenario, row, "site: network_layer, variable: increment, kind: add, arm: [gold, green], channel: x"),
        "host: robot", "host: " + host);
    EXPECT_EQ(read(scenario).runs[0].offset_ticks, 1000 - 64) << host;
  }
}

}  // namespace
}  // namespace raven2_trainer::campaign
