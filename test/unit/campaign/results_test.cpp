#include "raven2_trainer/campaign/results.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <sstream>
#include <thread>

#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::campaign {
namespace {

namespace fs = std::filesystem;

/** Six runs of one scenario. */
Campaign sixRuns() {
  const std::string text = R"(name: six
title: Six
source: none
plant: identified
homing: quick
arm_contacts: false
cpu_limit: 20
horizon_ticks: {homing: 6000, pedal_down: 3000}
limits: {masked: 0.0001, jump: 0.001, still: 0.0003, moved: 0.001, force: 0.05}
scenarios:
  - scenario: dac
    injection: 11
    number: 12
    observed: "jump, \"abrupt\""
    published: [unsafe_jump]
    phase: pedal_down
    repetitions: 2
    faults:
      - {host: robot, site: put_usb_packet, variable: dac, kind: stuck_at, arm: gold, channel: shoulder, value: [-1000, 0, 5], start: {trigger: pedal_down, first_tick: 1000}, duration_ticks: 4}
)";
  return readCampaign(text, "six.yaml", 1, {});
}

std::string slurp(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::stringstream text;
  text << in.rdbuf();
  return text.str();
}

std::string messageOf(const std::function<void()>& action) {
  try {
    action();
  } catch (const SessionException& e) {
    return e.what();
  }
  return "";
}

class Results : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("raven2_results_" + std::to_string(getpid()));
    fs::remove_all(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::string at(const std::string& name) const { return (folder_ / name).string(); }

  Identity identity(std::size_t shard = 1, std::size_t shards = 1, const std::string& build = "b") const {
    Identity id = identify(campaign_, {{"build", build}});
    id.shard = shard;
    id.shards = shards;
    return id;
  }

  std::string rowOf(const CampaignRun& run) const {
    RunResult result;
    result.figures.injected = 1;
    result.figures.deviation[1] = 1e-5 * run.number;
    return row(campaign_, run, result);
  }

  /** Writes some runs, in the order given. */
  void write(const std::string& name,
             const Identity& id,
             const std::vector<CampaignRun>& runs,
             bool resume = false) const {
    PartialOutcomes outcomes({at(name)}, id, campaign_, resume);
    for (const CampaignRun& run : runs)
      outcomes.add(run.number, rowOf(run));
    outcomes.finish();
  }

  void writeShard(const std::string& name, std::size_t shard, std::size_t shards) const {
    write(name, identity(shard, shards), shardOf(campaign_.runs, shard, shards));
  }

  const Campaign campaign_ = sixRuns();
  fs::path folder_;
};

std::vector<std::string> cells(const std::string& line) {
  std::vector<std::string> all;
  std::stringstream in(line + ",");
  for (std::string cell; std::getline(in, cell, ',');)
    all.push_back(cell);
  return all;
}

std::string cell(const std::string& line, const std::string& column) {
  const std::vector<std::string> columns = cells(header());
  const auto found = std::find(columns.begin(), columns.end(), column);
  EXPECT_NE(found, columns.end()) << column;
  return cells(line).at(static_cast<std::size_t>(found - columns.begin()));
}

