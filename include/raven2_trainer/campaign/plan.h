#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "raven2_trainer/campaign/outcome.h"
#include "raven2_trainer/core/fault.h"

namespace raven2_trainer::campaign {

/** Where a run is forked from its golden one. */
enum class Phase : std::uint8_t {
  kHoming,     ///< before the robot's first cycle
  kPedalDown,  ///< in teleoperation, shortly before the fault can start
};
constexpr std::array<const char*, 2> kPhaseNames{"homing", "pedal_down"};

/** Shared by the runs of one scenario. */
struct Experiment {
  std::string name;
  std::int64_t injection{};            ///< row of the published table; 0 none
  std::int64_t number{};               ///< of the scenario library; 0 none
  std::string observed;                ///< what was published
  std::vector<std::string> published;  ///< classes of outcome that match the published observation
};

/** One injection. */
struct CampaignRun {
  std::uint32_t number{};       ///< from 1 in the campaign's order
  std::size_t experiment{};     ///< position in Campaign::experiments
  std::uint32_t repetition{};   ///< from 0: which motion of the surgeon's
  std::uint64_t seed{};         ///< of all that is random in the fault
  std::uint64_t motion_seed{};  ///< of the surgeon's motion, and so of the golden run
  Phase phase{Phase::kPedalDown};
  std::int64_t offset_ticks{};   ///< [ticks] from the first PEDAL_DN to the fork; homing: 0
  std::int64_t horizon_ticks{};  ///< [ticks] of the run from the fork
  FaultPlan plan{};
};

/** A campaign file with everything filled in. */
struct Campaign {
  std::string name, title, source;
  std::string file;  ///< its path
  std::uint64_t seed{};
  std::string plant;    ///< preset of config/plants; empty: the configuration's
  bool full_homing{};   ///< search of the hard stops
  bool arm_contacts{};  ///< the model's arms touch the scene
  Limits limits{};
  std::int64_t cpu_limit{};  ///< [s] of processor time a run may take: more is a hang
  std::vector<Experiment> experiments;
  std::vector<CampaignRun> runs;  ///< by number
};

/**
 * Reads a campaign file (doc/campaign.md) and fills in its grids, draws and repetitions.
 * @param[in] seed of everything random. @param[in] impairments names that kind `impair` may use.
 * @throw ConfigException with FILE:LINE.
 */
Campaign loadCampaign(const std::string& path, std::uint64_t seed, const std::vector<std::string>& impairments);
/** The same from a text; `name` stands for the file. */
Campaign readCampaign(const std::string& text,
                      const std::string& name,
                      std::uint64_t seed,
                      const std::vector<std::string>& impairments);

/** Runs in the order in which one process makes them: by golden run, then by fork. */
std::vector<CampaignRun> inOrderOfForks(const std::vector<CampaignRun>& runs);

/** The `shard`-th of `shards` parts, from 1: consecutive in the order of forks, so that few golden runs are made twice.
 *  @throw ConfigException if there is no such shard. */
std::vector<CampaignRun> shardOf(const std::vector<CampaignRun>& runs, std::size_t shard, std::size_t shards);

}  // namespace raven2_trainer::campaign
