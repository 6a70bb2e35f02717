#include "raven2_trainer/loop/planner_worker.h"

#include <gtest/gtest.h>

#include "raven2_trainer/config/load_problem.h"
#include "support/rig.h"

namespace raven2_trainer::loop {
namespace {

TEST(PlannerWorkers, CountWhatThePlanTook) {
  raven2_trainer::testing::useOde();
  TrainerConfig config = raven2_trainer::testing::packagedConfig();
  config.planner.samples = 100;
  raven2_trainer::testing::Rig rig(config);
  PlannerWorker worker(config, rig.raven, rig.scene, rig.shared.get());
  EXPECT_EQ(worker.counts().samples, 0U);
  EXPECT_EQ(worker.counts().best_cost, 0.0);

  PlanRequest request;
  request.id = 1;
  request.start = config.arms.geometry.home;
  request.other = config.arms.geometry.home;
  const PlanResult result = worker.planNow(request);
  ASSERT_EQ(result.status, PlanStatus::kSuccess);
  const PlanCounts counts = worker.counts();
  EXPECT_GE(counts.samples, 100U);
  EXPECT_GT(counts.edges, 0U);
  EXPECT_GT(counts.rollouts, 0U) << "the dynamics follow every plan before it is returned";
  EXPECT_EQ(counts.best_cost, result.cost);
}

TEST(PlannerWorkers, DrawTheirSamplesFromTheSessionsSeed) {
  raven2_trainer::testing::useOde();
  TrainerConfig config = raven2_trainer::testing::packagedConfig();
  config.planner.samples = 100;
  const PlanRequest request =
      config::loadProblem(RAVEN2_TRAINER_SOURCE_DIR "/config/problems/past_tower.yaml", config.arms.geometry).request;
  const auto waypoints = [&](std::uint64_t seed) {
    config.seed = seed;
    raven2_trainer::testing::Rig rig(config);
    PlannerWorker worker(config, rig.raven, rig.scene, rig.shared.get());
    const PlanResult plan = worker.planNow(request);
    EXPECT_EQ(plan.status, PlanStatus::kSuccess);
    return plan.waypoints;
  };
  const auto of_five = waypoints(5);
  EXPECT_EQ(waypoints(5), of_five);
  EXPECT_NE(waypoints(6), of_five);
}

}  // namespace
}  // namespace raven2_trainer::loop