TEST_F(Results, ARowSaysWhatWasInjectedAndWhatCameOfIt) {
  RunResult result;
  Figures& figures = result.figures;
  figures.injected = 1;
  figures.deviation = {0.0123456, 0.001};
  figures.max_jump = 0.002;
  figures.jumped = 5;
  figures.software_stop = 40;
  figures.plc_stop = 240;
  figures.reported = 244;
  figures.force = 12;
  figures.max_force = 3.3;
  figures.motion = {0.001, 0.002};
  const std::string line = row(campaign_, campaign_.runs[0], result);
  EXPECT_EQ(header().substr(0, 26), "scenario,run,seed,outcome,");
  EXPECT_EQ(cell(line, "scenario"), "dac");
  EXPECT_EQ(cell(line, "run"), "1");
  EXPECT_EQ(cell(line, "outcome"), "unsafe_jump");
  EXPECT_EQ(cell(line, "injection"), "11");
  EXPECT_EQ(cell(line, "variable"), "dac");
  EXPECT_EQ(cell(line, "arm"), "gold");
  EXPECT_EQ(cell(line, "channel"), "shoulder");
  EXPECT_EQ(cell(line, "value"), "-1000");
  EXPECT_EQ(cell(line, "duration_ticks"), "4");
  EXPECT_EQ(cell(line, "deviation_mm"), "12.3456");
  EXPECT_EQ(cell(line, "jump_mm"), "2.0000");
  EXPECT_EQ(cell(line, "jump_ms"), "5");
  EXPECT_EQ(cell(line, "estop"), "both");
  EXPECT_EQ(cell(line, "estop_ms"), "40");
  EXPECT_EQ(cell(line, "seen"), "1");
  EXPECT_EQ(cell(line, "reported"), "1");
  EXPECT_EQ(cell(line, "force_ms"), "12");
  EXPECT_EQ(cell(line, "motion_mm"), "2.0000");
  EXPECT_EQ(cell(line, "program"), "running");
}

TEST_F(Results, WhatNeverCameIsAnEmptyCell) {
  const std::string line = row(campaign_, campaign_.runs[0], RunResult{});
  for (const char* column : {"injected_ms", "jump_ms", "estop_ms", "reported", "force_ms"})
    EXPECT_EQ(cell(line, column), "") << column;
  EXPECT_EQ(cell(line, "estop"), "none");
  EXPECT_EQ(cell(line, "seen"), "0");
}

TEST_F(Results, ARunThatNeverStartedSaysSo) {
  RunResult result;
  EXPECT_EQ(cell(row(campaign_, campaign_.runs[0], result), "started"), "") << "its golden run did not start either";
  result.figures.golden_started = 1;
  EXPECT_EQ(cell(row(campaign_, campaign_.runs[0], result), "started"), "0");
  result.figures.started = 1;
  EXPECT_EQ(cell(row(campaign_, campaign_.runs[0], result), "started"), "1");
}

TEST_F(Results, AnUnreportedStopOfThePlcIsToldApart) {
  RunResult result;
  result.figures.plc_stop = 200;
  EXPECT_EQ(cell(row(campaign_, campaign_.runs[0], result), "reported"), "0");
  EXPECT_EQ(cell(row(campaign_, campaign_.runs[0], result), "estop"), "plc");
}

TEST_F(Results, AllRowsHaveAllColumns) {
  const auto count = [](const std::string& line) { return std::count(line.begin(), line.end(), ','); };
  for (const Ending ending : {Ending::kComplete, Ending::kDied, Ending::kBudget, Ending::kMemory, Ending::kNoEnd})
    EXPECT_EQ(count(row(campaign_, campaign_.runs[3], {ending, {}})), count(header()));
  EXPECT_EQ(cell(row(campaign_, campaign_.runs[3], {Ending::kDied, {}}), "program"), "died");
  EXPECT_EQ(cell(row(campaign_, campaign_.runs[3], {Ending::kBudget, {}}), "outcome"), "hang");
  EXPECT_EQ(cell(row(campaign_, campaign_.runs[3], {Ending::kMemory, {}}), "outcome"), "crash");
  EXPECT_EQ(cell(row(campaign_, campaign_.runs[3], {Ending::kMemory, {}}), "program"), "memory");
  EXPECT_EQ(cell(row(campaign_, campaign_.runs[3], {Ending::kNoEnd, {}}), "outcome"), "no_outcome");
  EXPECT_EQ(cell(row(campaign_, campaign_.runs[3], {Ending::kNoEnd, {}}), "program"), "no_end");
}

TEST_F(Results, TheTableIsSortedByRunInWhateverOrderTheyEnd) {
  std::vector<CampaignRun> backwards(campaign_.runs.rbegin(), campaign_.runs.rend());
  write("a", identity(), campaign_.runs);
  write("b", identity(), backwards);
  EXPECT_EQ(slurp(at("a") + "/outcomes.csv"), slurp(at("b") + "/outcomes.csv"));
  EXPECT_EQ(slurp(at("a") + "/campaign.json"), slurp(at("b") + "/campaign.json"));
  EXPECT_FALSE(fs::exists(at("a") + "/outcomes.part"));
}

