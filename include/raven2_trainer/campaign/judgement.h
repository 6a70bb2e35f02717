#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "raven2_trainer/campaign/plan.h"
#include "raven2_trainer/campaign/results.h"

// What a finished campaign is held to: that every fault acted, every run came to an end, and every outcome is one that
// was published for its scenario or one that NAME_explained.yaml gives a reason for. Looks at the table alone: no
// outcome depends on it.

namespace raven2_trainer::campaign {

/** Why a scenario may come out otherwise than published. */
struct Explanation {
  std::vector<std::string> allowed;  ///< outcomes in addition to the published ones
  std::string why;
};

/** By "SCENARIO/PHASE", as "pd_tau_stuck/pedal_down". */
using Explanations = std::map<std::string, Explanation>;

/** NAME_explained.yaml next to NAME.yaml. */
std::string explanationsOf(const std::string& campaign_file);

/** Reads such a file; without a file nothing is explained.
 *  @throw ConfigException with FILE:LINE, also for a scenario that the campaign has not in that phase. */
Explanations loadExplanations(const std::string& path, const Campaign& campaign);

/** Leaves the explanations with the results, as NAME_explained.yaml, so that reports use the same. */
void keepExplanations(const Campaign& campaign, const OutputPaths& paths);

/** Errors of a table; all empty if it is right. */
struct Judgement {
  std::vector<std::uint32_t> never_acted;      ///< runs whose fault did nothing until the horizon
  std::vector<std::uint32_t> without_outcome;  ///< runs that came to no end
  /** Runs by "SCENARIO/PHASE: OUTCOME" that was neither published nor explained. */
  std::map<std::string, std::vector<std::uint32_t>> unexplained;
  /** "SCENARIO/PHASE" of which every run is masked, though that is neither all that was published nor all that is
   *  allowed: its fault does nothing. Of whole tables only. */
  std::vector<std::string> inert;

  bool isGood() const { return never_acted.empty() && without_outcome.empty() && unexplained.empty() && inert.empty(); }
};

/** @param[in] rows of outcomes.csv by run. Scenarios for which nothing was published are not compared. */
Judgement judge(const Campaign& campaign,
                const Explanations& explanations,
                const std::map<std::uint32_t, std::string>& rows);

/** One line for each thing that is wrong, with the first runs it is wrong of. */
std::string inWords(const Judgement& judgement);

}  // namespace raven2_trainer::campaign
