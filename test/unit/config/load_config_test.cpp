#include "raven2_trainer/config/load_config.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>

#include "raven2_trainer/config/share_folder.h"
#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::config {
namespace {

namespace fs = std::filesystem;

/** A copy of the packaged configuration that a test may spoil. */
class LoadConfig : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("raven2_config_" + std::to_string(getpid()));
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    for (const fs::directory_entry& entry : fs::directory_iterator(RAVEN2_TRAINER_SOURCE_DIR "/config")) {
      const fs::path here = folder_ / entry.path().filename();
      entry.is_directory() ? fs::create_directory_symlink(entry, here) : fs::copy(entry, here);
    }
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::string root() const { return (folder_ / "trainer.yaml").string(); }

  /** A folder is a link until a test changes one of its files. Only then are its files copied, as there are many. */
  void own(const fs::path& folder) {
    if (!fs::is_symlink(folder)) return;
    const fs::path source = fs::read_symlink(folder);
    fs::remove(folder);
    fs::copy(source, folder, fs::copy_options::recursive);
  }

  void replace(const std::string& file, const std::string& pattern, const std::string& text) {
    own((folder_ / file).parent_path());
    std::ifstream in(folder_ / file);
    std::stringstream all;
    all << in.rdbuf();
    const std::string before = all.str();
    const std::string after = std::regex_replace(before, std::regex(pattern), text);
    ASSERT_NE(before, after) << pattern << " is not in " << file;
    std::ofstream(folder_ / file) << after;
  }

  std::string message() const {
    try {
      loadTrainerConfig(root());
    } catch (const ConfigException& e) {
      return e.what();
    }
    return "";
  }

  fs::path folder_;
};

TEST_F(LoadConfig, ThePackagedFilesAreGood) {
  const TrainerConfig config = loadTrainerConfig(root());
  EXPECT_DOUBLE_EQ(config.arms.geometry.d4, -0.47);
  EXPECT_DOUBLE_EQ(config.haptics.tolerance, 0.003);
  EXPECT_EQ(config.network.robot_port, 36000);
  EXPECT_EQ(config.scenarios.at(2).name, "sudden_jump");
}

TEST_F(LoadConfig, ACopyAloneTakesRobotAndScenesFromThePackage) {
  ASSERT_FALSE(fs::exists(folder_ / "../urdf"));
  own(folder_ / "scenes");
  const std::string urdf = RAVEN2_TRAINER_SOURCE_DIR "/urdf/";
  const TrainerConfig config = loadTrainerConfig(root(), {"peg_transfer", "none", "", "none"});
  EXPECT_EQ(config.robot_urdf, urdf + "raven2.urdf");
  EXPECT_EQ(config.urdf_places.at(config.robot_urdf), (folder_.parent_path() / "urdf/raven2.urdf").string());
  EXPECT_EQ(config.urdf_places.at(urdf + "peg_board.urdf"), (folder_.parent_path() / "urdf/peg_board.urdf").string());
  EXPECT_EQ(config.scene_urdf, urdf + "peg_board.urdf");
  EXPECT_EQ(config.roles.file, (folder_ / "scenes/peg_board.yaml").string());
}

TEST_F(LoadConfig, ANeighbourOfTheCopyComesBeforeThePackages) {
  const std::string own_folder = (folder_ / "mine/config").string();
  fs::create_directories(folder_ / "mine/config");
  fs::create_directories(folder_ / "mine/urdf");
  std::ofstream(folder_ / "mine/urdf/raven2.urdf") << "mine";
  EXPECT_EQ(neighbour(own_folder, "../urdf/raven2.urdf", "config").path, (folder_ / "mine/urdf/raven2.urdf").string());
  EXPECT_EQ(neighbour(own_folder, "../urdf/peg_board.urdf", "config").path,
            RAVEN2_TRAINER_SOURCE_DIR "/urdf/peg_board.urdf");
  EXPECT_EQ(neighbour(own_folder, "../urdf/none.urdf", "config").path, (folder_ / "mine/urdf/none.urdf").string());
  EXPECT_EQ(neighbour(own_folder, "arms.yaml", "config").path, own_folder + "/arms.yaml") << "only what lies outside";
}

