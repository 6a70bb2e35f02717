#include "raven2_trainer/recording/finish_session.h"
#include "raven2_trainer/recording/start_meta.h"

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "gtest/gtest.h"
#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/console/make_motion.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/lockstep/lockstep.h"
#include "support/rig.h"

namespace raven2_trainer::recording {
namespace {

namespace fs = std::filesystem;

nlohmann::json readJson(const std::string& path) {
  std::ifstream file(path);
  return nlohmann::json::parse(file);
}

/** Sessions of half a second, in a folder for the time of a test. */
class FinishSession : public ::testing::Test {
 protected:
  FinishSession() { raven2_trainer::testing::useOde(); }
  ~FinishSession() override { fs::remove_all(folder_); }
  FinishSession(const FinishSession&) = delete;
  FinishSession& operator=(const FinishSession&) = delete;

  session::SessionPaths record(const config::TrainingNames& training, const std::string& name = "session") const {
    return record(config::loadTrainerConfig(RAVEN2_TRAINER_SOURCE_DIR "/config/trainer.yaml", training), name);
  }
  session::SessionPaths record(TrainerConfig config, const std::string& name) const {
    raven2_trainer::testing::homeQuickly(&config);
    const session::SessionPaths paths = session::createSessionDirectory((folder_ / name).string());
    lockstep::Lockstep lockstep(config, console::makeMotion(config, "scripted"), paths, "scripted");
    EXPECT_TRUE(lockstep.run(0.5, {}));
    session::writeMeta(paths, startMeta("test", "0", "scripted"), config);
    return paths;
  }
  std::string index() const { return (folder_ / "index.json").string(); }

