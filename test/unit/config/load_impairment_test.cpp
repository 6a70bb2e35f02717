#include "raven2_trainer/config/load_impairment.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::config {
namespace {

namespace fs = std::filesystem;

const std::string kFolder = RAVEN2_TRAINER_SOURCE_DIR "/config/impairments";

class LoadImpairment : public ::testing::Test {
 protected:
  void SetUp() override {
    path_ = fs::temp_directory_path() / ("raven2_impairment_" + std::to_string(getpid()) + ".yaml");
  }
  void TearDown() override { fs::remove(path_); }

  /** The error message for a file with this content; empty: the file is accepted. */
  std::string message(const std::string& content) const {
    std::ofstream(path_) << content;
    try {
      loadImpairment(path_.string());
    } catch (const ConfigException& e) {
      return e.what();
    }
    return "";
  }

  fs::path path_;
};

TEST_F(LoadImpairment, EveryPresetIsGood) {
  const std::vector<std::string> names = impairmentNames(kFolder);
  EXPECT_EQ(names.size(), 12U);
  for (const std::string& name : names)
    EXPECT_EQ(findImpairment(kFolder, name).name, name);
}

TEST_F(LoadImpairment, PublishedFiguresArriveInNanosecondsAndPackets) {
  const Impairment delay = findImpairment(kFolder, "net_delay_1");
  EXPECT_EQ(delay.delay.constant_ns, 70'000'000);
  ASSERT_EQ(delay.delay.branches.size(), 2U);
  EXPECT_DOUBLE_EQ(delay.delay.branches[1].mean_ns, 1e6 / 0.08529);
  const Impairment loss = findImpairment(kFolder, "net_loss_50");
  EXPECT_TRUE(loss.pareto_bursts.is_on);
  EXPECT_DOUBLE_EQ(loss.pareto_bursts.bad.lambda, 6.049);
  EXPECT_EQ(findImpairment(kFolder, "comm_loss_10").cuts.pause_ns, 8'500'000'000);
}

TEST_F(LoadImpairment, AFileThatNamesNothingIsAPerfectLink) {
  EXPECT_EQ(message("meaning: nothing\n"), "");
  const Impairment impairment = loadImpairment(path_.string());
  EXPECT_EQ(impairment.loss, 0.0);
  EXPECT_EQ(impairment.delay.constant_ns, 0);
  EXPECT_FALSE(impairment.pareto_bursts.is_on);
}

TEST_F(LoadImpairment, OutagesRunsAndABottleneckArriveFromTheirKeys) {
  ASSERT_EQ(message("meaning: m\n"
                    "outages:\n  - {from_s: 3, to_s: 4.5}\n  - {from_s: 0, to_s: 0.25}\n"
                    "loss_runs: {probability: 0.125, packets: 7}\n"
                    "rate: {kbit_per_s: 250, queue_ms: 40}\n"
                    "reordering: {probability: 0.5, depth: 6, longest_ms: 30}\n"
                    "cuts: {first_s: 1, shortest_s: 2, longest_s: 3, pause_s: 4}\n"),
            "");
  const Impairment c = loadImpairment(path_.string());
  ASSERT_EQ(c.outages.size(), 2U);
  EXPECT_EQ(c.outages[0].from_ns, 3'000'000'000);
  EXPECT_EQ(c.outages[0].to_ns, 4'500'000'000);
  EXPECT_EQ(c.outages[1].from_ns, 0);
  EXPECT_EQ(c.outages[1].to_ns, 250'000'000);
  EXPECT_EQ(c.loss_runs.probability, 0.125);
  EXPECT_EQ(c.loss_runs.packets, 7);
  EXPECT_EQ(c.rate.bits_per_s, 250e3);
  EXPECT_EQ(c.rate.queue_ns, 40'000'000);
  EXPECT_EQ(c.reordering.probability, 0.5);
  EXPECT_EQ(c.reordering.depth, 6);
  EXPECT_EQ(c.reordering.longest_ns, 30'000'000);
  EXPECT_EQ(c.cuts.first_ns, 1'000'000'000);
  EXPECT_EQ(c.cuts.shortest_ns, 2'000'000'000);
  EXPECT_EQ(c.cuts.longest_ns, 3'000'000'000);
  EXPECT_EQ(c.cuts.pause_ns, 4'000'000'000);
}

TEST_F(LoadImpairment, MistakesAreToldWithFileAndLine) {
  const std::string place = path_.string();
  const auto told = [&](const std::string& content, const std::string& line, const std::string& what) {
    const std::string said = message("meaning: m\n" + content);
    EXPECT_NE(said.find(place + ":" + line + ": "), std::string::npos) << said;
    EXPECT_NE(said.find(what), std::string::npos) << said;
  };
  told("loss:\n  probability: 1.5\n", "3", "expected [0, 1]");
  told("loss:\n  probability: .nan\n", "3", "expected [0, 1]");
  told("loss:\n  probability: 0.5\n  share: 1\n", "4", "unknown key loss/share");
  told("losses:\n  probability: 0.5\n", "2", "unknown key losses");
  told("rate:\n  kbit_per_s: 100\n", "3", "rate/queue_ms is missing");
  told("corruption: {probability: 0.1, bits: 65, streams: false}\n", "2", "expected [1, 64]");
  told("cuts: {first_s: 0, shortest_s: 2, longest_s: 1, pause_s: 1}\n", "2", "below shortest_s");
  told("cuts: {first_s: 0, shortest_s: 0, longest_s: 1, pause_s: 0}\n", "2", "never be up");
  told("outages:\n  - {from_s: 3, to_s: 3}\n", "3", "not behind from_s");
  told(
      "delay:\n  constant_ms: 0\n  uniform_ms: 0\n  normal_ms: 0\n  pareto_scale_ms: 0\n  pareto_alpha: 2\n"
      "  hyper_exponential: [{weight: 0.5, rate_per_ms: 1}]\n  interval_ms: 0\n  overtaking: false\n",
      "8", "add up to 0.5");
}

TEST_F(LoadImpairment, AnUnknownPresetNamesTheKnownOnes) {
  try {
    findImpairment(kFolder, "net_delay_9");
    FAIL();
  } catch (const ConfigException& e) {
    EXPECT_NE(std::string(e.what()).find("net_delay_3"), std::string::npos) << e.what();
  }
}

TEST_F(LoadImpairment, TheFolderIsTheOneThatTheRootFileNames) {
  const fs::path folder = fs::temp_directory_path() / ("raven2_presets_" + std::to_string(getpid()));
  fs::create_directories(folder / "impairments");
  fs::create_directories(folder / "links");
  const std::string root = (folder / "trainer.yaml").string();
  const auto named = [&](const std::string& name) {
    std::ofstream(root) << "impairments: " << name << "\n";
    return impairmentFolder(root);
  };
  EXPECT_EQ(named("impairments"), (folder / "impairments").string());
  EXPECT_EQ(named("links"), (folder / "links").string());
  EXPECT_EQ(named("nowhere"), impairmentFolder("")) << "the packaged one";
  fs::remove_all(folder);
}

/** An outage must end later than it begins. */
TEST_F(LoadImpairment, AnOutageEndsLaterThanItBegins) {
  for (const char* to : {"2.5", "3", "0"})
    EXPECT_NE(
        message(std::string("meaning: m\noutages:\n  - {from_s: 3, to_s: ") + to + "}\n").find("not behind from_s"),
        std::string::npos)
        << to;
  EXPECT_EQ(message("meaning: m\noutages:\n  - {from_s: 3, to_s: 3.001}\n"), "");
}

}  // namespace
}  // namespace raven2_trainer::config
