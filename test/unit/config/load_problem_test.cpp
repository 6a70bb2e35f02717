#include "raven2_trainer/config/load_problem.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::config {
namespace {

namespace fs = std::filesystem;

const std::string kFolder = RAVEN2_TRAINER_SOURCE_DIR "/config/problems";

const std::string kGood =
    "description: a test\n"
    "arm: green\n"
    "choose_arm: true\n"
    "start: [0.5, 1.5, 0.4, 0.1, -0.1, 0.7, 0.8]\n"
    "other: [0.6, 1.6, 0.3, 0, 0, 0.7, 0.7]\n"
    "goal:\n"
    "  kind: tip\n"
    "  tip_W: [0.01, -0.02, 0.03]\n";

class LoadProblem : public ::testing::Test {
 protected:
  void SetUp() override {
    path_ = fs::temp_directory_path() / ("raven2_problem_" + std::to_string(getpid()) + ".yaml");
  }
  void TearDown() override { fs::remove(path_); }

  PlanProblem load(const std::string& content) const {
    std::ofstream(path_) << content;
    return loadProblem(path_.string(), geometry_);
  }

  /** What is said about a file of this content; empty if it is good. */
  std::string message(const std::string& content) const {
    try {
      load(content);
    } catch (const ConfigException& e) {
      return e.what();
    }
    return "";
  }

  /** The good file with one piece of its text replaced. */
  static std::string with(const std::string& what, const std::string& instead) {
    std::string text = kGood;
    const std::size_t place = text.find(what);
    EXPECT_NE(place, std::string::npos) << what;
    return text.replace(place, what.size(), instead);
  }

  void expectRefused(const std::string& content, int line, const std::string& says) const {
    const std::string said = message(content);
    EXPECT_NE(said.find(path_.string() + ":" + std::to_string(line) + ": "), std::string::npos) << said;
    EXPECT_NE(said.find(says), std::string::npos) << said;
  }

  const ArmGeometry geometry_ = loadTrainerConfig(RAVEN2_TRAINER_SOURCE_DIR "/config/trainer.yaml").arms.geometry;
  fs::path path_;
};

TEST_F(LoadProblem, EveryKeyArrives) {
  const PlanProblem problem = load(kGood);
  EXPECT_EQ(problem.name, path_.stem().string());
  EXPECT_EQ(problem.description, "a test");
  EXPECT_EQ(problem.request.arm, Arm::kGreen);
  EXPECT_EQ(problem.request.choose_arm, 1);
  EXPECT_EQ(problem.request.start, (JointArray{0.5, 1.5, 0.4, 0.1, -0.1, 0.7, 0.8}));
  EXPECT_EQ(problem.request.other, (JointArray{0.6, 1.6, 0.3, 0, 0, 0.7, 0.7}));
  EXPECT_EQ(problem.request.goal, GoalKind::kTip);
  EXPECT_EQ(problem.request.goal_W, (Vec3{0.01, -0.02, 0.03}));
}

TEST_F(LoadProblem, AGoalMayBeJoints) {
  const PlanProblem problem =
      load(with("  kind: tip\n  tip_W: [0.01, -0.02, 0.03]", "  kind: joints\n  joints: [1, 2, 0.3, 0, 0, 0.1, 0.2]"));
  EXPECT_EQ(problem.request.goal, GoalKind::kJoints);
  EXPECT_EQ(problem.request.goal_q, (JointArray{1, 2, 0.3, 0, 0, 0.1, 0.2}));
}

TEST_F(LoadProblem, EveryKeyIsDemanded) {
  for (const char* line :
       {"description: a test\n", "arm: green\n", "choose_arm: true\n", "start: [0.5, 1.5, 0.4, 0.1, -0.1, 0.7, 0.8]\n",
        "other: [0.6, 1.6, 0.3, 0, 0, 0.7, 0.7]\n", "  tip_W: [0.01, -0.02, 0.03]\n"}) {
    EXPECT_NE(message(with(line, "")).find(" is missing"), std::string::npos) << line;
  }
}

TEST_F(LoadProblem, UnknownKeysAreRefusedWithTheirLine) {
  expectRefused(kGood + "colour: red\n", 9, "unknown key colour");
  expectRefused(kGood + "  joints: [1, 2, 0.3, 0, 0, 0.1, 0.2]\n", 9, "unknown key goal/joints");
}

TEST_F(LoadProblem, ValuesOutOfRangeAreRefusedWithTheirLine) {
  expectRefused(with("arm: green", "arm: red"), 2, "expected one of: gold, green");
  expectRefused(with("[0.5, 1.5, 0.4", "[0.5, 1.5, 0.6"), 4, "start[2] (insertion) is 0.6, expected [0.23, 0.56]");
  expectRefused(with("[0.6, 1.6", "[-0.01, 1.6"), 5, "other[0] (shoulder) is -0.01, expected [0, 1.5708]");
  expectRefused(with("kind: tip", "kind: default"), 7, "expected one of: tip, joints");
  expectRefused(with("0.03]", "1.5]"), 8, "goal/tip_W[2] is 1.5, expected [-1, 1]");
  expectRefused(with("0.03]", ".nan]"), 8, "goal/tip_W[2] is nan");
  expectRefused(with(", 0.7, 0.8]", ", 0.7]"), 4, "start is not a list of 7 numbers");
}

TEST_F(LoadProblem, ProblemsAreFoundByNameAndByFile) {
  const std::vector<std::string> names{"impossible", "into_dome", "paper", "past_tower", "short_move", "two_arms"};
  EXPECT_EQ(problemNames(kFolder), names);
  for (const std::string& name : names) {
    EXPECT_EQ(findProblem(kFolder, name, geometry_).name, name);
    EXPECT_EQ(findProblem(kFolder, kFolder + "/" + name + ".yaml", geometry_).name, name);
  }
  try {
    findProblem(kFolder, "papre", geometry_);
    FAIL() << "found";
  } catch (const ConfigException& e) {
    EXPECT_NE(std::string(e.what()).find("\"papre\" is not known; there are: impossible, into_dome, paper"),
              std::string::npos)
        << e.what();
  }
}

}  // namespace
}  // namespace raven2_trainer::config