  fs::path folder_{fs::temp_directory_path() / ("finish_session_test_" + std::to_string(::getpid()))};
};

TEST_F(FinishSession, WithoutAnExerciseThereIsNothingToDo) {
  const session::SessionPaths paths = record({"none", "none", "ann", "none"});
  EXPECT_FALSE(lacksScore(paths));
  EXPECT_TRUE(finishSession(paths));
  EXPECT_FALSE(fs::exists(paths.score()));
  EXPECT_FALSE(fs::exists(index()));
}

TEST_F(FinishSession, ScoresAnExerciseOnceAndForAll) {
  const session::SessionPaths paths = record({"camera_clutch", "none", "ann", "frs_basics"});
  EXPECT_TRUE(lacksScore(paths));
  EXPECT_TRUE(finishSession(paths));
  EXPECT_FALSE(lacksScore(paths));
  const nlohmann::json score = readJson(paths.score());
  EXPECT_EQ(score["exercise"], "camera_clutch");
  ASSERT_EQ(score["attempts"].size(), 1u);  // its timer starts with the pedal
  EXPECT_EQ(score["attempts"][0]["status"], "running");
  EXPECT_EQ(score["attempts"][0]["metrics"]["peak_force"]["bound"], 5.0);
  const nlohmann::json sessions = readJson(index())["sessions"];
  ASSERT_EQ(sessions.size(), 1u);
  EXPECT_EQ(sessions[0]["trainee"], "ann");
  EXPECT_EQ(sessions[0]["directory"], "session");
}

/** The lenses of config/render.yaml are 0.8 rad (endoscope) and 0.6 rad (overview, the first, and the last camera). The
 *  live camera looks down so that the tips at home are 0.35 rad above its axis: only the endoscope sees them. */
TEST_F(FinishSession, TipsAreLookedForWithTheLensOfTheLiveCamera) {
  for (const auto& [name, sees_tips] : {std::pair("endoscope", true), {"overview", false}}) {
    TrainerConfig config = config::loadTrainerConfig(RAVEN2_TRAINER_SOURCE_DIR "/config/trainer.yaml",
                                                     {"camera_clutch", "none", "", "none"});
    for (CameraConfig& camera : config.render.cameras) {
      camera.eye_W = {-0.3, 0.0, 0.062};
      camera.target_W = {0.0, 0.0, -0.05};
    }
    config.render.live_camera = name;
    const ScoredSession scored = scoreRecorded(record(config, name).directory, {});
    ASSERT_EQ(scored.score.attempts.size(), 1U);
    const auto hidden = scored.score.attempts[0].motion.out_of_view;
    ASSERT_TRUE(hidden.has_value());
    EXPECT_EQ(*hidden > 0.1, !sees_tips) << name << ": " << *hidden;
    EXPECT_EQ(*hidden == 0.0, sees_tips) << name << ": " << *hidden;
  }
}

TEST_F(FinishSession, OfNobodyIsInNoIndex) {
  EXPECT_TRUE(finishSession(record({"camera_clutch", "none", "", "none"})));
  EXPECT_FALSE(fs::exists(index()));
}

TEST_F(FinishSession, TheCurveIsOfTheSameTraineeAndExerciseWithTheSameDrill) {
  for (const auto& [drill, name] : {std::pair("none", "plain"), {"own", "drill"}, {"none", "again"}})
    EXPECT_TRUE(finishSession(record({"camera_clutch", drill, "ann", "none"}, name)));
  EXPECT_TRUE(finishSession(record({"camera_clutch", "none", "bob", "none"}, "bob")));
  EXPECT_TRUE(finishSession(record({"peg_transfer", "none", "ann", "none"}, "peg")));
  EXPECT_EQ(readJson(index())["sessions"].size(), 5U);
  for (const auto& [name, like_it] : {std::pair("again", 2U), {"drill", 1U}, {"bob", 1U}, {"peg", 1U}})
    EXPECT_EQ(scoreRecorded((folder_ / name).string(), {}).history.size(), like_it) << name;
}

TEST_F(FinishSession, GivesUpWhenItIsTold) {
  const session::SessionPaths paths = record({"camera_clutch", "none", "ann", "none"});
  EXPECT_FALSE(finishSession(paths, [] { return true; }));
  EXPECT_TRUE(lacksScore(paths));
  EXPECT_FALSE(fs::exists(index()));
}

TEST_F(FinishSession, SaysSoWhereThereIsNoScore) {
  const session::SessionPaths paths = record({"camera_clutch", "none", "ann", "none"});
  std::ofstream(index()) << "[]";  // a file of another program
  EXPECT_FALSE(finishSession(paths));
  EXPECT_FALSE(finishSession({(folder_ / "nowhere").string()}));
  EXPECT_FALSE(lacksScore({(folder_ / "nowhere").string()}));
}

TEST_F(FinishSession, ABandOfItsOwnJudges) {
  const session::SessionPaths paths = record({"camera_clutch", "none", "ann", "frs_basics"});
  const std::string band = (folder_ / "band.yaml").string();
  std::ofstream(band) << "origin: a test\nsessions: 2\nleast_spread: 0\nmetrics:\n"
                         "  time: {mean: 10, deviation: 1, better: lower, least: 0}\n";
  ScoringOptions options;
  options.band = band;
  options.no_index = true;
  const ScoredSession scored = scoreRecorded(paths.directory, options);
  EXPECT_EQ(scored.path, paths.score());
  ASSERT_TRUE(scored.score.attempts[0].passed.has_value());
  EXPECT_FALSE(*scored.score.attempts[0].passed) << "it was not done";
  EXPECT_FALSE(fs::exists(index()));
  const std::string text = describe(scored);
  EXPECT_NE(text.find("attempt 1: running, not passed"), std::string::npos) << text;
  EXPECT_NE(text.find("<= 11.0000: passed"), std::string::npos) << text;
}

TEST(DescribeScore, AHazardsTimeIsInSecondsAndTheReactionInMilliseconds) {
  training::HazardScore hazard;
  hazard.scenario = "sudden_jump";
  hazard.injection = 8123;
  hazard.response.verdict = training::Verdict::kLate;
  hazard.response.first = {training::Response::kSlow, 450};
  hazard.response.reaction = {training::Response::kPedalUp, 2450};
  ScoredSession scored;
  scored.score.hazards.push_back(hazard);
  EXPECT_EQ(describe(scored), "hazard sudden_jump at 8.123 s: late, pedal_up after 2450 ms\n");
}

TEST(DescribeScore, OfALongCurveTheNewestTwentyAttemptsAreShown) {
  ScoredSession scored;
  scored.trainee = "ann";
  for (int i = 0; i < 25; ++i) {
    training::IndexAttempt attempt;
    attempt.status = "done";
    attempt.metrics["time"] = 100.0 + i;
    training::IndexEntry entry;
    entry.attempts.push_back(attempt);
    scored.history.push_back(entry);
  }
  const std::string text = describe(scored);
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 2 + 20) << text;
  EXPECT_EQ(text.find("104.00"), std::string::npos) << text;
  EXPECT_NE(text.find("105.00"), std::string::npos) << text;
  EXPECT_NE(text.find("124.00"), std::string::npos) << text;
}

TEST(DescribeScore, ALimitIsSaidForTheSideThatPasses) {
  for (const auto& [better, said] : {std::pair(Better::kLower, "<= -9.0000: "), {Better::kHigher, ">= -9.0000: "}}) {
    training::MetricScore metric;
    metric.metric.name = "sparc";
    metric.metric.unit = "-";
    metric.metric.better = better;
    metric.metric.value = -8.0;
    metric.is_judged = true;
    metric.judgement.limit = -9.0;
    ScoredSession scored;
    scored.score.attempts.resize(1);
    scored.score.attempts[0].metrics.push_back(metric);
    EXPECT_NE(describe(scored).find(said), std::string::npos) << describe(scored);
  }
}

}  // namespace
}  // namespace raven2_trainer::recording
