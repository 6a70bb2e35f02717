#include "raven2_trainer/config/load_problem.h"

#include <gtest/gtest.h>

#include <string>
#include <utility>

#include "config/named_files.h"
#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/core/exceptions.h"
#include "support/yaml_file.h"

namespace raven2_trainer::config {
namespace {

using raven2_trainer::testing::replaced;
using raven2_trainer::testing::TemporaryFile;

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

const ArmGeometry& geometry() {
  static const ArmGeometry value = loadTrainerConfig(RAVEN2_TRAINER_SOURCE_DIR "/config/trainer.yaml").arms.geometry;
  return value;
}

PlanProblem load(const std::string& content) {
  return loadProblem(TemporaryFile("probe.yaml", content).path(), geometry());
}

/** The good file with one piece of its text replaced. */
std::string with(const std::string& what, const std::string& instead) {
  return replaced(kGood, what, instead);
}

void expectRefused(const std::string& content, int line, const std::string& says) {
  raven2_trainer::testing::expectRefused(load, content, line, says);
}

TEST(LoadProblem, EveryKeyArrives) {
  const PlanProblem problem = load(kGood);
  EXPECT_EQ(problem.name, "probe");
  EXPECT_EQ(problem.description, "a test");
  EXPECT_EQ(problem.request.arm, Arm::kGreen);
  EXPECT_EQ(problem.request.choose_arm, 1);
  EXPECT_EQ(problem.request.start, (JointArray{0.5, 1.5, 0.4, 0.1, -0.1, 0.7, 0.8}));
  EXPECT_EQ(problem.request.other, (JointArray{0.6, 1.6, 0.3, 0, 0, 0.7, 0.7}));
  EXPECT_EQ(problem.request.goal, GoalKind::kTip);
  EXPECT_EQ(problem.request.goal_W, (Vec3{0.01, -0.02, 0.03}));
}

TEST(LoadProblem, AGoalMayBeJoints) {
  const PlanProblem problem =
      load(with("  kind: tip\n  tip_W: [0.01, -0.02, 0.03]", "  kind: joints\n  joints: [1, 2, 0.3, 0, 0, 0.1, 0.2]"));
  EXPECT_EQ(problem.request.goal, GoalKind::kJoints);
  EXPECT_EQ(problem.request.goal_q, (JointArray{1, 2, 0.3, 0, 0, 0.1, 0.2}));
}

TEST(LoadProblem, EveryKeyIsDemanded) {
  for (const char* line :
       {"description: a test\n", "arm: green\n", "choose_arm: true\n", "start: [0.5, 1.5, 0.4, 0.1, -0.1, 0.7, 0.8]\n",
        "other: [0.6, 1.6, 0.3, 0, 0, 0.7, 0.7]\n", "  tip_W: [0.01, -0.02, 0.03]\n"}) {
    try {
      load(with(line, ""));
      ADD_FAILURE() << "taken without " << line;
    } catch (const ConfigException& e) {
      EXPECT_NE(std::string(e.what()).find(" is missing"), std::string::npos) << e.what();
    }
  }
}

TEST(LoadProblem, UnknownKeysAreRefusedWithTheirLine) {
  expectRefused(kGood + "colour: red\n", 9, "unknown key colour");
  expectRefused(kGood + "  joints: [1, 2, 0.3, 0, 0, 0.1, 0.2]\n", 9, "unknown key goal/joints");
}

TEST(LoadProblem, ValuesOutOfRangeAreRefusedWithTheirLine) {
  expectRefused(with("arm: green", "arm: red"), 2, "expected one of: gold, green");
  expectRefused(with("[0.5, 1.5, 0.4", "[0.5, 1.5, 0.6"), 4, "start[2] (insertion) is 0.6, expected [0.23, 0.56]");
  expectRefused(with("[0.6, 1.6", "[-0.01, 1.6"), 5, "other[0] (shoulder) is -0.01, expected [0, 1.5708]");
  expectRefused(with("kind: tip", "kind: default"), 7, "expected one of: tip, joints");
  expectRefused(with("0.03]", "1.5]"), 8, "goal/tip_W[2] is 1.5, expected [-1, 1]");
  expectRefused(with("0.03]", ".nan]"), 8, "goal/tip_W[2] is nan");
  expectRefused(with(", 0.7, 0.8]", ", 0.7]"), 4, "start is not a list of 7 numbers");
}

TEST(LoadProblem, ProblemsAreFoundByNameAndByFile) {
  const std::vector<std::string> names{"impossible", "into_dome", "paper", "past_tower", "short_move", "two_arms"};
  EXPECT_EQ(namesIn(kFolder), names);
  for (const std::string& name : names) {
    EXPECT_EQ(findProblem(kFolder, name, geometry()).name, name);
    EXPECT_EQ(findProblem(kFolder, kFolder + "/" + name + ".yaml", geometry()).name, name);
  }
  try {
    findProblem(kFolder, "papre", geometry());
    FAIL() << "found";
  } catch (const ConfigException& e) {
    EXPECT_NE(std::string(e.what()).find("no problem is called \"papre\": did you mean \"paper\"?"), std::string::npos)
        << e.what();
  }
}

/** Start, other and goal, both sides. The joints are read in a loop. */
TEST(LoadProblem, TheJointsOfEveryPoseAreWithinTheirLimits) {
  const std::string joints_goal =
      with("  kind: tip\n  tip_W: [0.01, -0.02, 0.03]", "  kind: joints\n  joints: [1, 2, 0.3, 0, 0, 0.1, 0.2]");
  for (const auto& [key, line] : {std::pair("start", 4), std::pair("other", 5), std::pair("  joints", 8)}) {
    const std::string head = std::string(key) + ": [";
    const std::size_t place = joints_goal.find(head), end = joints_goal.find(']', place);
    for (const std::size_t j : {kShoulder, kInsertion, kGrasp2}) {
      for (const bool is_high : {false, true}) {
        JointArray q = geometry().home;
        q[j] = is_high ? geometry().q_max[j] + 0.01 : geometry().q_min[j] - 0.01;
        std::string list;
        for (const double value : q)
          list += (list.empty() ? "" : ", ") + std::to_string(value);
        std::string text = joints_goal;
        expectRefused(text.replace(place, end - place, head + list), line, std::string("(") + kJointNames[j] + ")");
      }
    }
  }
}

}  // namespace
}  // namespace raven2_trainer::config
