#include "raven2_trainer/core/mode.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <string>
#include <vector>

namespace raven2_trainer {
namespace {

constexpr std::array<const char*, kActivityCount> kActivityNames{
    "execution", "trial", "planning", "hold", "teleoperation", "goal selection", "returning", "replay", "camera"};
constexpr std::array<const char*, 4> kMovesNames{"", "model", "both", "both if asked"};
constexpr std::array<const char*, 3> kWorldNames{"meets", "passes", "still"};
constexpr std::array<const char*, 3> kPracticeNames{"", "simulation", "trial"};
constexpr std::array<const char*, 3> kSeeksNames{"", "goal", "path"};

std::string cell(const char* text) {
  return std::string(" |") + (*text != '\0' ? " " : "") + text;
}

/** The page's row of a mode. */
std::string rowOf(std::size_t mode) {
  const ModeTraits t = traitsOf(static_cast<Mode>(mode));
  std::string row = std::string("| ") + kModeNames[mode];
  row += cell(kActivityNames[static_cast<std::size_t>(t.activity)]) +
         cell(kMovesNames[static_cast<std::size_t>(t.moves)]) + cell(kWorldNames[static_cast<std::size_t>(t.world)]);
  for (const bool mark :
       {t.hands, t.keeps_plan, t.keeps_trial, t.keeps_repeat, t.keeps_scene, t.clients_hold, t.begins, t.timed,
        t.judged, t.follows_plan, t.may_replay, t.may_restart, t.follows_robot, t.leaves_robot})
    row += cell(mark ? "x" : "");
  return row + cell(kPracticeNames[static_cast<std::size_t>(t.practice)]) +
         cell(kSeeksNames[static_cast<std::size_t>(t.seeks)]) + " |";
}

/** Lines of the table of doc/modes.md whose first column is a mode. */
std::vector<std::string> rowsOfPage() {
  std::ifstream page(RAVEN2_TRAINER_SOURCE_DIR "/doc/modes.md");
  std::vector<std::string> rows;
  std::string line;
  bool in_table = false;
  while (std::getline(page, line)) {
    if (line.rfind("| mode |", 0) == 0) in_table = true;
    if (line.empty()) in_table = false;
    if (in_table) rows.push_back(line);
  }
  if (rows.size() > 2) rows.erase(rows.begin(), rows.begin() + 2);
  return rows;
}

std::vector<std::string> rowsOfTraits() {
  std::vector<std::string> rows;
  for (std::size_t mode = 0; mode < kModeCount; ++mode)
    rows.push_back(rowOf(mode));
  return rows;
}

TEST(ModeTraits, AreWhatThePageSays) {
  EXPECT_EQ(rowsOfPage(), rowsOfTraits());
}

// A mode that moves the robot lets the model meet the scene, and a mode that follows a plan may keep it. Practice
// moves the model alone.
TEST(ModeTraits, GoTogether) {
  for (std::size_t mode = 0; mode < kModeCount; ++mode) {
    const ModeTraits t = traitsOf(static_cast<Mode>(mode));
    EXPECT_TRUE(!mayMoveRobot(t.moves) || t.world == WorldMotion::kMeets) << kModeNames[mode];
    EXPECT_TRUE(!t.judged || t.world == WorldMotion::kMeets) << kModeNames[mode];
    EXPECT_TRUE(!t.follows_plan || t.keeps_plan) << kModeNames[mode];
    EXPECT_TRUE(!t.hands || t.world != WorldMotion::kPasses) << kModeNames[mode];
    EXPECT_TRUE(!t.keeps_repeat || t.keeps_trial) << kModeNames[mode];
    EXPECT_TRUE(!t.follows_robot || t.moves == Moves::kNothing) << kModeNames[mode];
    EXPECT_TRUE(t.practice == Practice::kNone || t.moves == Moves::kModel) << kModeNames[mode];
    EXPECT_TRUE(t.practice != Practice::kTrial || t.keeps_trial) << kModeNames[mode];
    EXPECT_TRUE(t.practice == Practice::kNone || t.leaves_robot) << kModeNames[mode];
    EXPECT_TRUE(!t.keeps_trial || t.keeps_scene) << kModeNames[mode];
    EXPECT_TRUE(!t.follows_robot || !t.leaves_robot) << kModeNames[mode];
    EXPECT_TRUE(!t.follows_plan || t.leaves_robot) << kModeNames[mode];
    EXPECT_TRUE(t.moves != Moves::kBoth || !t.leaves_robot) << kModeNames[mode];
    EXPECT_TRUE(t.seeks == Seeks::kNothing || !t.keeps_plan) << kModeNames[mode];
  }
}

// Only an execution may be either with the robot or with the model alone.
TEST(ModeTraits, AModelThatIsLinkedIsApartInModesThatDoNotMoveTheRobot) {
  for (std::size_t i = 0; i < kModeCount; ++i) {
    const auto mode = static_cast<Mode>(i);
    EXPECT_EQ(isApart(mode, false), traitsOf(mode).leaves_robot) << kModeNames[i];
    EXPECT_EQ(isApart(mode, true), traitsOf(mode).leaves_robot && mode != Mode::kExecuting) << kModeNames[i];
  }
}

}  // namespace
}  // namespace raven2_trainer
