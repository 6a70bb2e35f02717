#include "raven2_trainer/campaign/judgement.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "raven2_trainer/campaign/results.h"
#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::campaign {
namespace {

namespace fs = std::filesystem;

/** Three runs with published jumps, and three without published results. */
Campaign sixRuns() {
  const auto scenario = [](const std::string& name, const std::string& published) {
    return "  - scenario: " + name + "\n    injection: 11\n    number: 12\n    observed: jump\n    published: [" +
           published + "]\n    phase: pedal_down\n    repetitions: 3\n    faults:\n" +
           "      - {host: robot, site: put_usb_packet, variable: dac, kind: stuck_at, arm: gold, channel: shoulder, "
           "value: 5, start: {trigger: pedal_down, first_tick: 1000}, duration_ticks: 4}\n";
  };
  const std::string head = R"(name: six
title: Six
source: none
plant: identified
homing: quick
arm_contacts: false
cpu_limit: 20
horizon_ticks: {homing: 6000, pedal_down: 3000}
limits: {masked: 0.0001, jump: 0.001, still: 0.0003, moved: 0.001, force: 0.05}
scenarios:
)";
  return readCampaign(head + scenario("jumps", "unsafe_jump") + scenario("silent", ""), "six.yaml", 1, {});
}

class Judging : public ::testing::Test {
 protected:
  void SetUp() override {
    for (const CampaignRun& run : campaign_.runs)
      set(run.number, run.experiment == 0 ? jumped() : RunResult{Ending::kComplete, acted()});
  }

  static Figures acted() {
    Figures figures;
    figures.injected = 1;
    return figures;
  }
  static RunResult jumped() {
    RunResult result{Ending::kComplete, acted()};
    result.figures.max_jump = 0.002;
    return result;
  }
  void set(std::uint32_t run, const RunResult& result) { rows_[run] = row(campaign_, campaign_.runs[run - 1], result); }
  Judgement judged(const Explanations& explanations = {}) const { return judge(campaign_, explanations, rows_); }

  const Campaign campaign_ = sixRuns();
  std::map<std::uint32_t, std::string> rows_;
};

TEST_F(Judging, ATableThatIsAsPublishedIsGood) {
  EXPECT_TRUE(judged().isGood());
  EXPECT_EQ(inWords(judged()), "");
}

TEST_F(Judging, AnOutcomeThatWasNotPublishedNeedsAnExplanation) {
  set(2, {Ending::kComplete, acted()});
  set(3, {Ending::kDied, {}});
  EXPECT_FALSE(judged().isGood());
  EXPECT_EQ(inWords(judged()),
            "1 runs neither as published nor explained, jumps/pedal_down: crash: 3\n"
            "1 runs neither as published nor explained, jumps/pedal_down: masked: 2\n");
  const Explanations weak{{"jumps/pedal_down", {{"masked"}, "a weak motor"}}};
  EXPECT_EQ(judged(weak).unexplained.size(), 1u) << "the crash is still not explained";
  set(3, jumped());
  EXPECT_TRUE(judged(weak).isGood());
  EXPECT_FALSE(judged({{"jumps/homing", {{"masked"}, "another phase"}}}).isGood());
}

TEST_F(Judging, AScenarioOfWhichEveryRunIsMaskedDoesNothingUnlessThatIsAllThatIsAllowed) {
  for (const std::uint32_t run : {1, 2, 3})
    set(run, {Ending::kComplete, acted()});
  const Explanations wide{{"jumps/pedal_down", {{"masked", "slow_deviation"}, "too short to be seen"}}};
  EXPECT_EQ(inWords(judged(wide)), "every run masked, though more is expected: jumps/pedal_down\n");
  EXPECT_FALSE(judged(wide).isGood());
  EXPECT_TRUE(judged({{"jumps/pedal_down", {{"masked"}, "a weak motor"}}}).isGood());
  rows_.erase(6);
  EXPECT_TRUE(judged(wide).isGood()) << "a part of a campaign may contain only masked runs";
}

TEST_F(Judging, AScenarioOfWhichAnyOneRunIsMaskedDoesSomething) {
  const Explanations wide{{"jumps/pedal_down", {{"masked", "slow_deviation"}, "too short to be seen"}}};
  for (const std::uint32_t run : {1, 2, 3}) {
    set(run, {Ending::kComplete, acted()});
    EXPECT_EQ(inWords(judged(wide)), "") << run;
    set(run, jumped());
  }
}

TEST_F(Judging, WhatNothingWasPublishedOfIsNotCompared) {
  set(5, {Ending::kDied, {}});
  EXPECT_TRUE(judged().isGood());
}

TEST_F(Judging, AFaultThatNeverActedIsWrongWhateverCameOut) {
  set(4, {Ending::kComplete, {}});
  EXPECT_EQ(judged().never_acted, std::vector<std::uint32_t>{4});
  EXPECT_EQ(inWords(judged()), "1 runs in which the fault never acted: 4\n");
  set(4, {Ending::kDied, {}});
  EXPECT_TRUE(judged().never_acted.empty()) << "a process that died reported nothing of its fault";
}