TEST_F(LoadConfig, ScenariosComeInTheOrderOfTheirNumbersAndTheUsersOwnLast) {
  own(folder_ / "faults");
  fs::copy(folder_ / "faults/sudden_jump.yaml", folder_ / "faults/a_jump.yaml");
  replace("faults/a_jump.yaml", "name: sudden_jump", "name: a_jump");
  replace("faults/a_jump.yaml", "number: 3", "number: 0");
  const TrainerConfig config = loadTrainerConfig(root());
  // The paper's table first (Li et al. 2017, Table 1)
  EXPECT_EQ(faultId(config, "unavailable_recoverable"), 1U);
  EXPECT_EQ(faultId(config, "unavailable_permanent"), 2U);
  EXPECT_EQ(faultId(config, "sudden_jump"), 3U);
  EXPECT_EQ(config.scenarios.back().name, "a_jump");
  for (std::size_t i = 0; i + 1 < config.scenarios.size(); ++i) {
    const Scenario& scenario = config.scenarios[i];
    for (const Fault& fault : scenario.faults)
      EXPECT_EQ(fault.id, i + 1) << scenario.name;
    if (i == 0) continue;
    const Scenario& before = config.scenarios[i - 1];
    EXPECT_LE(before.number, scenario.number) << scenario.name;
    EXPECT_TRUE(before.number < scenario.number || before.name < scenario.name) << scenario.name;
  }
}

TEST_F(LoadConfig, TheChosenToolIsThatOfTheArms) {
  replace("arms.yaml", "tool: raven_grasper", "tool: raven2_sim");
  const ArmsConfig arms = loadTrainerConfig(root()).arms;
  EXPECT_EQ(arms.tool, "raven2_sim");
  EXPECT_EQ(arms.geometry.d4, -0.45869);
  EXPECT_EQ(arms.geometry.lw, 0.0145);
  const ArmGeometry other = toolGeometry(arms, "da_vinci");
  EXPECT_EQ(other.d4, -0.47);
  EXPECT_EQ(other.lw, 0.009);
  EXPECT_EQ(other.home, arms.geometry.home);
  EXPECT_EQ(other.q_max, arms.geometry.q_max);
}

TEST_F(LoadConfig, AnUnknownToolIsRefusedWithItsLineAndTheKnownOnes) {
  try {
    toolGeometry(loadTrainerConfig(root()).arms, "hook");
    ADD_FAILURE() << "accepted";
  } catch (const ConfigException& e) {
    EXPECT_NE(std::string(e.what()).find("\"hook\"; known: raven_grasper, da_vinci, raven2_sim"), std::string::npos);
  }
  replace("arms.yaml", "tool: raven_grasper", "tool: hook");
  EXPECT_TRUE(std::regex_search(
      message(), std::regex("arms.yaml:2: tool is \"hook\", expected one of: raven_grasper, da_vinci, raven2_sim")))
      << message();
}

TEST_F(LoadConfig, AToolsConstantsAreChecked) {
  replace("arms.yaml", "lw: 0.009", "lw: 0.9");
  EXPECT_TRUE(std::regex_search(message(), std::regex("arms.yaml:5: tools/da_vinci/lw is 0.9, expected"))) << message();
}

TEST_F(LoadConfig, AnUnknownKeyIsRefusedWithItsLine) {
  replace("haptics.yaml", "kd: ", "stiffness: 1\nkd: ");
  EXPECT_TRUE(std::regex_search(message(), std::regex("haptics.yaml:3: unknown key stiffness"))) << message();
}

TEST_F(LoadConfig, AKeyGivenTwiceIsRefusedWithItsLine) {
  replace("haptics.yaml", "kd: ", "kp: 2\nkd: ");
  EXPECT_TRUE(std::regex_search(message(), std::regex("haptics.yaml:3: kp is given twice"))) << message();
}

