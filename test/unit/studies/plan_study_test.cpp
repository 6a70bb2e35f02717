#include "raven2_trainer/studies/plan_study.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/config/load_problem.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"
#include "raven2_trainer/physics/raven_world.h"
#include "raven2_trainer/studies/plan_files.h"
#include "raven2_trainer/studies/plan_tables.h"

namespace raven2_trainer::studies {
namespace {

namespace fs = std::filesystem;

const std::string kSource = RAVEN2_TRAINER_SOURCE_DIR;

const TrainerConfig& trainer() {
  static const TrainerConfig config = config::loadTrainerConfig(kSource + "/config/trainer.yaml");
  return config;
}

PlanProblem problem(const std::string& name) {
  return config::findProblem(kSource + "/config/problems", name, trainer().arms.geometry);
}

/** The little study of the short move: two cases, three runs each. */
std::vector<PlanRun> study(int threads) {
  PlanChoice choice;
  choice.samples = {40, 80};
  choice.eta = {0.1, 0.5, 0.0};
  PlanStudyOptions options;
  options.cases = tableCases(trainer().planner, choice);
  options.runs = 3;
  options.seed = 11;
  options.threads = threads;
  std::vector<PlanRun> runs;
  runPlanStudy(trainer(), problem("short_move"), options, [&](PlanRun run) { runs.push_back(std::move(run)); });
  return runs;
}

TEST(PlanCases, MultiplyPlannersSamplesAndCosts) {
  PlanChoice choice;
  choice.planners = {"FMTstar", "RRTConnect"};
  choice.samples = {200, 5000};
  const auto cases = tableCases(trainer().planner, choice);
  ASSERT_EQ(cases.size(), 8U);
  EXPECT_EQ(cases[0].planner, "FMTstar");
  EXPECT_EQ(cases[7].planner, "RRTConnect");
  EXPECT_EQ(cases[0].eta_clearance, 0.0) << "the paper's cost comes first";
  EXPECT_EQ(cases[2].eta_clearance, trainer().planner.eta_clearance);
  EXPECT_EQ(cases[0].eta_length, trainer().planner.eta_length);
  EXPECT_EQ(cases[1].samples, 5000U);
  EXPECT_GE(cases[1].max_samples, 5000U) << "never less than it begins with";
}

TEST(PlanCases, TakeWhatIsChosen) {
  PlanChoice choice;
  choice.samples = {200};
  choice.eta = {0.3, 0.7};
  choice.time_limit = 9.0;
  choice.improve_attempts = 0;
  choice.is_exact = true;
  auto cases = tableCases(trainer().planner, choice);
  ASSERT_EQ(cases.size(), 2U);
  EXPECT_EQ(cases[1].eta_length, 0.3);
  EXPECT_EQ(cases[1].eta_acceleration, 0.7);
  EXPECT_EQ(cases[1].time_limit, 9.0);
  EXPECT_EQ(cases[1].improve_attempts, 0U);
  EXPECT_EQ(cases[1].max_samples, 200U);
  choice.eta.push_back(0.2);
  cases = tableCases(trainer().planner, choice);
  ASSERT_EQ(cases.size(), 1U) << "only the requested one";
  EXPECT_EQ(cases[0].eta_clearance, 0.2);
}

TEST(PlanCases, AComparisonLetsAnytimePlannersUseTheirTime) {
  PlanChoice choice;
  choice.planners = {"FMTstar", "BITstar", "RRTConnect"};
  choice.samples = {200, 500};
  choice.times = {0.1, 10.0};
  const auto cases = comparisonCases(trainer().planner, choice);
  ASSERT_EQ(cases.size(), 4U + 2U + 2U) << "n is nothing to planners that do not take it";
  EXPECT_FALSE(cases[0].until_time_limit);
  EXPECT_EQ(cases[0].time_limit, 0.1);
  EXPECT_EQ(cases[3].samples, 500U);
  EXPECT_EQ(cases[3].time_limit, 10.0);
  EXPECT_TRUE(cases[5].until_time_limit);
  EXPECT_FALSE(cases[7].until_time_limit) << "ends with its first path";
  for (const auto& each : cases)
    EXPECT_EQ(each.eta_clearance, 0.0) << "one cost for all";
}

TEST(PlanCases, FigureSevenHasTheTwoEndsOfTheCost) {
  const auto cases = figureCases(trainer().planner, {});
  ASSERT_EQ(cases.size(), 2U);
  EXPECT_EQ(cases[0].samples, 500U);
  EXPECT_EQ((std::array<double, 3>{cases[0].eta_length, cases[0].eta_acceleration, cases[0].eta_clearance}),
            (std::array<double, 3>{1.0, 0.0, 0.0}));
  EXPECT_EQ((std::array<double, 3>{cases[1].eta_length, cases[1].eta_acceleration, cases[1].eta_clearance}),
            (std::array<double, 3>{0.0, 1.0, 0.0}));
}

TEST(PlanStudy, RunsComeInOrderAndDoNotDependOnThreads) {
  const std::vector<PlanRun> alone = study(1), together = study(2);
  ASSERT_EQ(alone.size(), 6U);
  ASSERT_EQ(together.size(), 6U);
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(together[i].case_index, i / 3);
    EXPECT_EQ(together[i].run, static_cast<int>(i % 3) + 1);
    EXPECT_EQ(together[i].seed, 11 + i % 3);
    EXPECT_TRUE(isSuccess(alone[i])) << reasonOf(alone[i]);
    EXPECT_EQ(together[i].result.waypoints, alone[i].result.waypoints);
    EXPECT_EQ(together[i].result.cost, alone[i].result.cost);
    EXPECT_EQ(together[i].track.duration, alone[i].track.duration);
  }
}

TEST(PlanStudy, WhatTakesTheRunsMayEndIt) {
  PlanStudyOptions options;
  options.cases = figureCases(trainer().planner, {});
  options.runs = 50;
  options.threads = 2;
  int taken = 0;
  const auto full = [&](const PlanRun&) {
    ++taken;
    throw SessionException("the disk is full");
  };
  EXPECT_THROW(runPlanStudy(trainer(), problem("short_move"), options, full), SessionException);
  EXPECT_EQ(taken, 1) << "a run that could not be taken is not offered again, nor any other";
}

class PathTracker : public ::testing::Test {
 protected:
  void SetUp() override {
    physics::initialiseOde();
    physics::attachOdeToThread();
  }