TEST_F(Judging, ARunWithoutAnOutcomeIsWrongWhateverWasPublished) {
  set(1, {Ending::kNoEnd, {}});
  set(6, {Ending::kNoEnd, {}});
  EXPECT_EQ(inWords(judged()), "2 runs without an outcome: 1 6\n");
}

TEST_F(Judging, OnlyTheFirstRunsAreNamed) {
  for (std::uint32_t run = 1; run <= 6; ++run)
    set(run, {Ending::kNoEnd, {}});
  EXPECT_EQ(inWords(judged()), "6 runs without an outcome: 1 2 3 4 5 ...\n");
}

/** Before a campaign is resumed, its explanations may have been changed or removed. */
TEST(KeepExplanations, ThoseOfTheNewestStartAreKept) {
  const fs::path folder = fs::temp_directory_path() / ("raven2_kept_" + std::to_string(getpid()));
  fs::create_directories(folder / "out");
  Campaign campaign = sixRuns();
  campaign.file = (folder / "six.yaml").string();
  const OutputPaths paths{(folder / "out").string()};
  const fs::path given = folder / "six_explained.yaml";
  for (const std::string text : {"first", "second"}) {
    std::ofstream(given) << text;
    keepExplanations(campaign, paths);
    std::string kept;
    std::getline(std::ifstream(paths.explanations(campaign.name)), kept);
    EXPECT_EQ(kept, text);
  }
  fs::remove(given);
  keepExplanations(campaign, paths);
  EXPECT_FALSE(fs::exists(paths.explanations(campaign.name)));
  fs::remove_all(folder);
}

TEST(KeepExplanations, ThoseNextToTheResultsStayThere) {
  const fs::path folder = fs::temp_directory_path() / ("raven2_beside_" + std::to_string(getpid()));
  fs::create_directories(folder);
  Campaign campaign = sixRuns();
  campaign.file = (folder / "six.yaml").string();
  const OutputPaths paths{folder.string()};
  std::ofstream(paths.explanations(campaign.name)) << "mine";
  keepExplanations(campaign, paths);
  std::string kept;
  std::getline(std::ifstream(paths.explanations(campaign.name)), kept);
  EXPECT_EQ(kept, "mine");
  fs::remove_all(folder);
}

class Explained : public ::testing::Test {
 protected:
  void SetUp() override {
    path_ = fs::temp_directory_path() / ("raven2_explained_" + std::to_string(getpid()) + ".yaml");
  }
  void TearDown() override { fs::remove(path_); }

  Explanations load(const std::string& text) const {
    std::ofstream(path_) << text;
    return loadExplanations(path_.string(), campaign_);
  }
  std::string refusal(const std::string& text) const {
    try {
      load(text);
    } catch (const ConfigException& e) {
      return e.what();
    }
    return "";
  }

  const Campaign campaign_ = sixRuns();
  fs::path path_;
};

TEST_F(Explained, AFileNamesOutcomesAndTheReason) {
  const Explanations found = load("jumps/pedal_down:\n  allowed: [masked, estop]\n  why: a weak motor\n");
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found.at("jumps/pedal_down").allowed, (std::vector<std::string>{"masked", "estop"}));
  EXPECT_EQ(found.at("jumps/pedal_down").why, "a weak motor");
}

TEST_F(Explained, WhereThereIsNoFileNothingIs) {
  EXPECT_TRUE(loadExplanations("/nowhere/six_explained.yaml", campaign_).empty());
  EXPECT_EQ(explanationsOf("/some/where/six.yaml"), "/some/where/six_explained.yaml");
}

TEST_F(Explained, WhatIsWrongIsRefusedWithItsPlace) {
  EXPECT_NE(refusal("jumps/homing: {allowed: [], why: x}").find(":1: jumps/homing explains"), std::string::npos);
  EXPECT_NE(refusal("jumps/pedal_down: {allowed: [no_outcome], why: x}").find("no outcome"), std::string::npos);
  EXPECT_NE(refusal("jumps/pedal_down: {allowed: []}").find("why"), std::string::npos);
  EXPECT_NE(refusal("jumps/pedal_down: {allowed: [], why: x, who: y}").find("who"), std::string::npos);
}

TEST(Judge, TheShippedExplanationsAreOfTheirCampaigns) {
  for (const std::string name : {"safecomp15", "dsn16_inputs", "dsn16_dac"}) {
    const std::string file = RAVEN2_TRAINER_SOURCE_DIR "/config/campaigns/" + name + ".yaml";
    EXPECT_FALSE(loadExplanations(explanationsOf(file), loadCampaign(file, 1, {})).empty()) << name;
  }
}

}  // namespace
}  // namespace raven2_trainer::campaign