TEST_F(LoadConfig, WithoutASecondCameraItIsTheFirst) {
  EXPECT_EQ(loadTrainerConfig(root()).render.live_second, "overview");
  replace("render.yaml", "  second: overview", "  #");
  EXPECT_EQ(loadTrainerConfig(root()).render.live_second, "endoscope");
}

TEST_F(LoadConfig, ASecondCameraHasToExist) {
  replace("render.yaml", "second: overview", "second: overvew");
  EXPECT_NE(message().find("did you mean \"overview\""), std::string::npos) << message();
}

TEST_F(LoadConfig, AMissingKeyIsRefused) {
  replace("haptics.yaml", "tolerance: .*", "");
  EXPECT_NE(message().find("tolerance is missing"), std::string::npos) << message();
}

TEST_F(LoadConfig, TheArmsMaterialComesFirstAndMustBeThere) {
  replace("model.yaml", "\n  tool:", "\n  zinc: {stiffness: 200, damping: 1}\n  tool:");
  const ModelConfig model = loadTrainerConfig(root()).model;
  EXPECT_EQ(model.materials.at(0).name, "tool");
  EXPECT_EQ(model.materials.at(1).name, "zinc");
  replace("model.yaml", "\n  tool:", "\n  steel:");
  EXPECT_NE(message().find("has no 'tool'"), std::string::npos) << message();
}

TEST_F(LoadConfig, AValueOutOfRangeIsRefusedWithTheRange) {
  replace("haptics.yaml", "tolerance: [0-9.]+", "tolerance: -0.003");
  EXPECT_TRUE(std::regex_search(message(), std::regex("haptics.yaml:4: tolerance is -0.003, expected \\[0, 0.05\\]")))
      << message();
}

TEST_F(LoadConfig, AForceEndsFiftyMillisecondsAfterTheLastStateAtTheLatest) {
  // 50 ms less 4 ms of uncertainty, two ticks, and the fall from 3.3 N at 140 N/s, which takes 23.57 ms
  EXPECT_EQ(loadTrainerConfig(root()).network.stale_after, 0.02);
  replace("network.yaml", "stale_after: 0.02", "stale_after: 0.0204");
  EXPECT_EQ(loadTrainerConfig(root()).network.stale_after, 0.0204);
  replace("network.yaml", "stale_after: 0.0204", "stale_after: 0.05");
  EXPECT_TRUE(std::regex_search(message(),
                                std::regex("network.yaml:10: stale_after is 0.05, expected \\[0.002, 0.0204[0-9]*\\]")))
      << message();
  // a slower fall leaves less time, a faster one more
  SetUp();
  replace("haptics.yaml", "max_slew: 140.0", "max_slew: 100.0");
  EXPECT_NE(message().find("stale_after is 0.02, expected [0.002, 0.011"), std::string::npos) << message();
  SetUp();
  replace("haptics.yaml", "max_slew: 140.0", "max_slew: 10000");
  replace("network.yaml", "stale_after: 0.02", "stale_after: 0.043");
  EXPECT_EQ(loadTrainerConfig(root()).network.stale_after, 0.043);
  // and a fall of more than 40 ms leaves no time
  SetUp();
  replace("haptics.yaml", "max_slew: 140.0", "max_slew: 80");
  EXPECT_NE(message().find("max_slew is 80, expected [82.5"), std::string::npos) << message();
}

TEST_F(LoadConfig, TheReservoirHoldsTheBudgetAtLeast) {
  replace("haptics.yaml", "bank: 0.03", "bank: 0.019");
  EXPECT_NE(message().find("bank is 0.019, expected [0.02, 10]"), std::string::npos) << message();
}

