#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "raven2_trainer/campaign/outcome.h"
#include "raven2_trainer/campaign/plan.h"
#include "raven2_trainer/campaign/results.h"
#include "raven2_trainer/config/trainer_config.h"
#include "raven2_trainer/lockstep/lockstep_stack.h"

namespace raven2_trainer::campaign {

/** The data that a campaign compares, of a stack after its last tick. */
Sample sampleOf(const ArmsConfig& arms, const lockstep::LockstepStack& stack) noexcept;

/** The configuration of a campaign's runs: its plant, homing and contacts, nothing armed, no scheduled plan.
 *  @throw ConfigException. */
TrainerConfig configurationFor(const Campaign& campaign, TrainerConfig config);

/**
 * Makes all `runs`, each in a fork of its golden run at the last tick before its fault, `jobs` at a time. ODE must be
 * initialised; the process must have no threads.
 * @param[in] report is called for each run that ended, in any order.
 * @throw Exception if a golden run does not get to pedal-down, stops or ends.
 */
void makeRuns(const TrainerConfig& config,
              const Campaign& campaign,
              const std::vector<CampaignRun>& runs,
              std::size_t jobs,
              const std::function<void(const CampaignRun&, const RunResult&)>& report);

}  // namespace raven2_trainer::campaign