TEST_F(Results, AKilledCampaignGoesOnFromItsWholeRows) {
  write("whole", identity(), campaign_.runs);
  {
    PartialOutcomes outcomes({at("killed")}, identity(), campaign_, false);
    for (std::size_t i = 0; i < 3; ++i)
      outcomes.add(campaign_.runs[i].number, rowOf(campaign_.runs[i]));
  }
  const std::string torn = rowOf(campaign_.runs[3]);
  std::ofstream(at("killed") + "/outcomes.part", std::ios::app) << torn.substr(0, torn.size() - 3);
  {
    PartialOutcomes outcomes({at("killed")}, identity(), campaign_, true);
    EXPECT_EQ(outcomes.size(), 3u);
    EXPECT_TRUE(outcomes.has(3));
    EXPECT_FALSE(outcomes.has(4)) << "its row is torn";
    for (std::size_t i = 3; i < 6; ++i)
      outcomes.add(campaign_.runs[i].number, rowOf(campaign_.runs[i]));
    outcomes.finish();
  }
  EXPECT_EQ(slurp(at("killed") + "/outcomes.csv"), slurp(at("whole") + "/outcomes.csv"));
}

/** Each start except the first finds the torn row of the start before. */
TEST_F(Results, WhatIsMadeBetweenTwoKillsIsThereInTheEnd) {
  for (std::size_t start = 0; start < 3; ++start) {
    {
      PartialOutcomes outcomes({at("a")}, identity(), campaign_, start > 0);
      ASSERT_EQ(outcomes.size(), 2 * start);
      for (std::size_t i = 2 * start; i < 2 * start + 2; ++i)
        outcomes.add(campaign_.runs[i].number, rowOf(campaign_.runs[i]));
    }
    std::ofstream(at("a") + "/outcomes.part", std::ios::app) << "dac,3,torn";
  }
  PartialOutcomes outcomes({at("a")}, identity(), campaign_, true);
  EXPECT_EQ(outcomes.size(), 6U);
}

TEST_F(Results, WhatFollowsADamagedRowIsMadeAgain) {
  {
    PartialOutcomes outcomes({at("a")}, identity(), campaign_, false);
    outcomes.add(1, rowOf(campaign_.runs[0]));
  }
  std::ofstream(at("a") + "/outcomes.part", std::ios::app) << "dac,2,nonsense\n" << rowOf(campaign_.runs[2]) << "\n";
  PartialOutcomes outcomes({at("a")}, identity(), campaign_, true);
  EXPECT_EQ(outcomes.size(), 1u);
}

TEST_F(Results, AFinishedCampaignIsResumedWithNothingToDo) {
  write("a", identity(), campaign_.runs);
  const std::string before = slurp(at("a") + "/outcomes.csv");
  write("a", identity(), {}, /*resume=*/true);
  EXPECT_EQ(slurp(at("a") + "/outcomes.csv"), before);
}

TEST_F(Results, OnlyTheSameCampaignIsResumed) {
  write("a", identity(), campaign_.runs);
  const auto open = [this](const Identity& id, bool resume) {
    return messageOf([&] { PartialOutcomes({at("a")}, id, campaign_, resume); });
  };
  EXPECT_NE(open(identity(), false).find("--resume"), std::string::npos);
  EXPECT_NE(open(identity(1, 1, "another build"), true).find("another campaign"), std::string::npos);
  EXPECT_NE(open(identity(1, 2), true).find("shards"), std::string::npos);
}