TEST_F(LoadConfig, ThePartsOfTheForceAreThoseThatATraineeExpects) {
  const HapticGains haptics = loadTrainerConfig(root()).haptics;
  EXPECT_TRUE(haptics.passivity.enabled);
  EXPECT_FALSE(haptics.guidance.enabled);
  EXPECT_FALSE(haptics.edge.enabled);
  EXPECT_EQ(haptics.edge.size_I, (Vec3{0.07, 0.16, 0.12}));
  EXPECT_EQ(haptics.edge.origin, WorkspaceOrigin::kPedalDown);
  replace("haptics.yaml", "origin: pedal_down", "origin: start");
  EXPECT_EQ(loadTrainerConfig(root()).haptics.edge.origin, WorkspaceOrigin::kStart);
}

TEST_F(LoadConfig, NoPartOfTheForceMayExceedTheWhole) {
  replace("haptics.yaml", "max_force: 3.3", "max_force: 0.9");
  EXPECT_NE(message().find("max_force is 1, expected [0, 0.9]"), std::string::npos) << message();
  SetUp();
  replace("haptics.yaml", "max_force: 3.3", "max_force: 1.2");
  EXPECT_NE(message().find("max_force is 1.5, expected [0, 1.2]"), std::string::npos) << message();
}

TEST_F(LoadConfig, TheMarginOfTheWorkspaceFitsIntoIt) {
  replace("haptics.yaml", "margin: 0.01", "margin: 0.036");
  EXPECT_NE(message().find("margin is 0.036, expected [0.001, 0.035]"), std::string::npos) << message();
}

TEST_F(LoadConfig, ADelayThatTheGuardCannotHoldIsRefused) {
  replace("haptics.yaml", "max_delay: 0.12", "max_delay: 0.5");
  EXPECT_NE(message().find("max_delay is 0.5, expected [0, 0.4]"), std::string::npos) << message();
}

TEST_F(LoadConfig, TheDetectorIsChecked) {
  EXPECT_EQ(loadTrainerConfig(root()).detector.mitigate, Mitigation::kOff) << "as it is shipped";
  replace("detector.yaml", "mitigate: off", "mitigate: shout");
  EXPECT_NE(message().find("mitigate is \"shout\", expected one of: off, hold, stop"), std::string::npos) << message();
  SetUp();
  replace("detector.yaml", "inertia: [0-9.]+", "inertia: 0");
  EXPECT_NE(message().find("gold/shoulder/inertia is 0, expected [1e-07, 1]"), std::string::npos) << message();
  SetUp();
  replace("detector.yaml", "coulomb: [0-9.]+, ", "");
  EXPECT_NE(message().find("coulomb is missing"), std::string::npos) << message();
}

TEST_F(LoadConfig, TheLimitsOfAnExecutionAreChecked) {
  EXPECT_EQ(loadTrainerConfig(root()).execution.speed, 1.0) << "as it is shipped";
  replace("execution.yaml", "speed: 1.0", "speed: 1.5");
  EXPECT_NE(message().find("speed is 1.5, expected [0.05, 1]"), std::string::npos) << message();
  SetUp();
  replace("execution.yaml", "hold_time: 0.2", "hold_time: 0");
  EXPECT_NE(message().find("hold_time is 0"), std::string::npos) << message();
  SetUp();
  replace("execution.yaml", "pedal_timeout: [0-9.]+", "pedal_time: 3");
  EXPECT_NE(message().find("pedal_time"), std::string::npos) << message();
}

