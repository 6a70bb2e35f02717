#include "config/readers.h"

#include <gtest/gtest.h>

#include <array>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/config/load_scenario.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/faults/arming.h"

// Single files of the configuration, with values put in the place of the packaged ones.

namespace raven2_trainer::config {
namespace {

const std::string kFolder = RAVEN2_TRAINER_SOURCE_DIR "/config/";

template <typename Config>
Config readWith(void (*read)(Section&, Config*), const std::string& file, const Overrides& overrides) {
  Section root = Section::fromFile(kFolder + file + ".yaml");
  for (const Override& each : overrides)
    root.put(each);
  Config config{};
  read(root, &config);
  root.finish();
  return config;
}

void readPackagedNetwork(Section& root, NetworkConfig* c) {
  HapticGains haptics;
  haptics.max_force = 3.3;
  haptics.max_slew = 140.0;
  readNetwork(root, haptics, c);
}

NetworkConfig network(const Overrides& overrides) {
  return readWith(readPackagedNetwork, "network", overrides);
}

/** The error message for network.yaml; empty: the file is accepted. */
std::string refusal(const Overrides& overrides) {
  try {
    network(overrides);
  } catch (const ConfigException& e) {
    return e.what();
  }
  return "";
}

/** Any program that reaches the port can move the arms. Only this computer's own addresses are therefore local, and no
 *  name that only looks local. */
TEST(ReadNetwork, AnAddressThatMerelyLooksLocalIsNot) {
  for (const char* local : {"127.0.0.1", "127.1.2.3", "127.255.255.254", "localhost"})
    EXPECT_EQ(refusal({{"bind_address", local, "test"}}), "") << local;
  for (const char* remote : {"0.0.0.0", "10.127.0.1", "10.0.127.1", "1270.0.0.1", "128.0.0.1", "12.7.0.1",
                             "192.168.1.7", "127.example.org", "127.0.0.1.example.org", "localhost.lan", "127x"})
    EXPECT_NE(refusal({{"bind_address", remote, "test"}}).find("allow_plaintext_remote"), std::string::npos) << remote;
}

/** net::TcpClient checks this too, but cannot name the line of the file. */
TEST(ReadNetwork, TheLongestPauseIsNotShorterThanTheShortest) {
  const Override shortest{"reconnect_min", "0.5", "test"};
  EXPECT_NE(refusal({shortest}).find("network.yaml:13: reconnect_max is 0.4, expected [0.5, 60]"), std::string::npos);
  EXPECT_EQ(refusal({shortest, {"reconnect_max", "0.5", "test"}}), "");
}

TEST(ReadNetwork, TheTimeOutsOfBothReceiversAreTheirOwn) {
  const ItpRules itp = network({{"master_timeout", "0.3", "test"}, {"compat_timeout", "4.0", "test"}}).itp;
  EXPECT_EQ(itp.master_timeout, 0.3);
  EXPECT_EQ(itp.compat_timeout, 4.0);
}

/** A limit that another key sets is that key's value, whatever it is. */
template <typename Config>
void expectLimit(void (*read)(Section&, Config*),
                 const std::string& file,
                 const Override& key,
                 const Overrides& others) {
  Overrides all = others;
  EXPECT_NO_THROW(readWith(read, file, others)) << file;
  all.push_back(key);
  EXPECT_THROW(readWith(read, file, all), ConfigException) << file << "/" << key.key;
}

TEST(Readers, ALimitThatAnotherKeySetsFollowsThatKey) {
  const Overrides force{
      {"max_force", "1.8", "test"}, {"guidance/max_force", "1.8", "test"}, {"min_force", "1.8", "test"}};
  for (const char* key : {"min_force", "guidance/max_force", "edge/max_force"})
    expectLimit(readHaptics, "haptics", {key, "1.81", "test"}, force);
  expectLimit(readHaptics, "haptics", {"max_slew", "44.9", "test"},
              {{"max_force", "1.8", "test"}, {"max_slew", "45", "test"}});
  expectLimit(readHaptics, "haptics", {"passivity/bank", "0.039", "test"},
              {{"passivity/budget", "0.04", "test"}, {"passivity/bank", "0.04", "test"}});
  expectLimit(readHaptics, "haptics", {"edge/margin", "0.0301", "test"},
              {{"edge/size_I", "[0.07, 0.06, 0.12]", "test"}, {"edge/margin", "0.03", "test"}});
  expectLimit(readCrtk, "crtk", {"move_speed", "0.051", "test"},
              {{"max_speed", "0.05", "test"}, {"move_speed", "0.05", "test"}});
  expectLimit(readCrtk, "crtk", {"move_turn_rate", "0.61", "test"},
              {{"max_turn_rate", "0.6", "test"}, {"move_turn_rate", "0.6", "test"}});
  expectLimit(readConsole, "console", {"pause_max", "0.39", "test"},
              {{"pause_min", "0.4", "test"}, {"pause_max", "0.4", "test"}});
  expectLimit(readConsole, "console", {"tremor_high", "9.9", "test"},
              {{"tremor_low", "10", "test"}, {"tremor_high", "10", "test"}});
  expectLimit(readRender, "render", {"trails/step", "0.0999", "test"},
              {{"trails/duration", "40", "test"}, {"trails/step", "0.1", "test"}});
  expectLimit(readRender, "render", {"live/slowest", "21", "test"},
              {{"live/fps", "20", "test"}, {"live/slowest", "20", "test"}});
}

/** Commands and torques are divided by them: the plant's joints would be no numbers. */
TEST(ReadVirtualRaven, NoAxisHasNoTorqueOrCountsPerAmp) {
  for (const char* const joint : kJointNames) {
    for (const char* const key : {"torque_per_amp", "counts_per_amp"}) {
      const Override zero{std::string("axes/") + joint + "/" + key, "0", "test"};
      EXPECT_THROW(readWith(readVirtualRaven, "virtual_raven", {zero}), ConfigException) << zero.key;
    }
  }
}

/** Of each joint, on both sides of its range. */
TEST(ReadArms, TheHomePoseIsWithinTheLimitsOfEveryJoint) {
  const ArmGeometry packaged = readWith(readArms, "arms", {}).geometry;
  for (std::size_t j = 0; j < kJointCount; ++j) {
    for (const bool is_high : {false, true}) {
      JointArray home = packaged.home;
      home[j] = is_high ? packaged.q_max[j] + 0.01 : packaged.q_min[j] - 0.01;
      std::ostringstream list;
      for (const double q : home)
        list << (list.str().empty() ? "[" : ", ") << q;
      EXPECT_THROW(readWith(readArms, "arms", {{"home", list.str() + "]", "test"}}), ConfigException)
          << kJointNames[j] << is_high;
    }
  }
}

/** Values that differ between the arms are read for the right arm. */
TEST(Readers, EachArmHasItsOwnValues) {
  const ArmsConfig arms = readWith(readArms, "arms", {{"rcm_W/green", "[-0.04, -0.05, 0.15]", "test"}});
  EXPECT_EQ(arms.rcm_W[0], (Vec3{-0.03, 0.0643, 0.14}));
  EXPECT_EQ(arms.rcm_W[1], (Vec3{-0.04, -0.05, 0.15}));
  const ModelConfig model = readWith(readModel, "model", {{"arm_contacts/green", "false", "test"}});
  EXPECT_TRUE(model.arm_contacts[0]);
  EXPECT_FALSE(model.arm_contacts[1]);
  const DetectorConfig detector = readWith(
      readDetector, "detector", {{"gold/elbow/offset", "1.5", "test"}, {"green/elbow/offset", "2.5", "test"}});
  EXPECT_EQ(detector.axes[0][1].offset, 1.5);
  EXPECT_EQ(detector.axes[1][1].offset, 2.5);
}

/** A row of a scenario. */
std::string row(const std::string& kind, const std::string& arm, const std::string& value) {
  return "host: robot\nsite: put_usb_packet\nvariable: dac\nkind: " + kind + "\narm: " + arm +
         "\nchannel: shoulder\nstart: {trigger: pedal_down, first_tick: 0}\nduration_ticks: 1\nvalue: " + value + "\n";
}

Fault faultOf(const std::string& text) {
  Section section = Section::fromText(text, "ROW");
  return readFault(section, 1, {});
}

TEST(ReadFault, ActsOnTheArmThatItNames) {
  for (const auto& [arm, number] : {std::pair("gold", 0), std::pair("green", 1), std::pair("both", -1)})
    EXPECT_EQ(faultOf(row("stuck_at", arm, "800")).arm, number) << arm;
}

TEST(ReadFault, AnImpairmentIsOneOfTheFolder) {
  const auto read = [](const std::vector<std::string>& impairments) {
    Section section = Section::fromText(
        "host: relay\nsite: network_layer\nvariable: packet\nkind: impair\nvalue: wan\n"
        "start: {trigger: pedal_down, first_tick: 0}\nduration_ticks: 0\n",
        "ROW");
    return readFault(section, 1, impairments);
  };
  EXPECT_EQ(read({"net_loss_10", "wan"}).value, 1.0);
  EXPECT_THROW(read({"net_loss_10"}), ConfigException);
  EXPECT_THROW(read({}), ConfigException) << "the folder is empty, or its name is mistyped";
}

TEST(ReadFault, AFactorIsBoundedOnBothSides) {
  for (const char* good : {"-1e6", "0", "1e6"})
    EXPECT_NO_THROW(faultOf(row("scale", "gold", good))) << good;
  for (const char* bad : {"-1000001", "1000001"})
    EXPECT_THROW(faultOf(row("scale", "gold", bad)), ConfigException) << bad;
}

/** At least two packets are needed to change places. */
TEST(ReadFault, TheLimitsOfAStreamHold) {
  const auto stream = [](const std::string& kind, const std::string& value) {
    return "host: relay\nsite: network_layer\nvariable: packet\nkind: " + kind +
           "\nstart: {trigger: pedal_down, first_tick: 0}\nduration_ticks: 1\nvalue: " + value + "\n";
  };
  for (const auto& [kind, good, bad] : std::vector<std::array<const char*, 3>>{{"reorder", "2", "1"},
                                                                               {"reorder", "64", "65"},
                                                                               {"duplicate", "1", "0"},
                                                                               {"duplicate", "8", "9"},
                                                                               {"replay", "1", "0"},
                                                                               {"replay", "500", "501"},
                                                                               {"drop", "0", "-0.1"},
                                                                               {"drop", "1", "1.1"}}) {
    EXPECT_NO_THROW(faultOf(stream(kind, good))) << kind;
    EXPECT_THROW(faultOf(stream(kind, bad)), ConfigException) << kind << bad;
  }
}

/** A row that starts by `trigger`, with `threshold`. */
std::string triggered(const std::string& trigger, const std::string& threshold) {
  const std::string good = row("stuck_at", "gold", "800");
  const std::string start = "{trigger: pedal_down, first_tick: 0}";
  return std::string(good).replace(good.find(start), start.size(),
                                   "{trigger: " + trigger + ", first_tick: 0, threshold: " + threshold + "}");
}

TEST(ReadFault, BothLimitsOfAThresholdHold) {
  for (const auto& [trigger, low, high, below, above] :
       std::vector<std::array<const char*, 5>>{{"run_level", "0", "3", "-1", "4"},
                                               {"tissue_distance", "0", "10", "-0.001", "10.001"},
                                               {"target_distance", "0", "10", "-0.001", "10.001"},
                                               {"step", "1", "1000", "0", "1001"}}) {
    for (const char* good : {low, high})
      EXPECT_NO_THROW(faultOf(triggered(trigger, good))) << trigger << good;
    for (const char* bad : {below, above})
      EXPECT_THROW(faultOf(triggered(trigger, bad)), ConfigException) << trigger << bad;
  }
}

TEST(ReadFault, BothLimitsOfEveryTimeHold) {
  const std::string base = row("stuck_at", "gold", "800");
  const auto with = [&base](const std::string& from, const std::string& to) {
    return std::string(base).replace(base.find(from), from.size(), to);
  };
  for (const char* ticks : {"0", "1000000000"})
    EXPECT_NO_THROW(faultOf(with("first_tick: 0", std::string("first_tick: ") + ticks))) << ticks;
  for (const char* ticks : {"-1", "1000000001"}) {
    EXPECT_THROW(faultOf(with("first_tick: 0", std::string("first_tick: ") + ticks)), ConfigException) << ticks;
    EXPECT_THROW(faultOf(with("duration_ticks: 1", std::string("duration_ticks: ") + ticks)), ConfigException) << ticks;
    EXPECT_THROW(faultOf(base + "period_ticks: " + ticks + "\n"), ConfigException) << ticks;
    EXPECT_THROW(faultOf(base + "count: " + ticks + "\n"), ConfigException) << ticks;
    EXPECT_THROW(faultOf(base + "seed: " + ticks + "\n"), ConfigException) << ticks;
  }
  EXPECT_NO_THROW(faultOf(base + "half_period_ticks: 1\n"));
  EXPECT_THROW(faultOf(base + "half_period_ticks: 0\n"), ConfigException);
  for (const char* kind : {"ramp", "drift"}) {
    EXPECT_NO_THROW(faultOf(row(kind, "gold", "800") + "ramp_ticks: 1\n")) << kind;
    for (const char* ticks : {"0", "1000000001"})
      EXPECT_THROW(faultOf(row(kind, "gold", "800") + "ramp_ticks: " + ticks + "\n"), ConfigException) << kind << ticks;
  }
  for (const char* good : {"0.001", "1"})
    EXPECT_NO_THROW(faultOf(base + "probability: " + good + "\n")) << good;
  for (const char* bad : {"-0.001", "0", "1.001"})
    EXPECT_THROW(faultOf(base + "probability: " + bad + "\n"), ConfigException) << bad;
}

/** Every row of every scenario draws other numbers with another seed of the session. */
TEST(PlanFor, TheSeedOfTheSessionSeedsEveryFault) {
  TrainerConfig config = loadTrainerConfig(kFolder + "trainer.yaml");
  for (const Scenario& scenario : config.scenarios) {
    for (const std::uint64_t seed : {0U, 7U}) {
      config.seed = seed;
      const FaultPlan plan = faults::planFor(config, faultId(config, scenario.name), 1);
      ASSERT_EQ(plan.count, scenario.faults.size());
      for (std::size_t i = 0; i < plan.count; ++i)
        EXPECT_EQ(plan.faults[i].seed, scenario.faults[i].seed + seed) << scenario.name;
    }
  }
}

/** An encoder with half the pixels for colours takes even sizes alone. */
TEST(ReadRender, AVideoOfAnOddSizeIsAPixelSmaller) {
  const RenderConfig render =
      readWith(readRender, "render", {{"video/width", "641", "test"}, {"video/height", "361", "test"}});
  EXPECT_EQ(render.video_width, 640);
  EXPECT_EQ(render.video_height, 360);
}

/** The error message for a row; empty: it is accepted. */
std::string refusalOf(const std::string& text) {
  try {
    Section section = Section::fromText(text, "ROW");
    readFault(section, 1, {"wan"});
  } catch (const ConfigException& e) {
    return e.what();
  }
  return "";
}

TEST(ReadFault, WhatCouldNeverActIsRefusedWithTheReason) {
  const auto with = [](std::string text, const std::string& from, const std::string& to) {
    return text.replace(text.find(from), from.size(), to);
  };
  const std::string dac = row("stuck_at", "gold", "800");
  const std::string start = "start: {trigger: pedal_down, first_tick: 0}\nduration_ticks: 0\n";
  const std::string network = "host: relay\nsite: network_layer\nvariable: packet\nkind: impair\nvalue: wan\n" + start;
  const std::string gain =
      "host: console\nsite: haptic\nvariable: force_gain\nkind: stuck_at\narm: gold\nvalue: 2\n" + start;
  const std::string random = with(row("random", "gold", "800"), "value: 800", "low: 5\nhigh: 6");
  for (const std::string& good : {dac, network, gain, random})
    EXPECT_EQ(refusalOf(good), "");
  for (const auto& [bad, why] : std::vector<std::pair<std::string, const char*>>{
           {with(dac, "host: robot", "host: relay"), "does not serve that site"},
           {with(network, "host: relay", "host: master"), "impair is for host relay"},
           {with(network, "trigger: pedal_down", "trigger: packet"), "impair is for host relay"},
           {with(gain, "trigger: pedal_down", "trigger: packet"), "are no packets"},
           {with(dac, "duration_ticks: 1", "duration_ticks: 0") + "period_ticks: 8\n", "can never come"},
           {dac + "half_period_ticks: 2\n", "never comes"},
           {dac + "count: 2\n", "can never be reached"},
           {with(random, "high: 6", "high: 5"), "is not above low"}})
    EXPECT_NE(refusalOf(bad).find(why), std::string::npos) << why << ": " << refusalOf(bad);
}

}  // namespace
}  // namespace raven2_trainer::config
