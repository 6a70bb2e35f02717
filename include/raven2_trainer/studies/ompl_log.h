#pragma once

#include <string>
#include <vector>

#include "raven2_trainer/studies/plan_study.h"

namespace raven2_trainer::studies {

/** Description of a study, without its runs. */
struct OmplExperiment {
  std::string name;         ///< of the problem
  std::string description;  ///< of it
  std::string host;         ///< name of the computer
  std::string started_utc;  ///< 2026-11-26 00:30:00
  double seconds{};         ///< [s] spent
};

/** A study as OMPL's Benchmark writes it, for ompl_benchmark_statistics.py and Planner Arena
 * (ompl/doc/markdown/benchmark.md, OMPL 1.5): each case is a planner, `FMTstar_n500_eta0.1_0.5_0_t5`. Costs are eq.
 * (1),
 * times those of planning alone. */
std::string omplLog(const OmplExperiment& experiment,
                    const PlanStudyOptions& options,
                    const std::vector<PlanRun>& runs);

}  // namespace raven2_trainer::studies