TEST_F(LoadConfig, WhatCrtkClientsMayAskForIsChecked) {
  const CrtkConfig crtk = loadTrainerConfig(root()).crtk;
  EXPECT_TRUE(crtk.enabled);
  EXPECT_EQ(crtk.names, (PerArm<std::string>{"arm1", "arm2"}));
  EXPECT_EQ(crtk.dialect, CrtkDialect::kModern);
  EXPECT_EQ(crtk.period, 0.00195);
  EXPECT_EQ(crtk.twist_timeout, 15.0);
  const std::vector<std::array<std::string, 3>> wrong{
      {"max_speed: 0.1 ", "max_speed: 0 ", "max_speed is 0, expected [0.001, 1]"},
      {"move_speed: 0.04 ", "move_speed: 0.11 ", "move_speed is 0.11, expected [0.001, 0.1]"},
      {"move_turn_rate: 0.5 ", "move_turn_rate: 2.1 ", "move_turn_rate is 2.1, expected [0.01, 2]"},
      {"max_step: 0.02 ", "max_step: 20 ", "max_step is 20"},
      {"release_after: 120.0 ", "release_after: -1 ", "release_after is -1"},
      {"twist_timeout: 15.0 ", "twist_timeout: 601 ", "twist_timeout is 601, expected [0.01, 600]"},
      {"trim_time: 1.0 ", "trim_time: 61 ", "trim_time is 61, expected [0, 60]"},
      {"dialect: modern", "dialect: old", "dialect is \"old\", expected one of: modern, raven, transform"},
      {"green: arm2 ", "green: arm1 ", "green is \"arm1\", as is gold"},
      {"green: arm2 ", "green: 2nd ", "green is \"2nd\", expected a ROS name"},
      {"green: arm2 ", "green: a//b ", "green is \"a//b\", expected a ROS name"},
      {"twist_timeout: ", "twist_time: ", "twist_time"}};
  for (const auto& [good, bad, said] : wrong) {
    replace("crtk.yaml", "\n" + good, "\n" + bad);
    EXPECT_NE(message().find(said), std::string::npos) << bad << ": " << message();
    EXPECT_NE(message().find("crtk.yaml:"), std::string::npos) << message();
    replace("crtk.yaml", "\n" + bad, "\n" + good);
  }
  replace("crtk.yaml", "\nrelease_after: 120.0 ", "\nrelease_after: 0 ");
  EXPECT_EQ(loadTrainerConfig(root()).crtk.release_after, 0.0);
}

TEST_F(LoadConfig, AProfileForLooseStreamsIsRefusedWithSignedPackets) {
  replace("network.yaml", "\nstream: none ", "\nstream: dv_trainer ");
  EXPECT_TRUE(loadTrainerConfig(root()).network.itp.stream.is_on);
  for (const char* auth : {"accept_both", "required"}) {
    replace("network.yaml", "\nauth: [^ ]+ ", std::string("\nauth: \"") + auth + "\" ");
    EXPECT_NE(message().find("what is signed is proper ITP"), std::string::npos) << auth << ": " << message();
    EXPECT_NE(message().find("network.yaml:"), std::string::npos) << message();
  }
}

TEST_F(LoadConfig, WrongTypesAreRefused) {
  for (const char* value : {"fast", "[1, 2]", ".nan", "{a: 1}"}) {
    SetUp();
    replace("haptics.yaml", "kp: [0-9.]+", std::string("kp: ") + value);
    EXPECT_NE(message().find("kp is"), std::string::npos) << value << ": " << message();
  }
}

TEST_F(LoadConfig, AMissingKeyIsNamedAndARightOneNotTakenForIt) {
  replace("network.yaml", "robot_host: ", "# robot_host: ");
  EXPECT_NE(message().find("robot_host is missing"), std::string::npos) << message();
  EXPECT_EQ(message().find("robot_port"), std::string::npos) << "it is right: " << message();
  SetUp();
  replace("haptics.yaml", "\nmax_force: ", "\n# max_force: ");
  EXPECT_NE(message().find("max_force is missing"), std::string::npos) << message();
  EXPECT_EQ(message().find("did you mean"), std::string::npos) << message();
  SetUp();
  replace("network.yaml", "robot_host: ", "robt_host: ");
  EXPECT_NE(message().find("unknown key robt_host: did you mean \"robot_host\"?"), std::string::npos) << message();
}

