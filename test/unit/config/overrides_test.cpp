#include "raven2_trainer/config/overrides.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/config/section.h"
#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::config {
namespace {

namespace fs = std::filesystem;

const std::string kFolder = RAVEN2_TRAINER_SOURCE_DIR "/config";
const std::string kRoot = kFolder + "/trainer.yaml";

Override named(const std::string& key, const std::string& value) {
  return {key, value, "ROS parameter /node/" + key};
}

TrainerConfig with(const std::string& key, const std::string& value) {
  return loadTrainerConfig(kRoot, {}, {named(key, value)});
}

std::string refusal(const std::string& key, const std::string& value) {
  try {
    with(key, value);
  } catch (const ConfigException& e) {
    return e.what();
  }
  return "";
}

TEST(Overrides, TakeTheValuesPlaceAtEveryDepthAndOfEveryShape) {
  EXPECT_EQ(with("haptics/tolerance", "0.005").haptics.tolerance, 0.005);
  EXPECT_FALSE(with("haptics/passivity/enabled", "false").haptics.passivity.enabled);
  EXPECT_EQ(with("planner/goal_W", "[0.01, -0.02, 0.03]").planner.goal_W, (Vec3{0.01, -0.02, 0.03}));
  EXPECT_EQ(with("planner/planner", "\"RRTConnect\"").planner.planner, "RRTConnect");
  EXPECT_EQ(with("network/joy/topic", "\"other\"").network.joy.topic, "other");
  EXPECT_EQ(with("model/gains/elbow/kp", "77").model.gains[1].kp, 77.0);
  EXPECT_EQ(with("seed", "12").seed, 12U);
  EXPECT_EQ(with("hazard", "none").hazard, "none");
}

TEST(Overrides, LeaveTheRestAsItIs) {
  const TrainerConfig plain = loadTrainerConfig(kRoot), other = with("haptics/tolerance", "0.005");
  EXPECT_NE(plain.haptics.tolerance, 0.005);
  EXPECT_EQ(other.haptics.kp, plain.haptics.kp);
  EXPECT_EQ(other.haptics.passivity.budget, plain.haptics.passivity.budget);
  EXPECT_EQ(other.network.robot_port, plain.network.robot_port);
  EXPECT_EQ(other.files, plain.files);
  EXPECT_TRUE(plain.overridden.empty());
  ASSERT_EQ(other.overridden.size(), 1U);
  EXPECT_EQ(fs::path(other.overridden.begin()->first).filename(), "haptics.yaml");
}

TEST(Overrides, AreHeldToTheFilesRangesAndTypes) {
  const std::string range = refusal("haptics/tolerance", "0.06");
  EXPECT_NE(range.find("ROS parameter /node/haptics/tolerance: tolerance is 0.06, expected [0, 0.05]"),
            std::string::npos)
      << range;
  EXPECT_NE(refusal("haptics/tolerance", "\"much\"").find("/node/haptics/tolerance: tolerance is not a number"),
            std::string::npos);
  EXPECT_NE(refusal("haptics/tolerance", "[1]").find("is not a number"), std::string::npos);
  EXPECT_NE(refusal("haptics/tolerance", ".nan").find("expected [0, 0.05]"), std::string::npos);
  EXPECT_NE(refusal("planner/samples", "10.5").find("expected a whole number"), std::string::npos);
  const std::string element = refusal("planner/goal_W", "[0, 0, 7]");
  EXPECT_NE(element.find("/node/planner/goal_W: goal_W[2] is 7, expected [-1, 1]"), std::string::npos) << element;
  EXPECT_NE(refusal("seed", "-1").find("/node/seed: seed is -1, expected [0, "), std::string::npos);
  EXPECT_NE(refusal("crtk/dialect", "\"x\"").find("expected one of: "), std::string::npos);
}

TEST(Overrides, OfOneKeyAreHeldToWhatOthersDemand) {
  const std::string limits = refusal("arms/limits/min", "[9, 9, 9, 9, 9, 9, 9]");
  EXPECT_NE(limits.find("/node/arms/limits/min: limits: min is not below max"), std::string::npos) << limits;
  const std::string force = refusal("haptics/max_force", "0");
  EXPECT_NE(force.find("expected [0, 0]"), std::string::npos) << force;
}

TEST(Overrides, OfKeysThatThereAreNotAreErrors) {
  for (const char* key :
       {"haptics/tolernace", "haptics/passivity/enable", "haptics/passivty/enabled", "haptisc/tolerance", "tolerance",
        "haptics/tolerance/x", "seed/x", "plants/nominal/x", "faults/x"}) {
    const std::string message = refusal(key, "1");
    EXPECT_NE(message.find(std::string("ROS parameter /node/") + key + ": "), std::string::npos)
        << key << ": " << message;
    const bool says_why =
        message.find("unknown key") != std::string::npos || message.find("is not a mapping") != std::string::npos;
    EXPECT_TRUE(says_why) << key << ": " << message;
  }
}

TEST(Overrides, OfWhatIsReadHeardOrArmedAreRefused) {
  for (const char* key :
       {"haptics", "faults", "robot_urdf", "network/bind_address", "network/auth", "network/key_file", "network/stream",
        "network/allow_plaintext_remote", "runtime/enable_remote_control", "runtime/flight_recorder",
        "injection/enable", "injection/real_robot", "virtual_raven/plant"}) {
    const std::string message = refusal(key, "true");
    EXPECT_EQ(message.find("unknown key"), std::string::npos) << message;
    EXPECT_NE(message.find(std::string("ROS parameter /node/") + key + ": " + key), std::string::npos) << message;
  }
}

/** A key that is removed or renamed in its file must not become one that anybody may set. */
TEST(Overrides, EveryKeyThatIsTheFilesAloneIsInItsFile) {
  for (const auto& [part, keys] : std::vector<std::pair<std::string, std::vector<std::string>>>{
           {"network",
            {"bind_address", "master_address", "auth", "ingest", "key_file", "stream", "allow_plaintext_remote"}},
           {"runtime", {"flight_recorder", "enable_remote_control"}},
           {"injection", {"enable", "real_robot"}},
           {"virtual_raven", {"plant"}}}) {
    const Section file = Section::fromFile(kFolder + "/" + part + ".yaml");
    for (const std::string& key : keys) {
      EXPECT_TRUE(file.has(key)) << key;
      EXPECT_THROW(checkOverrides({named(part + "/" + key, "1")}), ConfigException);
    }
  }
}

TEST(Overrides, AreYamlAsItMayStandInAFile) {
  EXPECT_NE(refusal("haptics/tolerance", "[0.1").find("ROS parameter /node/haptics/tolerance"), std::string::npos);
  EXPECT_NE(refusal("haptics/tolerance", "&a 0.001").find("anchors"), std::string::npos);
  EXPECT_NE(refusal("haptics/tolerance", "!!float 0.001").find("tags"), std::string::npos);
  EXPECT_NE(refusal("haptics/tolerance", "\"" + std::string(1U << 20U, ' ') + "\"").find("1 MiB"), std::string::npos);
}

/** The texts kept for the session, written in place of the files, load as exactly the configuration that ran. */
TEST(Overrides, TheTextsKeptReadAsWhatRan) {
  const Overrides overrides{named("seed", "12"), named("haptics/tolerance", "0.005"),
                            named("haptics/edge/size_I", "[0.5, 0.6, 0.7]"), named("network/joy/topic", "\"a: #b\""),
                            named("render/live/fps", "24")};
  const TrainerConfig ran = loadTrainerConfig(kRoot, {}, overrides);
  const fs::path folder = fs::temp_directory_path() / ("raven2_overrides_" + std::to_string(getpid()));
  fs::remove_all(folder);
  fs::create_directories(folder);
  fs::copy(kFolder, folder / "config", fs::copy_options::recursive);
  for (const auto& [path, text] : ran.overridden)
    std::ofstream(folder / "config" / fs::path(path).filename()) << text;
  const TrainerConfig again = loadTrainerConfig((folder / "config/trainer.yaml").string());
  EXPECT_EQ(ran.overridden.size(), 4U);
  EXPECT_EQ(again.seed, 12U);
  EXPECT_EQ(again.haptics.tolerance, 0.005);
  EXPECT_EQ(again.haptics.edge.size_I, (Vec3{0.5, 0.6, 0.7}));
  EXPECT_EQ(again.network.joy.topic, "a: #b");
  EXPECT_EQ(again.render.live_fps, 24);
  EXPECT_EQ(again.network.key_file, ran.network.key_file) << "an empty text stays empty";
  EXPECT_EQ(again.network.itp.auth, ran.network.itp.auth) << "\"off\" stays a text";
  EXPECT_EQ(again.trainee, "");
  EXPECT_EQ(again.render.cameras.size(), ran.render.cameras.size());
  for (std::size_t i = 0; i < ran.render.cameras.size(); ++i)
    EXPECT_EQ(again.render.cameras[i].eye_W, ran.render.cameras[i].eye_W);
  fs::remove_all(folder);
}

/** Of every packaged file: without an override's own change, the text kept holds all values of the file. */
TEST(Overrides, TheTextOfEveryFileHoldsAllOfIt) {
  for (const auto& entry : fs::directory_iterator(kFolder)) {
    if (entry.path().extension() != ".yaml") continue;
    const Section file = Section::fromFile(entry.path().string());
    const std::string once = file.yaml();
    const Section copy = Section::fromText(once, "copy");
    EXPECT_EQ(copy.keys(), file.keys());
    EXPECT_EQ(copy.yaml(), once) << entry.path();
  }
}

/** "network" is no beginning of another part's name: an override goes to the part that it names, whole. */
TEST(Overrides, GoToThePartOfTheirWholeName) {
  const Overrides all{named("haptics/kp", "1"), named("hapticsx/kp", "2"), named("haptic/kp", "3"), named("seed", "4")};
  const Overrides own = overridesOf(all, "haptics");
  ASSERT_EQ(own.size(), 1U);
  EXPECT_EQ(own[0].key, "kp");
  EXPECT_EQ(own[0].value, "1");
  const Overrides root = overridesOfRoot(all);
  ASSERT_EQ(root.size(), 3U) << "names of no part are for the root, which refuses them";
  EXPECT_EQ(root[0].key, "hapticsx/kp");
  EXPECT_EQ(root[2].key, "seed");
}

}  // namespace
}  // namespace raven2_trainer::config
