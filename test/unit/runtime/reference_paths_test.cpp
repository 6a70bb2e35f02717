#include "raven2_trainer/runtime/reference_paths.h"

#include <cmath>

#include "gtest/gtest.h"
#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/config/load_problem.h"

namespace raven2_trainer::runtime {
namespace {

constexpr const char* kSource = RAVEN2_TRAINER_SOURCE_DIR;

double distance(const Vec3& a, const Vec3& b) {
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

class ReferencePathsTest : public ::testing::Test {
 protected:
  /** From where a problem starts to a tip place. */
  training::Transit transitOf(const std::string& problem, const Vec3& goal_W) const {
    const PlanProblem p =
        config::loadProblem(std::string(kSource) + "/config/problems/" + problem + ".yaml", config_.arms.geometry);
    return {p.request.arm, p.request.start, p.request.other, {{}, goal_W}};
  }

  TrainerConfig config_ = config::loadTrainerConfig(std::string(kSource) + "/config/trainer.yaml");
  ReferencePaths reference_{config_};
};

TEST_F(ReferencePathsTest, LeadFromTheJointsToThePlaceAndAreTheSameEachTime) {
  training::Transit transit = transitOf("short_move", {0.0, 0.02, 0.06});
  const std::vector<Vec3> there = reference_.plan(transit);
  ASSERT_GT(there.size(), 1u);
  EXPECT_LT(distance(there.back(), transit.way_W.back()), 1e-6);
  EXPECT_EQ(reference_.plan(transit), there);
  ReferencePaths another(config_);
  EXPECT_EQ(another.plan(transit), there);
}

TEST_F(ReferencePathsTest, AreHardlyLongerThanTheLineWhereThatIsFree) {
  const training::Transit transit = transitOf("short_move", {0.0, 0.02, 0.06});
  const std::vector<Vec3> way = reference_.plan(transit);
  ASSERT_GT(way.size(), 1u);
  const double line = distance(way.front(), way.back());
  EXPECT_GT(line, 0.01);
  EXPECT_LT(training::lengthOf(way), 1.25 * line);  // straight in joints, not for the tip
}

TEST_F(ReferencePathsTest, OfAPlaceOutOfReachAreNone) {
  EXPECT_TRUE(reference_.plan(transitOf("short_move", {0.9, 0.0, 0.0})).empty());
}

}  // namespace
}  // namespace raven2_trainer::runtime
