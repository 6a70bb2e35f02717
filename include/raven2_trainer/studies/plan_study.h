#pragma once

#include <functional>
#include <string>
#include <vector>

#include "raven2_trainer/config/trainer_config.h"
#include "raven2_trainer/loop/path_tracker.h"
#include "raven2_trainer/planning/path_planner.h"
#include "raven2_trainer/planning/plan_problem.h"

// For the program `plan`: one problem, planned and tracked again and again (paper, 3.3, Table 2).

namespace raven2_trainer::studies {

/** Choices for a study; each list multiplies the others. */
struct PlanChoice {
  std::vector<std::string> planners{"FMTstar"};
  std::vector<std::uint32_t> samples{200, 500, 1000, 2000};  ///< n of the paper's Table 2
  std::vector<double> eta;    ///< eta1, eta2 of eq. (1), eta3 of the clearance term; the configuration's where missing
  std::vector<double> times;  ///< [s] for comparisonCases()
  double time_limit{};        ///< [s] of one plan; the configuration's if 0
  int improve_attempts{-1};   ///< the configuration's if negative
  bool is_exact{};            ///< no samples are added after a failure
};

/**
 * Planner by planner, n by n, first with the paper's eq. (1) alone (eta3 = 0), then with the clearance term; only with
 * the one that is asked for if `eta` has three values.
 */
std::vector<planning::PlanOptions> tableCases(const PlannerConfig& config, const PlanChoice& choice);

/**
 * Planner by planner, time by time, all with one cost: `eta`, without a third value the paper's eq. (1) alone. Planners
 * that take n samples have one case for each n and time, the others one a time; anytime planners use all of it.
 */
std::vector<planning::PlanOptions> comparisonCases(const PlannerConfig& config, const PlanChoice& choice);

/** The two of the paper's Figure 7: 500 samples, the shortest path and the smoothest one. */
std::vector<planning::PlanOptions> figureCases(const PlannerConfig& config, const PlanChoice& choice);

struct PlanStudyOptions {
  std::vector<planning::PlanOptions> cases;  ///< each is planned `runs` times
  int runs{20};
  std::uint64_t seed{1};  ///< of each case's first run; the next take the next, so that cases meet the same samples
  int threads{1};         ///< that plan side by side; planning times are then longer, and vary more
};

/** One plan, and what became of it. */
struct PlanRun {
  std::size_t case_index{};  ///< in PlanStudyOptions::cases
  int run{};                 ///< from 1
  std::uint64_t seed{};
  PlanResult result{};
  planning::PlanStatistics statistics{};
  loop::TrackedPath track;  ///< empty without a plan
};

/** Planned, and tracked without a contact, by the planner's roll-out and by the session's world alike. */
bool isSuccess(const PlanRun& run);

/** Why not, in a word: the planner's status; "contact" for a plan on which the arm touched something. */
const char* reasonOf(const PlanRun& run);

/**
 * Runs a study. Each thread has its own planner; what belongs to the scene is worked out before the first run.
 * @param[in] take gets each run in the order of cases and runs, one at a time, from any thread; may keep it.
 * @throw ModelException, and what `take` throws.
 */
void runPlanStudy(const TrainerConfig& config,
                  const PlanProblem& problem,
                  const PlanStudyOptions& options,
                  const std::function<void(PlanRun)>& take);

}  // namespace raven2_trainer::studies
