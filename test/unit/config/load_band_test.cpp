#include "raven2_trainer/config/load_band.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "config/named_files.h"
#include "raven2_trainer/config/load_curriculum.h"
#include "raven2_trainer/core/exceptions.h"
#include "support/yaml_file.h"

namespace raven2_trainer::config {
namespace {

using raven2_trainer::testing::expectEachRefused;
using raven2_trainer::testing::TemporaryFile;
namespace fs = std::filesystem;

constexpr const char* kBand = R"(origin: scripted expert, not surgeons
sessions: 20
least_spread: 0.25
metrics:
  time: {mean: 61.5, deviation: 2.0, better: lower, least: 0.0}
  sparc: {mean: -9.5, deviation: 0.4, better: higher, least: 0.1}
)";

constexpr const char* kCurriculum = R"(title: Two stages
deviations: 1.5
stages:
  - {exercise: peg_transfer, drill: none, passes: 2, extra: 10}
  - {exercise: ring_tower_transfer, drill: sudden_jump, passes: 1, extra: 0}
)";

Band bandOf(const std::string& text) {
  return loadBand(TemporaryFile("peg_transfer.yaml", text).path());
}

Curriculum curriculumOf(const std::string& text) {
  return loadCurriculum(TemporaryFile("basics.yaml", text).path());
}

TEST(LoadBand, ReadsEveryMetricInOrder) {
  const Band band = bandOf(kBand);
  EXPECT_EQ(band.exercise, "peg_transfer");
  EXPECT_EQ(band.origin, "scripted expert, not surgeons");
  EXPECT_EQ(band.sessions, 20);
  EXPECT_EQ(band.least_spread, 0.25);
  ASSERT_EQ(band.metrics.size(), 2u);
  EXPECT_EQ(band.metrics[0].name, "time");
  EXPECT_EQ(band.metrics[0].mean, 61.5);
  EXPECT_EQ(band.metrics[0].better, Better::kLower);
  EXPECT_EQ(band.metrics[1].deviation, 0.4);
  EXPECT_EQ(band.metrics[1].better, Better::kHigher);
  EXPECT_EQ(band.metrics[1].least, 0.1);
}

TEST(LoadBand, RefusesWhatIsWrongWithItsLine) {
  expectEachRefused(bandOf, kBand,
                    {{"sessions: 20", "sessions: 1", 2},
                     {"least_spread: 0.25", "least_spread: -0.1", 3},
                     {"deviation: 2.0", "deviation: -2.0", 5},
                     {"better: higher", "better: more", 6},
                     {", least: 0.0", "", 5},
                     {"least: 0.1", "least: 0.1, most: 3", 6},
                     {"mean: 61.5", "mean: .nan", 5},
                     {"origin:", "orgin:", 1},
                     {"  time:", "  tiem:", 5},
                     {"better: lower", "better: higher", 5},
                     {"better: higher", "better: lower", 6}});
}

TEST(LoadBand, ABandWithoutMetricsIsNone) {
  EXPECT_THROW(bandOf("origin: x\nsessions: 2\nleast_spread: 0\nmetrics: {}\n"), ConfigException);
}

TEST(FindBand, OfAnExerciseWithoutOneIsNothing) {
  const TemporaryFile file("peg_transfer.yaml", kBand);
  EXPECT_TRUE(findBand(file.folder(), "peg_transfer"));
  EXPECT_FALSE(findBand(file.folder(), "camera_clutch"));
}

TEST(LoadCurriculum, ReadsItsStages) {
  const Curriculum curriculum = curriculumOf(kCurriculum);
  EXPECT_EQ(curriculum.name, "basics");
  EXPECT_EQ(curriculum.title, "Two stages");
  EXPECT_EQ(curriculum.deviations, 1.5);
  ASSERT_EQ(curriculum.stages.size(), 2u);
  EXPECT_EQ(curriculum.stages[0].exercise, "peg_transfer");
  EXPECT_EQ(curriculum.stages[0].drill, "");
  EXPECT_EQ(curriculum.stages[0].extra, 10);
  EXPECT_EQ(curriculum.stages[1].drill, "sudden_jump");
  EXPECT_EQ(curriculum.stages[1].passes, 1);
}

TEST(LoadCurriculum, RefusesWhatIsWrongWithItsLine) {
  expectEachRefused(curriculumOf, kCurriculum,
                    {{"deviations: 1.5", "deviations: 0", 2},
                     {"passes: 2", "passes: 0", 4},
                     {"exercise: peg_transfer", "exercise: ../peg_transfer", 4},
                     {"drill: sudden_jump", "drill: \"\"", 5},
                     {"extra: 10", "extra: ten", 4},
                     {", extra: 0", "", 5},
                     {"title:", "titel:", 1}});
}

TEST(LoadCurriculum, ACurriculumWithoutStagesIsNone) {
  EXPECT_THROW(curriculumOf("title: x\ndeviations: 1\nstages: []\n"), ConfigException);
}

TEST(FindCurriculum, ListsTheKnownOnes) {
  const TemporaryFile file("basics.yaml", kCurriculum);
  EXPECT_EQ(findCurriculum(file.folder(), "basics").stages.size(), 2u);
  try {
    findCurriculum(file.folder(), "advanced");
    ADD_FAILURE();
  } catch (const ConfigException& e) {
    EXPECT_NE(std::string(e.what()).find("basics"), std::string::npos);
  }
}

TEST(FindCurriculum, ThePackagedOnesAreReadable) {
  const std::string folder = std::string(RAVEN2_TRAINER_SOURCE_DIR) + "/config/curricula";
  const std::vector<std::string> names = namesIn(folder);
  EXPECT_NE(std::find(names.begin(), names.end(), "frs_basics"), names.end());
  for (const std::string& name : names)
    EXPECT_FALSE(findCurriculum(folder, name).stages.empty()) << name;
  const Curriculum basics = findCurriculum(folder, "frs_basics");
  for (const CurriculumStage& stage : basics.stages) {
    const fs::path scenario = fs::path(RAVEN2_TRAINER_SOURCE_DIR) / "config/faults" / (stage.drill + ".yaml");
    EXPECT_TRUE(stage.drill.empty() || fs::exists(scenario)) << stage.drill;
  }
}

/** doc/scores.md: both limits of every number of a band and of a curriculum. */
TEST(LoadBand, BothLimitsOfEveryNumberHold) {
  expectEachRefused(bandOf, kBand,
                    {{"sessions: 20", "sessions: 1000001", 2},
                     {"least_spread: 0.25", "least_spread: 10.1", 3},
                     {"mean: 61.5", "mean: 1000001", 5},
                     {"mean: -9.5", "mean: -1000001", 6},
                     {"deviation: 2.0", "deviation: -0.001", 5},
                     {"deviation: 2.0", "deviation: 1000001", 5},
                     {"least: 0.1", "least: -0.1", 6},
                     {"least: 0.1", "least: 1000001", 6}});
  expectEachRefused(curriculumOf, kCurriculum,
                    {{"deviations: 1.5", "deviations: 5.1", 2},
                     {"passes: 2", "passes: 101", 4},
                     {"extra: 10", "extra: -1", 4},
                     {"extra: 10", "extra: 1001", 4}});
}

}  // namespace
}  // namespace raven2_trainer::config