TEST_F(Results, RowsThatSayNotWhatTheyAreOfAreRefused) {
  for (const std::string file : {"/outcomes.part", "/outcomes.csv"}) {
    fs::create_directories(at("a"));
    std::ofstream(at("a") + file) << rowOf(campaign_.runs[0]) << "\n";
    for (const bool resume : {false, true}) {
      EXPECT_NE(messageOf([&] { PartialOutcomes({at("a")}, identity(), campaign_, resume); }).find("without its"),
                std::string::npos)
          << file;
    }
    EXPECT_FALSE(fs::exists(at("a") + "/campaign.json")) << "the folder must not get a campaign.json";
    fs::remove_all(at("a"));
  }
}

TEST_F(Results, AStartThatWasKilledBeforeItsFirstRunIsResumed) {
  fs::create_directories(at("a"));
  std::ofstream(at("a") + "/outcomes.part");
  EXPECT_EQ(PartialOutcomes({at("a")}, identity(), campaign_, true).size(), 0u);
}

TEST_F(Results, ARunWithoutAnOutcomeIsMadeAgain) {
  const auto writeAll = [this](bool resume) {
    PartialOutcomes outcomes({at("a")}, identity(), campaign_, resume);
    std::size_t made = 0;
    for (const CampaignRun& run : campaign_.runs) {
      if (outcomes.has(run.number)) continue;
      const bool stood = run.number == 2 && !resume;
      outcomes.add(run.number, stood ? row(campaign_, run, {Ending::kNoEnd, {}}) : rowOf(run));
      ++made;
    }
    outcomes.finish();
    return made;
  };
  EXPECT_EQ(writeAll(false), 6u);
  EXPECT_NE(slurp(at("a") + "/outcomes.csv").find("no_outcome"), std::string::npos);
  EXPECT_EQ(writeAll(true), 1u);
  write("whole", identity(), campaign_.runs);
  EXPECT_EQ(slurp(at("a") + "/outcomes.csv"), slurp(at("whole") + "/outcomes.csv"));
}

TEST_F(Results, ARunThatWasMadeAgainIsKeptThoughTheRestWasNot) {
  {
    PartialOutcomes outcomes({at("a")}, identity(), campaign_, false);
    for (const CampaignRun& run : campaign_.runs)
      outcomes.add(run.number, run.number <= 2 ? row(campaign_, run, {Ending::kNoEnd, {}}) : rowOf(run));
    outcomes.finish();
  }
  {
    PartialOutcomes outcomes({at("a")}, identity(), campaign_, true);
    EXPECT_EQ(outcomes.size(), 4u);
    outcomes.add(1, rowOf(campaign_.runs[0]));  // and then the program is killed
  }
  PartialOutcomes outcomes({at("a")}, identity(), campaign_, true);
  EXPECT_TRUE(outcomes.has(1));
  EXPECT_FALSE(outcomes.has(2));
}

TEST_F(Results, OneProcessAtATimeWrites) {
  PartialOutcomes first({at("a")}, identity(), campaign_, false);
  EXPECT_NE(messageOf([this] { PartialOutcomes({at("a")}, identity(), campaign_, true); }).find("another process"),
            std::string::npos);
}

/** How often this process has a file open. */
std::size_t timesOpen(const std::string& path) {
  std::size_t count = 0;
  std::error_code none;
  for (const fs::directory_entry& entry : fs::directory_iterator("/proc/self/fd"))
    count += fs::equivalent(entry.path(), path, none) ? 1 : 0;
  return count;
}

TEST_F(Results, WhoWaitsForAProcessThatFinishesFindsAllDone) {
  auto first = std::make_unique<PartialOutcomes>(OutputPaths{at("a")}, identity(), campaign_, false);
  for (const CampaignRun& run : campaign_.runs)
    first->add(run.number, rowOf(run));
  std::size_t found = 0;
  std::string said;
  std::atomic<bool> has_ended{false};
  std::thread second([&] {
    said = messageOf([&] { found = PartialOutcomes({at("a")}, identity(), campaign_, true, /*lock_wait=*/60).size(); });
    has_ended = true;
  });
  while (timesOpen(at("a") + "/outcomes.part") < 2 && !has_ended)
    std::this_thread::yield();
  first->finish();
  first.reset();
  second.join();
  EXPECT_EQ(said, "");
  EXPECT_EQ(found, 6u);
}

