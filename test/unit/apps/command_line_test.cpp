#include "apps/common/command_line.h"

#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

#include "apps/common/csv_table.h"
#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::apps {
namespace {

CommonOptions parsed(const std::string& arguments) {
  CLI::App app;
  CommonOptions options;
  options.add(&app, /*with_ports=*/true);
  app.parse(arguments);
  return options;
}

TEST(CommonOptions, EachPortIsItsOwn) {
  const CommonOptions options =
      parsed("--master-port 1001 --robot-port 1002 --force-port 1003 --sight-port 1004 --state-port 1005");
  const NetworkConfig network = options.load().network;
  EXPECT_EQ(network.master_port, 1001);
  EXPECT_EQ(network.robot_port, 1002);
  EXPECT_EQ(network.force_port, 1003);
  EXPECT_EQ(network.sight_port, 1004);
  EXPECT_EQ(network.state_port, 1005);
}

TEST(CommonOptions, ZeroIsAValueAndNothingIsTheConfigurations) {
  const TrainerConfig packaged = parsed("").load(), zero = parsed("--master-port 0 --seed 0").load();
  EXPECT_EQ(zero.network.master_port, 0) << "a free port";
  EXPECT_NE(packaged.network.master_port, 0);
  EXPECT_EQ(zero.seed, 0U);
  EXPECT_NE(packaged.seed, 0U);
  EXPECT_EQ(zero.network.robot_port, packaged.network.robot_port);
}

TEST(CommonOptions, WhatIsOutOfRangeIsRefusedBeforeAnythingIsRead) {
  for (const char* bad :
       {"--master-port 65536", "--master-port -1", "--robot-port 0", "--force-port 0", "--sight-port 0",
        "--state-port 65536", "--seed -1", "--seed 9007199254740993", "--arm-contacts maybe"})
    EXPECT_THROW(parsed(bad), CLI::ParseError) << bad;
}

TEST(CommonOptions, ArmContactsAreThoseOfBothArms) {
  for (const bool is_on : {true, false}) {
    for (const bool touches : parsed(std::string("--arm-contacts ") + (is_on ? "on" : "off")).load().model.arm_contacts)
      EXPECT_EQ(touches, is_on);
  }
}

TEST(CommonOptions, AHazardIsKnownAndADrillTakesItsPlace) {
  EXPECT_EQ(parsed("--hazard none").load().hazard, "none");
  EXPECT_THROW(parsed("--hazard meteor").load(), ConfigException);
  const TrainerConfig drilled = parsed("--hazard none --exercise camera_clutch --drill own").load();
  EXPECT_EQ(drilled.hazard, drilled.drill);
  EXPECT_NE(drilled.hazard, "none");
}

int run(std::vector<std::string> words, const std::function<int()>& body) {
  words.insert(words.begin(), "/somewhere/program");
  std::vector<char*> argv;
  for (std::string& word : words)
    argv.push_back(word.data());
  CLI::App app{"Does nothing."};
  double value = 0.0;
  app.add_option("--value", value, "A number")->check(CLI::Range(0.0, 1.0));
  std::vector<double> list;
  app.add_option("--list", list, "Numbers")->delimiter(',')->check(CLI::Range(0.0, 1.0));
  std::string text;
  app.add_option("--text", text, "A word");
  ::testing::internal::CaptureStderr();
  ::testing::internal::CaptureStdout();
  const int status = runProgram(&app, static_cast<int>(argv.size()), argv.data(), body);
  ::testing::internal::GetCapturedStdout();
  ::testing::internal::GetCapturedStderr();
  return status;
}

/** doc/interfaces.md. */
TEST(RunProgram, TheStatusSaysHowItEnded) {
  EXPECT_EQ(run({}, [] { return 0; }), 0);
  EXPECT_EQ(run({"--value", "0.5"}, [] { return 7; }), 7) << "the program's exit code";
  EXPECT_EQ(run({}, []() -> int { throw ConfigException("no"); }), 1);
  EXPECT_EQ(run({}, []() -> int { throw std::runtime_error("no"); }), 1);
  EXPECT_EQ(run({}, []() -> int { throw CsvException("stdin:1: no"); }), 2);
}

TEST(DescribeSession, TellsWhatWasAskedForAndWhatWasNot) {
  TrainerConfig config;
  config.hazard = "sudden_jump";
  EXPECT_EQ(describeSession(config, ""), "free session, hazard sudden_jump, trainee none, driver not named");
  config.exercise_name = "peg_transfer";
  config.drill = "master_sluggish";
  config.trainee = "tim";
  EXPECT_EQ(describeSession(config, "expert"),
            "exercise peg_transfer, drill master_sluggish, trainee tim, driver expert");
}

TEST(RunProgram, WrongArgumentsAndHelpDoNotRunIt) {
  bool has_run = false;
  const auto body = [&] { return has_run = true, 0; };
  for (const std::vector<std::string>& wrong : std::vector<std::vector<std::string>>{{"--no-such"},
                                                                                     {"--value", "2"},
                                                                                     {"--value", "x"},
                                                                                     {"--value", "nan"},
                                                                                     {"--value=nan"},
                                                                                     {"--value=-NaN"},
                                                                                     {"--value", "NAN"},
                                                                                     {"--value", "-nan"},
                                                                                     {"--value=+nan"},
                                                                                     {"--value", "nan(1)"},
                                                                                     {"--list", "0.1,nan"},
                                                                                     {"--list=nan,0.1"},
                                                                                     {"--list", "0.1", "-nan"}})
    EXPECT_GT(run(wrong, body), 100) << wrong.back();
  EXPECT_EQ(run({"--help"}, body), 0);
  EXPECT_EQ(run({"--version"}, body), 0);
  EXPECT_FALSE(has_run);
}

TEST(RunProgram, AWordMaySpellNan) {
  EXPECT_EQ(run({"--text", "nan"}, [] { return 0; }), 0) << "a trainee may be called so";
}

TEST(RunProgram, RemappingsOfRosAreNotItsArguments) {
  EXPECT_EQ(run({"__name:=other", "--value", "0.5", "_p:=1", "/a:=/b"}, [] { return 0; }), 0);
}

}  // namespace
}  // namespace raven2_trainer::apps
