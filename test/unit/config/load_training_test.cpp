#include "raven2_trainer/config/load_training.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>

#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::config {
namespace {

namespace fs = std::filesystem;

/** A copy of the packaged configuration, with separate folders for the test's exercises. */
class LoadTraining : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("raven2_training_" + std::to_string(getpid()));
    fs::remove_all(folder_);
    for (const char* name : {"exercises", "scenes", "curricula", "bands"})
      fs::create_directories(folder_ / name);
    for (const fs::directory_entry& entry : fs::directory_iterator(RAVEN2_TRAINER_SOURCE_DIR "/config")) {
      const fs::path here = folder_ / entry.path().filename();
      if (fs::exists(here)) continue;
      entry.is_directory() ? fs::create_directory_symlink(entry, here) : fs::copy(entry, here);
    }
  }
  void TearDown() override { fs::remove_all(folder_); }

  void set(const std::string& key, const std::string& value) {
    std::ifstream in(folder_ / "trainer.yaml");
    std::stringstream all;
    all << in.rdbuf();
    const std::string text =
        std::regex_replace(all.str(), std::regex("\n" + key + ": \\S*"), "\n" + key + ": " + value);
    ASSERT_NE(text, all.str()) << key;
    std::ofstream(folder_ / "trainer.yaml") << text;
  }

  TrainerConfig load(const TrainingNames& instead = {}) const {
    return loadTrainerConfig((folder_ / "trainer.yaml").string(), instead);
  }

  std::string message(const TrainingNames& instead = {}) const {
    try {
      load(instead);
    } catch (const ConfigException& e) {
      return e.what();
    }
    return "";
  }

  fs::path folder_;
};

TEST_F(LoadTraining, WithoutAnExerciseTheSceneAndTheHazardAreThoseOfTheRoot) {
  const TrainerConfig config = load();
  EXPECT_EQ(config.exercise_name, "none");
  EXPECT_EQ(config.drill, "none");
  EXPECT_EQ(config.trainee, "");
  EXPECT_EQ(config.curriculum, "none");
  EXPECT_EQ(config.hazard, "sudden_jump");
  EXPECT_EQ(fs::path(config.scene_urdf).filename(), "frs_trainer.urdf");
  EXPECT_TRUE(config.exercise.tracks.empty());
  EXPECT_EQ(fs::path(config.bands), folder_ / "bands");
  EXPECT_EQ(fs::path(config.exercises), folder_ / "exercises");
}

TEST_F(LoadTraining, NoPlanIsScheduledInAnExercise) {
  const std::string root = RAVEN2_TRAINER_SOURCE_DIR "/config/trainer.yaml";
  EXPECT_GE(loadTrainerConfig(root).runtime.plan_at, 0.0);
  EXPECT_LT(loadTrainerConfig(root, {"retrieve_and_reach", "", "", ""}).runtime.plan_at, 0.0);
}

TEST_F(LoadTraining, AnUnknownNameIsRefusedWithTheKnownOnes) {
  std::ofstream(folder_ / "exercises/press.yaml") << "scene: box\n";
  std::ofstream(folder_ / "exercises/notes.txt") << "no exercise\n";
  EXPECT_EQ(message({"pres", "", "", ""}), "raven2_trainer: no exercise is called \"pres\": did you mean \"press\"?");
  EXPECT_EQ(message({"hop", "", "", ""}), "raven2_trainer: no exercise is called \"hop\"; known: none, press");
  EXPECT_EQ(message({"press", "", "", ""}), "raven2_trainer: " + (folder_ / "exercises/press.yaml").string() +
                                                ":1: scene: no scene is called \"box\"; known: none");
  EXPECT_EQ(message({"", "", "", "basics"}), "raven2_trainer: no curriculum is called \"basics\"; known: none");
  set("exercise", "hop");
  EXPECT_EQ(message(), "raven2_trainer: no exercise is called \"hop\"; known: none, press");
}

TEST_F(LoadTraining, ANameLeadsToNoFileElsewhere) {
  std::ofstream(folder_ / "secret.yaml") << "scene: box\n";
  EXPECT_NE(message({"../secret", "", "", ""}).find("no exercise is called"), std::string::npos);
  std::ofstream(folder_ / "exercises/press.yaml") << "scene: ../secret\n";
  EXPECT_NE(message({"press", "", "", ""}).find("no scene is called \"../secret\""), std::string::npos);
}

TEST_F(LoadTraining, ADrillNeedsAnExercise) {
  EXPECT_EQ(message({"", "sudden_jump", "", ""}),
            "raven2_trainer: drill is \"sudden_jump\", but there is no exercise that could run into it");
}

TEST_F(LoadTraining, ATraineeIsAnIdAndNoName) {
  EXPECT_EQ(load({"", "", "t-01_x", ""}).trainee, "t-01_x");
  EXPECT_EQ(load({"", "", std::string(32, 'a'), ""}).trainee, std::string(32, 'a'));
  for (const std::string& bad : {std::string(33, 'a'), std::string("Ann"), std::string("a b"), std::string("a/b"),
                                 std::string("a.b"), std::string("\xC3\xA4")})
    EXPECT_NE(message({"", "", bad, ""}).find("expected at most 32 of a-z"), std::string::npos) << bad;
  set("trainee", "Bob");
  EXPECT_NE(message().find("trainee is \"Bob\""), std::string::npos) << message();
  EXPECT_EQ(load({"", "", "other", ""}).trainee, "other") << "the name given instead is the one that counts";
}

TEST_F(LoadTraining, ACurriculumIsAmongTheFilesOfASession) {
  std::ofstream(folder_ / "curricula/basics.yaml") << "title: t\n";
  const TrainerConfig config = load({"", "", "", "basics"});
  EXPECT_EQ(config.curriculum, "basics");
  const std::string file = (folder_ / "curricula/basics.yaml").string();
  EXPECT_EQ(std::count(config.files.begin(), config.files.end(), file), 1);
  set("curriculum", "basics");
  EXPECT_EQ(load().curriculum, "basics");
  EXPECT_EQ(load({"", "", "", "none"}).curriculum, "none");
}

}  // namespace
}  // namespace raven2_trainer::config