TEST_F(Results, MergedShardsAreTheBytesOfOneMachine) {
  write("whole", identity(), campaign_.runs);
  for (std::size_t shard = 1; shard <= 4; ++shard)
    writeShard("s" + std::to_string(shard), shard, 4);
  mergeShards({at("s3"), at("s1"), at("s4"), at("s2")}, at("merged"));
  EXPECT_EQ(slurp(at("merged") + "/outcomes.csv"), slurp(at("whole") + "/outcomes.csv"));
  EXPECT_EQ(slurp(at("merged") + "/campaign.json"), slurp(at("whole") + "/campaign.json"));
}

TEST_F(Results, ShardsThatAreNotAPartitionAreRefused) {
  writeShard("s1", 1, 2);
  writeShard("s2", 2, 2);
  writeShard("also1", 1, 2);
  writeShard("third", 2, 3);
  write("short", identity(2, 2), {});
  write("overlap", identity(2, 2), campaign_.runs);
  write("foreign", identity(2, 2, "another build"), shardOf(campaign_.runs, 2, 2));
  const auto merge = [this](const std::string& other) {
    return messageOf([&] { mergeShards({at("s1"), at(other)}, at("merged")); });
  };
  EXPECT_NE(messageOf([this] { mergeShards({at("s1")}, at("merged")); }).find("1 shards of 2"), std::string::npos);
  EXPECT_NE(merge("also1").find("given already"), std::string::npos);
  EXPECT_NE(merge("third").find("of 3 shards"), std::string::npos);
  EXPECT_NE(merge("short").find("3 runs of 6"), std::string::npos);
  EXPECT_NE(merge("overlap").find("given twice"), std::string::npos);
  EXPECT_NE(merge("foreign").find("another campaign"), std::string::npos);
  EXPECT_NE(merge("nowhere").find("cannot be read"), std::string::npos);
  EXPECT_FALSE(fs::exists(at("merged"))) << "nothing is written";
  EXPECT_EQ(merge("s2"), "");
}

/** Every cell by its column, as doc/campaign.md has them. */
TEST_F(Results, EveryColumnHasItsOwnNumberInItsUnit) {
  CampaignRun run = campaign_.runs[0];
  run.seed = 12;
  run.motion_seed = 99;
  run.repetition = 3;
  run.phase = Phase::kHoming;
  Fault& fault = run.plan.faults[0];
  fault.arm = fault.channel = -1;
  fault.value = -7.0;
  fault.low = 1.5;
  fault.high = 2.5;
  fault.first_tick = 700;
  fault.duration_ticks = 64;
  fault.half_period_ticks = 5;
  RunResult result;
  Figures& figures = result.figures;
  figures.injected = 1;
  figures.deviation = {0.0001, 0.0004};
  figures.max_jump = 0.0008;
  figures.software_stop = 240;
  figures.plc_stop = 200;
  figures.force = 12;
  figures.max_force = 1.234;
  figures.motion = {0.002, 0.001};
  figures.golden_motion = {0.004, 0.003};
  figures.is_finite = 0;
  const std::string line = row(campaign_, run, result);
  const std::map<std::string, std::string> wanted{{"seed", "12"},
                                                  {"injection", "11"},
                                                  {"phase", "homing"},
                                                  {"host", "robot"},
                                                  {"variable", "dac"},
                                                  {"kind", "stuck_at"},
                                                  {"site", "put_usb_packet"},
                                                  {"arm", "both"},
                                                  {"channel", "all"},
                                                  {"value", "-7"},
                                                  {"low", "1.5"},
                                                  {"high", "2.5"},
                                                  {"first_tick", "700"},
                                                  {"repetition", "3"},
                                                  {"duration_ticks", "64"},
                                                  {"half_period_ticks", "5"},
                                                  {"motion_seed", "99"},
                                                  {"injected_ms", "1"},
                                                  {"deviation_mm", "0.4000"},
                                                  {"jump_mm", "0.8000"},
                                                  {"jump_ms", ""},
                                                  {"estop", "both"},
                                                  {"estop_ms", "200"},
                                                  {"seen", "1"},
                                                  {"reported", "0"},
                                                  {"force_ms", "12"},
                                                  {"force_n", "1.234"},
                                                  {"motion_mm", "2.0000"},
                                                  {"program", "running"},
                                                  {"finite", "0"},
                                                  {"golden_motion_mm", "4.0000"},
                                                  {"outcome", "unsafe_jump"}};
  for (const auto& [column, value] : wanted)
    EXPECT_EQ(cell(line, column), value) << column;
  figures.golden_motion = {0.003, 0.005};
  figures.program = ProgramState::kHung;
  EXPECT_EQ(cell(row(campaign_, run, result), "golden_motion_mm"), "5.0000") << "of the arm that moved more";
  EXPECT_EQ(cell(row(campaign_, run, result), "program"), "hung");
  figures.program = ProgramState::kCrashed;
  EXPECT_EQ(cell(row(campaign_, run, result), "program"), "crashed");
}

