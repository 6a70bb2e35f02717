#include <gtest/gtest.h>

#include <array>
#include <set>

#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/config/load_training.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/core/fault_variables.h"
#include "raven2_trainer/faults/arming.h"

namespace raven2_trainer::config {
namespace {

constexpr const char* kRoot = RAVEN2_TRAINER_SOURCE_DIR "/config/trainer.yaml";
constexpr std::array<const char*, 6> kExercises{"pick_hand_over_place", "ring_tower_transfer", "ring_along_loops",
                                                "peg_transfer",         "retrieve_and_reach",  "camera_clutch"};

TrainerConfig drilled(const std::string& exercise, const std::string& drill) {
  return loadTrainerConfig(kRoot, {exercise, drill, "", "none"});
}

std::string message(const std::string& exercise, const std::string& drill) {
  try {
    drilled(exercise, drill);
  } catch (const ConfigException& e) {
    return e.what();
  }
  return "";
}

TEST(DrillPlan, OwnIsTheScenarioThatTheExerciseNames) {
  for (const char* name : kExercises) {
    const TrainerConfig config = drilled(name, "own");
    EXPECT_FALSE(config.exercise.drill.scenario.empty()) << name;
    EXPECT_EQ(config.drill, config.exercise.drill.scenario) << name;
    EXPECT_EQ(config.hazard, config.drill) << name;
    EXPECT_TRUE(faults::isDrill(config)) << name;
    EXPECT_NE(faultId(config, config.drill), 0U) << name;
  }
}

TEST(DrillPlan, NoneOrAnUnknownOneIsNone) {
  EXPECT_EQ(drilled("camera_clutch", "none").hazard, "none") << "it takes the place of the root's hazard";
  EXPECT_FALSE(faults::isDrill(drilled("camera_clutch", "none")));
  EXPECT_NE(message("pick_hand_over_place", "no_such_hazard").find("no hazard is called \"no_such_hazard\""),
            std::string::npos);
  EXPECT_NE(message("none", "own").find("there is no exercise"), std::string::npos);
}

TEST(DrillPlan, ComesOnceOnTheExercisesTrigger) {
  const TrainerConfig config = drilled("pick_hand_over_place", "own");
  const ExerciseDrill& drill = config.exercise.drill;
  const FaultPlan plan = faults::drillPlan(config, 1, 7),
                  library = faults::planFor(config, faultId(config, "sudden_jump"), 7);
  ASSERT_EQ(plan.count, 1U);
  EXPECT_EQ(plan.generation, 7U);
  const Fault& row = plan.faults[0];
  EXPECT_EQ(row.trigger, FaultTrigger::kStep);
  EXPECT_EQ(row.threshold, static_cast<double>(drill.step));
  EXPECT_GE(row.first_tick, static_cast<Tick>(1000 * drill.delay));
  EXPECT_LE(row.first_tick, static_cast<Tick>(1000 * (drill.delay + drill.jitter)));
  EXPECT_EQ(row.period_ticks, 0);
  EXPECT_EQ(row.count, 1);
  EXPECT_EQ(row.value, library.faults[0].value) << "the fault's effect is that of the library";
  EXPECT_EQ(row.duration_ticks, library.faults[0].duration_ticks);
  EXPECT_EQ(row.id, library.faults[0].id);
  EXPECT_EQ(row.seed, library.faults[0].seed);
}

TEST(DrillPlan, TheSeedAndTheAttemptDrawTheJitter) {
  TrainerConfig config = drilled("pick_hand_over_place", "own");
  std::set<Tick> drawn;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    config.seed = seed;
    for (std::uint32_t attempt = 1; attempt <= 10; ++attempt) {
      const Tick tick = faults::drillPlan(config, attempt, 1).faults[0].first_tick;
      EXPECT_EQ(tick, faults::drillPlan(config, attempt, 2).faults[0].first_tick);
      drawn.insert(tick);
    }
  }
  EXPECT_GT(drawn.size(), 80U) << "a hundred draws from a thousand";
  EXPECT_LT(*drawn.begin(), 600) << "uniform in [500, 1500]";
  EXPECT_GT(*drawn.rbegin(), 1400);
}

TEST(DrillPlan, EveryScenarioOfTheLibraryMakesASoundDrillAndKeepsItsOrder) {
  TrainerConfig config = drilled("pick_hand_over_place", "own");
  for (const Scenario& scenario : config.scenarios) {
    config.drill = config.hazard = scenario.name;
    const FaultPlan plan = faults::drillPlan(config, 3, 1);
    ASSERT_EQ(plan.count, scenario.faults.size()) << scenario.name;
    for (std::size_t i = 0; i < plan.count; ++i) {
      EXPECT_TRUE(isSound(plan.faults[i])) << scenario.name;
      EXPECT_GE(plan.faults[i].first_tick, 500) << scenario.name;
      EXPECT_EQ(plan.faults[i].first_tick - plan.faults[0].first_tick,
                scenario.faults[i].first_tick - scenario.faults[0].first_tick)
          << scenario.name;
    }
  }
}

/** The library's rows are 60 ms apart, the later one first; they start by chance and repeatedly. */
TEST(DrillPlan, KeepsItsRowsApartAndComesForSureAndOnce) {
  TrainerConfig config = drilled("pick_hand_over_place", "own");
  Scenario& scenario = config.scenarios.at(faultId(config, config.drill) - 1);
  scenario.faults.resize(1);
  scenario.faults.push_back(scenario.faults[0]);
  scenario.faults[0].first_tick = 100;
  scenario.faults[1].first_tick = 40;
  for (Fault& fault : scenario.faults) {
    fault.period_ticks = 5000;
    fault.count = 9;
    fault.probability = 0.25;
  }
  const FaultPlan injected = faults::immediatePlan(config, faultId(config, config.drill), 1);
  ASSERT_EQ(injected.count, 2U);
  EXPECT_EQ(injected.faults[0].first_tick, 60);
  EXPECT_EQ(injected.faults[1].first_tick, 0);
  const FaultPlan plan = faults::drillPlan(config, 1, 1);
  ASSERT_EQ(plan.count, 2U);
  EXPECT_EQ(plan.faults[0].first_tick - plan.faults[1].first_tick, 60);
  EXPECT_GE(plan.faults[1].first_tick, static_cast<Tick>(1000 * config.exercise.drill.delay));
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(plan.faults[i].period_ticks, 0) << i;
    EXPECT_EQ(plan.faults[i].count, 1) << i;
    EXPECT_EQ(plan.faults[i].probability, 1.0) << i;
  }
}

TEST(DrillPlan, IsEmptyWithoutADrillAndWhereNothingMayBeInjected) {
  TrainerConfig config = drilled("pick_hand_over_place", "own");
  config.injection.enable = false;
  EXPECT_EQ(faults::drillPlan(config, 1, 1).count, 0U);
  EXPECT_THROW(checkHazard(config), ConfigException);
  config.injection.enable = true;
  config.hazard = "none";
  EXPECT_EQ(faults::drillPlan(config, 1, 1).count, 0U);
}

}  // namespace
}  // namespace raven2_trainer::config