TEST_F(LoadConfig, BrokenYamlIsRefusedWithItsLine) {
  replace("network.yaml", "robot_port: ", "robot_port: [1, ");
  EXPECT_TRUE(std::regex_search(message(), std::regex("network.yaml:[0-9]+: "))) << message();
}

TEST_F(LoadConfig, AMissingFileIsNamed) {
  fs::remove(folder_ / "planner.yaml");
  EXPECT_NE(message().find("planner.yaml:1: cannot be opened"), std::string::npos) << message();
}

TEST_F(LoadConfig, AnUnknownHazardIsRefusedWithTheKnownOnes) {
  replace("trainer.yaml", "hazard: sudden_jump", "hazard: meteor");
  EXPECT_NE(message().find("known: none"), std::string::npos) << message();
}

TEST_F(LoadConfig, ABehaviourThatThereIsNotIsRefused) {
  replace("virtual_raven.yaml", "behaviour: compat", "behaviour: meteor");
  EXPECT_NE(message().find("behaviour"), std::string::npos) << message();
}

TEST_F(LoadConfig, TheHardenedRobotDemandsWhatTheDaemonDemands) {
  replace("virtual_raven.yaml", "behaviour: compat", "behaviour: hardened");
  const TrainerConfig config = loadTrainerConfig((folder_ / "trainer.yaml").string());
  EXPECT_EQ(config.virtual_raven.behaviour, "hardened");
  EXPECT_EQ(config.virtual_raven.itp.max_increment_um, config.network.itp.max_increment_um);
}

TEST_F(LoadConfig, UnsignedItpFromOtherComputersMustBeAskedFor) {
  replace("network.yaml", "bind_address: 127.0.0.1", "bind_address: 0.0.0.0");
  EXPECT_NE(message().find("network.yaml:2"), std::string::npos) << message();
  EXPECT_NE(message().find("allow_plaintext_remote"), std::string::npos) << message();
  replace("network.yaml", "allow_plaintext_remote: false", "allow_plaintext_remote: true");
  EXPECT_EQ(message(), "");
}

TEST_F(LoadConfig, SignedItpMayBeHeardFromOtherComputers) {
  replace("network.yaml", "bind_address: 127.0.0.1", "bind_address: 0.0.0.0");
  replace("network.yaml", "key_file: \"\"", "key_file: some.key");
  replace("network.yaml", "auth: \"off\"", "auth: accept_both");
  EXPECT_NE(message().find("allow_plaintext_remote"), std::string::npos) << "accept_both accepts unsigned packets too";
  replace("network.yaml", "auth: accept_both", "auth: required");
  EXPECT_EQ(message(), "");
}

TEST_F(LoadConfig, SignaturesNeedAKeyAndAReceiverThatVerifies) {
  replace("network.yaml", "auth: \"off\"", "auth: required");
  EXPECT_NE(message().find("key_file is empty"), std::string::npos) << message();
  replace("network.yaml", "key_file: \"\"", "key_file: some.key");
  replace("network.yaml", "ingest: hardened", "ingest: compat");
  EXPECT_NE(message().find("compat does not verify"), std::string::npos) << message();
}

TEST_F(LoadConfig, TrainingLevelsReplaceThresholdsAndGains) {
  std::string current = "moderate";
  const auto clips = [&](const std::string& level) {
    if (level != current) replace("virtual_raven.yaml", "training_level: " + current, "training_level: " + level);
    current = level;
    return loadTrainerConfig((folder_ / "trainer.yaml").string()).virtual_raven;
  };
  // raven2.md 3.5, 3.6
  EXPECT_EQ(clips("moderate").axes[kShoulder].dac_clip, 2500);
  EXPECT_EQ(clips("beginner").axes[kInsertion].dac_clip, 1000);
  EXPECT_EQ(clips("advanced").axes[kElbow].dac_clip, 5000);
  const VirtualRavenConfig authors = clips("authors");
  EXPECT_EQ(authors.max_inst_dac, 12000);
  EXPECT_EQ(authors.axes[kWrist].dac_clip, 2700);
  EXPECT_EQ(authors.homing_dac[kInsertion], 1900);
  EXPECT_EQ(authors.axes[kGrasp1].kp, 0.02);
  EXPECT_EQ(authors.axes[kGrasp1].ki, 0.0);
}