TEST_F(Results, AnotherShardIsNotResumed) {
  writeShard("a", 1, 2);
  EXPECT_NE(messageOf([this] { PartialOutcomes({at("a")}, identity(2, 2), campaign_, true); }).find("is shard 1"),
            std::string::npos);
  EXPECT_EQ(messageOf([this] { PartialOutcomes({at("a")}, identity(1, 2), campaign_, true); }), "");
}

/** Limits the size of all files that this process writes. */
void limitFileSize(rlim_t bytes) {
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit limit{};
  getrlimit(RLIMIT_FSIZE, &limit);
  limit.rlim_cur = bytes;
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &limit), 0);
}

TEST_F(Results, ARowThatTheDiskRefusedIsNotThere) {
  PartialOutcomes outcomes({at("a")}, identity(), campaign_, false);
  outcomes.add(1, rowOf(campaign_.runs[0]));
  limitFileSize(fs::file_size(at("a") + "/outcomes.part"));
  const std::string said = messageOf([&] { outcomes.add(2, rowOf(campaign_.runs[1])); });
  limitFileSize(RLIM_INFINITY);
  EXPECT_NE(said.find("cannot be written"), std::string::npos);
  EXPECT_FALSE(outcomes.has(2));
  EXPECT_EQ(outcomes.size(), 1u);
}

TEST_F(Results, ExplanationsGoWithTheMergedTable) {
  for (std::size_t shard = 1; shard <= 2; ++shard) {
    const std::string name = "s" + std::to_string(shard);
    writeShard(name, shard, 2);
    std::ofstream(OutputPaths{at(name)}.explanations("six")) << "# why\n";
  }
  mergeShards({at("s1"), at("s2")}, at("merged"));
  EXPECT_EQ(slurp(OutputPaths{at("merged")}.explanations("six")), "# why\n");
}

TEST_F(Results, NoCampaignIsMergedOverAnother) {
  writeShard("s1", 1, 2);
  writeShard("s2", 2, 2);
  write("whole", identity(), {});
  const std::string before = slurp(at("whole") + "/outcomes.csv");
  EXPECT_NE(messageOf([this] {
              mergeShards({at("s1"), at("s2")}, at("whole"));
            }).find("already holds"),
            std::string::npos);
  EXPECT_EQ(slurp(at("whole") + "/outcomes.csv"), before);
}

TEST_F(Results, ARowBeyondTheCampaignIsRefused) {
  writeShard("s1", 1, 2);
  writeShard("s2", 2, 2);
  CampaignRun seventh = campaign_.runs[5];
  seventh.number = 7;
  std::ofstream(at("s2") + "/outcomes.csv", std::ios::app) << rowOf(seventh) << "\n";
  EXPECT_NE(messageOf([this] {
              mergeShards({at("s1"), at("s2")}, at("merged"));
            }).find("is no outcome of this"),
            std::string::npos);
}

}  // namespace
}  // namespace raven2_trainer::campaign
