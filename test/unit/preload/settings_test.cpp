#include "raven2_trainer/preload/settings.h"

#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>

#include "raven2_trainer/preload/ground_truth.h"
#include "support/yaml_file.h"

namespace raven2_trainer::preload {
namespace {

using testing::TemporaryFile;

const std::string kFaults = std::string(RAVEN2_TRAINER_SOURCE_DIR) + "/config/faults/";

std::string textOf(const std::string& path) {
  std::ostringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

/** Both keys, and the sudden jump. */
struct SettingsTest : ::testing::Test {
  TemporaryFile keys{"injection.yaml", "enable: true\nreal_robot: true\n"};
  std::map<std::string, std::string> environment{{"RAVEN2_USB_FAULTS", kFaults + "sudden_jump.yaml"},
                                                 {"RAVEN2_USB_FAULTS_I_KNOW", kPhrase},
                                                 {"RAVEN2_USB_FAULTS_INJECTION", keys.path()}};

  Order order() const {
    return orderOf(settingsFrom([this](const char* name) -> const char* {
      const auto found = environment.find(name);
      return found == environment.end() ? nullptr : found->second.c_str();
    }));
  }
  /** The error message for these settings; "" if they are accepted. */
  std::string refusal() const {
    try {
      order();
    } catch (const ConfigException& e) {
      return e.what();
    }
    return "";
  }
  bool isRefused(const std::string& saying) const { return refusal().find(saying) != std::string::npos; }

  void write(const std::string& name, const std::string& text) {
    const std::string path = keys.folder() + "/" + name;
    std::ofstream(path) << text;
    environment["RAVEN2_USB_FAULTS"] = path;
  }
  /** sudden_jump under its own name, changed. */
  void change(const std::string& from, const std::string& to) {
    write("sudden_jump.yaml", testing::replaced(textOf(kFaults + "sudden_jump.yaml"), from, to));
  }
};

TEST_F(SettingsTest, BothKeysAndAScenarioAreAnOrder) {
  const Order made = order();
  EXPECT_EQ(made.scenario.name, "sudden_jump");
  ASSERT_EQ(made.plan.count, 1U);
  EXPECT_EQ(made.plan.faults[0].variable, FaultVariable::kDac);
  EXPECT_EQ(made.plan.faults[0].first_tick, 8000);
  EXPECT_EQ(made.plan.faults[0].seed, made.scenario.faults[0].seed + 1) << "the packaged seed";
}

TEST_F(SettingsTest, EachKeyIsDemanded) {
  for (const char* phrase : {"", "yes", "Nobody_is_within_reach", "nobody_is_within_reach "}) {
    environment["RAVEN2_USB_FAULTS_I_KNOW"] = phrase;
    EXPECT_TRUE(isRefused("the first key is missing")) << phrase;
  }
  environment["RAVEN2_USB_FAULTS_I_KNOW"] = kPhrase;
  for (const char* text : {"enable: true\nreal_robot: false\n", "enable: false\nreal_robot: true\n"}) {
    std::ofstream(keys.path()) << text;
    EXPECT_TRUE(isRefused("the second key is missing")) << text;
  }
  std::ofstream(keys.path()) << "enable: true\n";
  EXPECT_TRUE(isRefused("injection.yaml:1: real_robot")) << refusal();
  environment.erase("RAVEN2_USB_FAULTS_INJECTION");
  EXPECT_TRUE(isRefused("the second key is missing"));
  environment.erase("RAVEN2_USB_FAULTS");
  EXPECT_TRUE(isRefused("names no scenario"));
}

TEST_F(SettingsTest, ThePackagedKeyIsNotTurned) {
  environment["RAVEN2_USB_FAULTS_INJECTION"] = std::string(RAVEN2_TRAINER_SOURCE_DIR) + "/config/injection.yaml";
  EXPECT_TRUE(isRefused("real_robot"));
}

TEST_F(SettingsTest, AWrongScenarioIsRefusedWithItsLine) {
  environment["RAVEN2_USB_FAULTS"] = "/nowhere/sudden_jump.yaml";
  EXPECT_TRUE(isRefused("/nowhere/sudden_jump.yaml")) << refusal();
  change("value: 800", "value: eight");
  EXPECT_TRUE(isRefused("sudden_jump.yaml:27: ")) << refusal();
  change("kind: stuck_at", "kind: drop");
  EXPECT_TRUE(isRefused("sudden_jump.yaml:24: ")) << refusal();
}

TEST_F(SettingsTest, WhatActsInsideOfTheProgramIsRefusedWithItsLine) {
  change("site: put_usb_packet", "site: torque_to_dac");
  EXPECT_FALSE(refusal().empty()) << "no such variable there";
  environment["RAVEN2_USB_FAULTS"] = kFaults + "dac_minus1000.yaml";
  EXPECT_TRUE(isRefused("site is inside of the program")) << refusal();
  EXPECT_TRUE(isRefused("dac_minus1000.yaml:")) << refusal();
  environment["RAVEN2_USB_FAULTS"] = kFaults + "surgeon_cmd_clean_sim.yaml";
  EXPECT_TRUE(isRefused("host is not robot")) << refusal();
  environment["RAVEN2_USB_FAULTS"] = kFaults + "put_usb_board_count.yaml";
  EXPECT_TRUE(isRefused("more boards than there are")) << refusal();
  environment["RAVEN2_USB_FAULTS"] = kFaults + "guided_exchange_overshoot.yaml";
  EXPECT_FALSE(refusal().empty());
  change("{trigger: pedal_down, first_tick: 8000}", "{trigger: tool_change, first_tick: 8000}");
  EXPECT_TRUE(isRefused("sudden_jump.yaml:28: ")) << refusal();
  EXPECT_TRUE(isRefused("nobody sees there")) << refusal();
}

TEST_F(SettingsTest, TheThreeRowsOfTable1CanAllBeDone) {
  for (const char* name : {"unavailable_recoverable", "unavailable_permanent", "sudden_jump"}) {
    environment["RAVEN2_USB_FAULTS"] = kFaults + name + ".yaml";
    EXPECT_EQ(refusal(), "") << name;
  }
}

TEST_F(SettingsTest, NumbersAreWholeAndInRange) {
  for (const char* seed : {"", "-1", "1.5", "one", "0x10", " 1", "9007199254740993"}) {
    environment["RAVEN2_USB_FAULTS_SEED"] = seed;
    EXPECT_TRUE(isRefused("RAVEN2_USB_FAULTS_SEED")) << seed;
  }
  Settings settings;
  EXPECT_EQ(portOf(settings), 36000);
  settings.port = "65536";
  EXPECT_THROW(portOf(settings), ConfigException);
}

TEST_F(SettingsTest, TheTruthHasEachActivationOnce) {
  const Order made = order();
  faults::FaultEngine engine(FaultHost::kRobot);
  engine.setPlan(made.plan);
  ChangeLog log, none;
  for (std::uint64_t cycle = 1; cycle <= 16101; ++cycle) {
    engine.beginCycle({true, 3, {}});
    log.note(&engine, cycle, static_cast<std::int64_t>(cycle) * 10, static_cast<std::uint32_t>(cycle) / 2);
  }
  const auto truth = nlohmann::json::parse(describeTruth(made, {log, none, 16101, 7, 1234, 5678}));
  const auto& injections = truth["injections"];
  ASSERT_EQ(injections.size(), 2U);
  EXPECT_EQ(injections[0]["inject"]["cycle"], 8001);
  EXPECT_EQ(injections[0]["clear"]["cycle"], 8301);
  EXPECT_EQ(injections[0]["clear"]["time_ns"], 83010);
  EXPECT_EQ(injections[0]["clear"]["command"], 4150);
  EXPECT_EQ(truth["monotonic_offset_ns"], 1234);
  EXPECT_EQ(truth["ended_ns"], 5678);
  EXPECT_EQ(injections[1]["inject"]["cycle"], 16001);
  EXPECT_TRUE(injections[1]["clear"].is_null()) << "it lasted to the end";
  EXPECT_EQ(injections[0]["variable"], "dac");
  EXPECT_EQ(injections[0]["arm"], "gold");
  EXPECT_EQ(truth["packets"], 7);
  EXPECT_EQ(truth["changes_lost"], 0);
}

TEST_F(SettingsTest, EachVariableOfTheEnvironmentHasItsOwnPlace) {
  const std::map<std::string, std::string Settings::*> places{
      {"", &Settings::scenario},    {"_I_KNOW", &Settings::phrase}, {"_INJECTION", &Settings::injection},
      {"_TRUTH", &Settings::truth}, {"_GOLD", &Settings::gold},     {"_GREEN", &Settings::green},
      {"_PORT", &Settings::port},   {"_SEED", &Settings::seed}};
  const Settings defaults;
  for (const auto& [ending, place] : places) {
    const std::string variable = "RAVEN2_USB_FAULTS" + ending;
    const Settings settings =
        settingsFrom([&](const char* name) -> const char* { return name == variable ? "other" : nullptr; });
    for (const auto& [unset, kept] : places)
      EXPECT_EQ(settings.*kept, unset == ending ? "other" : defaults.*kept) << variable << " and " << unset;
  }
}

TEST_F(SettingsTest, PortsAreThoseOfUdp) {
  Settings settings;
  for (const char* port : {"1", "36000", "65535"}) {
    settings.port = port;
    EXPECT_EQ(std::to_string(portOf(settings)), port);
  }
  for (const char* port : {"", "0", "65536", "-1", "36000 "}) {
    settings.port = port;
    EXPECT_THROW(portOf(settings), ConfigException) << port;
  }
}

TEST_F(SettingsTest, TheShownLevelOfThePlcIsInsideOfTheProgram) {
  environment["RAVEN2_USB_FAULTS"] = kFaults + "plc_state_bogus.yaml";  // site of the pins, which are at the boundary
  EXPECT_TRUE(isRefused("site is inside of the program")) << refusal();
}

TEST_F(SettingsTest, BoardsToWriteToAreTwoAtMost) {
  const std::string rows = textOf(kFaults + "put_usb_board_count.yaml");
  const std::size_t at = rows.find("value: ");
  ASSERT_NE(at, std::string::npos);
  const std::string line = rows.substr(at, rows.find('\n', at) - at);
  for (const char* count : {"0", "1", "2", "3"}) {
    write("put_usb_board_count.yaml", testing::replaced(rows, line, std::string("value: ") + count));
    EXPECT_EQ(isRefused("more boards than there are"), std::string(count) > "2") << count << ": " << refusal();
  }
}

TEST_F(SettingsTest, TheTruthHasTheRowsOfBothThreadsWithTheirArms) {
  Order made = order();
  Fault row = made.scenario.faults[0];
  made.scenario.faults.clear();
  for (const std::int8_t arm : {std::int8_t{0}, std::int8_t{1}, std::int8_t{-1}}) {
    row.arm = arm;
    row.row = static_cast<std::uint8_t>(made.scenario.faults.size());
    made.scenario.faults.push_back(row);
  }
  const auto logOf = [&](std::size_t first, std::size_t last, std::size_t room) {
    auto log = std::make_unique<ChangeLog>(room);
    faults::FaultEngine engine(FaultHost::kRobot);
    FaultPlan plan;
    plan.generation = plan.session = 1;
    for (std::size_t i = first; i < last; ++i) {
      Fault& fault = plan.faults[plan.count++] = made.scenario.faults[i];
      fault.trigger = FaultTrigger::kPowerOn;
      fault.first_tick = 0;
      fault.duration_ticks = 5;
      fault.period_ticks = 10;
    }
    engine.setPlan(plan);
    for (std::uint64_t cycle = 1; cycle <= 12; ++cycle) {
      engine.beginCycle({});
      log->note(&engine, cycle, 0, 0);
    }
    return log;
  };
  const auto boards = logOf(0, 2, 100), network = logOf(2, 3, 1);
  const auto truth = nlohmann::json::parse(describeTruth(made, {*boards, *network, 12, 0, 0, 0}));
  std::map<std::string, int> of_arm;
  for (const auto& injection : truth["injections"]) {
    ++of_arm[injection["arm"].get<std::string>()];
    const bool is_second = injection["inject"]["cycle"] == 11;
    EXPECT_EQ(injection["clear"].is_null(), is_second || injection["arm"] == "both") << injection.dump();
  }
  EXPECT_EQ(of_arm, (std::map<std::string, int>{{"gold", 2}, {"green", 2}, {"both", 1}}));
  EXPECT_EQ(truth["changes_lost"], 2) << "the network's log has room for one of three";
}

TEST(ChangeLog, WhatHasNoRoomIsCounted) {
  Fault flicker;
  flicker.variable = FaultVariable::kDac;
  flicker.site = FaultSite::kPutUsbPacket;
  flicker.kind = FaultKind::kStuckAt;
  flicker.trigger = FaultTrigger::kPowerOn;
  flicker.duration_ticks = 1;
  flicker.period_ticks = 2;
  FaultPlan plan;
  plan.generation = 1;
  plan.count = 1;
  plan.faults[0] = flicker;
  faults::FaultEngine engine(FaultHost::kRobot);
  engine.setPlan(plan);
  ChangeLog log(3);
  for (std::uint64_t cycle = 1; cycle <= 6; ++cycle) {
    engine.beginCycle({});
    log.note(&engine, cycle, 0, 0);
  }
  EXPECT_EQ(log.size(), 3U);
  EXPECT_EQ(log.lost(), 3U);
  EXPECT_EQ(log[2].change.cycle, 3U);
}

}  // namespace
}  // namespace raven2_trainer::preload