TEST_F(LoadConfig, ALevelOrPolicyOfAnotherNameIsRefused) {
  replace("virtual_raven.yaml", "training_level: moderate", "training_level: expert");
  EXPECT_NE(message().find("expected one of: beginner"), std::string::npos) << message();
}

TEST_F(LoadConfig, AFractionOfACountIsRefused) {
  replace("virtual_raven.yaml", "2500, 1900, 2000, 1800", "2500, 1900.5, 2000, 1800");
  EXPECT_NE(message().find("whole counts"), std::string::npos) << message();
}

TEST_F(LoadConfig, ScenariosThatNoInjectorServesAreRefused) {
  replace("faults/sudden_jump.yaml", "site: put_usb_packet", "site: network_layer");
  EXPECT_NE(message().find("sudden_jump.yaml:"), std::string::npos);
  EXPECT_NE(message().find("expected one of: increment, quaternion"), std::string::npos) << message();
}

TEST_F(LoadConfig, ADurationLongerThanItsPeriodIsRefused) {
  replace("faults/sudden_jump.yaml", "period_ticks: 8000", "period_ticks: 200");
  EXPECT_NE(message().find("shorter than duration_ticks"), std::string::npos) << message();
}

TEST_F(LoadConfig, ButtonsOfPedalsAreInRangeAndNoneIsThatOfTwo) {
  EXPECT_EQ(loadTrainerConfig(root()).network.joy.buttons[static_cast<std::size_t>(Pedal::kStop)], 6);
  replace("network.yaml", "trial: 2", "trial: -1");
  replace("network.yaml", "view: 3", "view: -1");
  EXPECT_EQ(message(), "") << "-1 means no button";
  replace("network.yaml", "stop: 6", "stop: 4");
  EXPECT_NE(message().find("stop is button 4, as is camera"), std::string::npos) << message();
  replace("network.yaml", "stop: 4", "stop: 128");
  EXPECT_NE(message().find("stop"), std::string::npos) << message();
}

TEST_F(LoadConfig, ARealCameraHasATopicAndATimeToBeStale) {
  const TrainerConfig packaged = loadTrainerConfig(root());
  EXPECT_EQ(packaged.render.real_camera_topic, "real_camera/image_raw");
  EXPECT_DOUBLE_EQ(packaged.render.real_stale_after, 0.5);
  replace("render.yaml", "stale_after: 0.5", "stale_after: 0.01");
  EXPECT_NE(message().find("stale_after"), std::string::npos) << message();
  replace("render.yaml", "stale_after: 0.01", "stale_after: 0.5");
  replace("render.yaml", "topic: real_camera/image_raw", "topic: /view/image_raw");
  EXPECT_NE(message().find("the view itself"), std::string::npos) << "an endless view of itself: " << message();
}

TEST_F(LoadConfig, ACameraSaysWhatMovesIt) {
  const RenderConfig render = loadTrainerConfig(root()).render;
  EXPECT_EQ(render.cameras[0].moves, CameraMoves::kNever);
  EXPECT_EQ(render.cameras[1].moves, CameraMoves::kClutch);
  replace("render.yaml", "moves: gold_tool", "moves: silver_tool");
  EXPECT_NE(message().find("moves"), std::string::npos) << message();
  replace("render.yaml", ", moves: silver_tool", "");
  EXPECT_NE(message().find("moves"), std::string::npos) << "a required key: " << message();
}

