#include "raven2_trainer/console/make_motion.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::console {
namespace {

TrainerConfig configOf(const std::string& exercise) {
  config::TrainingNames names;
  names.exercise = exercise;
  return config::loadTrainerConfig(RAVEN2_TRAINER_SOURCE_DIR "/config/trainer.yaml", names);
}

std::string refusal(const TrainerConfig& config, const std::string& motion) {
  try {
    makeMotion(config, motion);
  } catch (const ConfigException& e) {
    return e.what();
  }
  return "";
}

TEST(Motion, AnUnknownNameIsRefusedWithThoseThatThereAre) {
  const TrainerConfig config = configOf("pick_hand_over_place");
  const std::string words = refusal(config, "surgeon");
  for (const char* part : {"\"surgeon\"", "scripted", "recording:FILE", "commands:FILE", "expert", "clumsy:dropper"})
    EXPECT_NE(words.find(part), std::string::npos) << part << " in: " << words;
  EXPECT_EQ(refusal(config, "exprt"), "raven2_trainer: motion is \"exprt\": did you mean \"expert\"?");
  EXPECT_EQ(refusal(config, "clumsy:droper"),
            "raven2_trainer: motion is \"clumsy:droper\", but exercise pick_hand_over_place has no such clumsy "
            "surgeon: did you mean "
            "\"dropper\"?");
  EXPECT_EQ(refusal(configOf("none"), ""),
            "raven2_trainer: motion is \"\", expected one of: scripted, recording:FILE, commands:FILE, expert");
}

TEST(Motion, OnlyCommandsOfAFileAreCommanded) {
  EXPECT_TRUE(isCommanded("commands:a.csv"));
  for (const char* motion : {"commands", "recording:a.csv", "expert", ""}) {
    EXPECT_FALSE(isCommanded(motion)) << motion;
    EXPECT_EQ(motionLabel(motion), motion);
  }
  EXPECT_EQ(motionLabel("commands:a.csv"), "commands");
  EXPECT_NE(refusal(configOf("none"), "commands").find("commands:FILE"), std::string::npos);
}

TEST(Motion, CommandsLastAsLongAsTheirFileAndHeedNoForce) {
  const std::string file = RAVEN2_TRAINER_SOURCE_DIR "/test/fuzz/seeds/recording/commands";
  EXPECT_DOUBLE_EQ(commandedSeconds("commands:" + file), 0.253);
  EXPECT_NE(makeMotion(configOf("none"), "commands:" + file), nullptr);
  EXPECT_THROW(makeMotion(configOf("none"), MotionChoice{"commands:" + file, 0.4}), ConfigException);
  EXPECT_NE(refusal(configOf("none"), "commands:/none.csv").find("/none.csv:1: "), std::string::npos);
}

TEST(Motion, AnExpertNeedsAnExerciseThatHasOne) {
  EXPECT_NE(refusal(configOf("none"), "expert").find("--exercise"), std::string::npos);
  EXPECT_NE(refusal(configOf("none"), "clumsy:slow").find("--exercise"), std::string::npos);
  TrainerConfig config = configOf("pick_hand_over_place");
  EXPECT_NE(makeMotion(config, "expert"), nullptr);
  config.exercise.expert.clear();
  EXPECT_NE(refusal(config, "expert").find("no expert"), std::string::npos);
}

TEST(Motion, AClumsyHandMustBeOneOfTheExercises) {
  TrainerConfig config = configOf("pick_hand_over_place");
  for (const ClumsyHand& hand : config.exercise.clumsy)
    EXPECT_NE(makeMotion(config, "clumsy:" + hand.name), nullptr) << hand.name;
  const std::string words = refusal(config, "clumsy:sleepy");
  for (const char* part : {"sleepy", "pick_hand_over_place", "dropper, slow, shaky"})
    EXPECT_NE(words.find(part), std::string::npos) << part << " in: " << words;
  config.exercise.clumsy.clear();
  EXPECT_NE(refusal(config, "clumsy:slow").find("has no clumsy surgeons"), std::string::npos);
}

TEST(Motion, EveryPackagedExerciseHasAnExpertAndClumsyHandsThatCanBeHad) {
  int exercises = 0;
  for (const auto& entry : std::filesystem::directory_iterator(RAVEN2_TRAINER_SOURCE_DIR "/config/exercises")) {
    const TrainerConfig config = configOf(entry.path().stem().string());
    ++exercises;
    EXPECT_NE(makeMotion(config, "expert"), nullptr) << entry.path();
    EXPECT_FALSE(config.exercise.clumsy.empty()) << entry.path();
    for (const ClumsyHand& hand : config.exercise.clumsy)
      EXPECT_NE(makeMotion(config, "clumsy:" + hand.name), nullptr) << entry.path() << hand.name;
  }
  EXPECT_GE(exercises, 6);
}

TEST(Motion, OnlyExpertAndClumsyHandsDoTheExercise) {
  EXPECT_TRUE(doesExercise("expert"));
  EXPECT_TRUE(doesExercise("clumsy:slow"));
  for (const char* motion : {"scripted", "recording:expert", "experts", "clumsy", ""})
    EXPECT_FALSE(doesExercise(motion)) << motion;
}

/** Ticks until the simulated surgeon lifts the pedal; -1: never. */
int ticksToPedalUp(console::MotionSource* hands, bool with_force) {
  console::Senses senses;
  for (int tick = 0; tick < 3000; ++tick) {
    senses.force.force_I[0] = {with_force ? 1.0 : 0.0, 0.0, 0.0};
    if (tick > 0 && !hands->tick(senses).pedal) return tick;
    if (tick == 0) hands->tick(senses);
  }
  return -1;
}

TEST(Motion, AnyHandsReactAfterTheTimeAskedForAndTellOfIt) {
  TrainerConfig config = configOf("none");
  console::TruthLog truth;
  const auto reacting = makeMotion(config, MotionChoice{"scripted", 0.25}, &truth);
  EXPECT_NEAR(ticksToPedalUp(reacting.get(), /*with_force=*/true), 250, 2);
  ASSERT_EQ(truth.events().size(), 2U);
  EXPECT_EQ(truth.events()[0].what, "felt");
  EXPECT_EQ(truth.events()[1].what, "pedal_up");
  const auto calm = makeMotion(config, "scripted");
  EXPECT_NE(ticksToPedalUp(calm.get(), true), ticksToPedalUp(reacting.get(), false));
}

}  // namespace
}  // namespace raven2_trainer::console