  /** Straight to where a free plan of the problem would end: two waypoints. */
  PlanResult straight(const std::string& name) const {
    const PlanRequest request = problem(name).request;
    planning::PathPlanner planner(raven_, scene_, trainer().planner);
    PlanResult plan = planner.plan(request, 1, true, std::atomic<bool>{false});
    EXPECT_EQ(plan.status, PlanStatus::kSuccess);
    plan.waypoints[1] = plan.waypoints[plan.waypoint_count - 1];
    plan.waypoint_count = 2;
    plan.arrival[1] = 3.0;
    return plan;
  }

  Vector3 tip(const PlanResult& plan, const JointArray& q) const {
    return at(raven_.X_WB, plan.arm) * kinematics::forward(raven_.arms.geometry, plan.arm, q).p;
  }

  const model::RavenModel raven_ = model::loadRavenModel(trainer());
  const model::SceneModel scene_ = model::loadSceneModel(trainer());
  const JointArray home_ = trainer().arms.geometry.home;
};

TEST_F(PathTracker, AFreePlanIsTrackedToRestAtItsGoal) {
  const PlanResult plan = straight("short_move");
  const loop::TrackedPath track = loop::trackPlan(raven_, scene_, trainer().model, plan, home_);
  EXPECT_FALSE(track.has_touched);
  EXPECT_FALSE(track.has_failed);
  EXPECT_GE(track.duration, 3.0);
  EXPECT_LT(track.duration, 4.0);
  EXPECT_LT(track.error, 0.002) << "[m] twice what the law leaves on slow motions (doc/model.md)";
  ASSERT_GT(track.samples.size(), 1500U);
  EXPECT_LT((toEigen(track.samples.front().p_W) - tip(plan, plan.waypoints[0])).norm(), 1e-9);
  EXPECT_LT((toEigen(track.samples.back().p_W) - tip(plan, plan.waypoints[1])).norm(), 0.001);
  EXPECT_EQ(track.samples.front().waypoint, 0U);
  EXPECT_EQ(track.samples.back().waypoint, 1U);
  EXPECT_DOUBLE_EQ(track.samples[1].time, 0.002);
}

TEST_F(PathTracker, WhatStandsInTheWayIsTouched) {
  EXPECT_TRUE(loop::trackPlan(raven_, scene_, trainer().model, straight("past_tower"), home_).has_touched);
}

TEST_F(PathTracker, TheOtherArmStandsWhereItIsSaidTo) {
  const PlanProblem two = problem("two_arms");
  const PlanResult plan = straight("two_arms");
  EXPECT_TRUE(loop::trackPlan(raven_, scene_, trainer().model, plan, two.request.other).has_touched);
}

TEST_F(PathTracker, TheStraightMotionPassesThroughEverything) {
  const PlanResult plan = straight("past_tower");
  const loop::TrackedPath motion = loop::straightMotion(raven_, trainer().planner, plan);
  ASSERT_GT(motion.samples.size(), 2U);
  EXPECT_EQ(motion.samples.front().q, plan.waypoints[0]);
  EXPECT_LT((toEigen(motion.samples.back().p_W) - tip(plan, plan.waypoints[1])).norm(), 1e-4);
  // [rad/s] as fast as the limits allow, no faster
  double fastest = 0.0;
  for (std::size_t i = 1; i < motion.samples.size(); ++i) {
    for (std::size_t j = 0; j < kJointCount; ++j) {
      const double rate = std::abs(motion.samples[i].q[j] - motion.samples[i - 1].q[j]) / 0.002;
      fastest = std::max(fastest, rate / trainer().planner.velocity_limit[j]);
    }
  }
  EXPECT_LT(fastest, 1.0 + 1e-6);
  EXPECT_GT(fastest, 0.2);
}

TEST(PlanFiles, EveryPlanHasItsFilesAndEveryStudyItsFolder) {
  const fs::path folder = fs::temp_directory_path() / ("raven2_plans_" + std::to_string(getpid()));
  fs::remove_all(folder);
  planning::PlanOptions options = planning::defaultOptions(trainer().planner);
  PlanRun run;
  run.run = 1;
  run.result.status = PlanStatus::kSuccess;
  run.result.waypoint_count = 2;
  run.track.samples.resize(3);
  PlanRun failed;
  failed.run = 2;
  failed.result.status = PlanStatus::kNoPath;
  PlanFiles files(folder.string(), "runs.csv");
  files.add(options, run);
  files.add(options, failed);
  files.close();
  const auto lines = [](const fs::path& path) {
    std::ifstream in(path);
    std::stringstream text;
    text << in.rdbuf();
    const std::string all = text.str();
    return std::count(all.begin(), all.end(), '\n');
  };
  EXPECT_EQ(lines(folder / "runs.csv"), 3);
  EXPECT_EQ(lines(folder / "paths" / (pathName(options, 1) + ".csv")), 4);
  EXPECT_EQ(lines(folder / "paths" / (pathName(options, 1) + "_waypoints.csv")), 3);
  EXPECT_FALSE(fs::exists(folder / "paths" / (pathName(options, 2) + ".csv")));
  EXPECT_THROW(PlanFiles(folder.string(), "runs.csv"), SessionException) << "would mix two studies";
  EXPECT_THROW(PlanFiles("/proc/nowhere", "runs.csv"), SessionException);
  fs::remove_all(folder);
}

}  // namespace
}  // namespace raven2_trainer::studies