TEST_F(LoadConfig, BothEyesAreCamerasBesideTheOneInTheirMiddle) {
  const RenderConfig render = loadTrainerConfig(root()).render;
  ASSERT_EQ(render.cameras.size(), 7U);
  const CameraConfig &middle = render.cameras[1], &left = render.cameras[5], &right = render.cameras[6];
  EXPECT_EQ(left.name, "endoscope_left");
  EXPECT_EQ(right.name, "endoscope_right");
  EXPECT_EQ(left.eye_W, middle.eye_W);
  EXPECT_EQ(right.moves, middle.moves);
  EXPECT_DOUBLE_EQ(left.aside, -0.0025);
  EXPECT_DOUBLE_EQ(right.aside, 0.0025);
  replace("render.yaml", "camera: endoscope\n  baseline", "camera: cellar\n  baseline");
  EXPECT_NE(message().find("cellar"), std::string::npos) << message();
  replace("render.yaml", "camera: cellar", "camera: endoscope");
  replace("render.yaml", "name: top,", "name: endoscope_left,");
  EXPECT_NE(message().find("endoscope_left"), std::string::npos) << message();
}

TEST_F(LoadConfig, OverlaysAreKnownByName) {
  const RenderConfig render = loadTrainerConfig(root()).render;
  EXPECT_TRUE(render.video_overlays.has(OverlayKind::kHazard));
  EXPECT_FALSE(render.live_overlays.has(OverlayKind::kHazard)) << "the trainee must not see it";
  EXPECT_TRUE(render.live_overlays.has(OverlayKind::kStatus));
  replace("render.yaml", "live: \\[ghost,", "live: [ghots,");
  EXPECT_NE(message().find("no overlay is called \"ghots\": did you mean \"ghost\"?"), std::string::npos) << message();
  replace("render.yaml", "live: \\[ghots,", "live: [spirit,");
  EXPECT_NE(message().find("force_arrows"), std::string::npos) << "the message lists the valid overlays: " << message();
}

TEST(Overlays, AreAllOrNoneOrThoseThatAreNamed) {
  EXPECT_EQ(overlaysOf({"all"}), OverlaySet::all());
  EXPECT_EQ(overlaysOf({"none"}), OverlaySet());
  OverlaySet two;
  two.add(OverlayKind::kPlan);
  two.add(OverlayKind::kLatency);
  EXPECT_EQ(overlaysOf({"latency", "plan"}), two);
  EXPECT_EQ(overlaysOf({kOverlayNames.begin(), kOverlayNames.end()}), OverlaySet::all());
  EXPECT_THROW(overlaysOf({"all", "plan"}), ConfigException);
  EXPECT_THROW(overlaysOf({""}), ConfigException);
}

TEST_F(LoadConfig, TheLivePicturesBoundsAreChecked) {
  const TrainerConfig packaged = loadTrainerConfig(root());
  EXPECT_EQ(packaged.render.live_slowest, 10);
  EXPECT_DOUBLE_EQ(packaged.render.live_smallest, 0.5);
  EXPECT_DOUBLE_EQ(packaged.render.live_settle, 3.0);
  EXPECT_EQ(packaged.render.live_jpeg_quality, 80);
  const std::vector<std::array<std::string, 2>> wrong{
      {"slowest: 10 ", "slowest: 0 "},      {"slowest: 10 ", "slowest: 31 "},
      {"smallest: 0.5 ", "smallest: 1.5 "}, {"smallest: 0.5 ", "smallest: 0.49 "},
      {"settle: 3.0 ", "settle: 0.1 "},     {"jpeg_quality: 80 ", "jpeg_quality: 101 "}};
  for (const auto& [good, bad] : wrong) {
    replace("render.yaml", good, bad);
    EXPECT_NE(message().find(bad.substr(0, bad.find(':'))), std::string::npos) << message();
    EXPECT_NE(message().find("render.yaml:"), std::string::npos) << message();
    replace("render.yaml", bad, good);
  }
  replace("render.yaml", "slowest: 10 ", "slowest: 30 ");
  EXPECT_EQ(loadTrainerConfig(root()).render.live_slowest, 30) << "as fast as fps: the rate never drops";
}

}  // namespace
}  // namespace raven2_trainer::config
