#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "raven2_trainer/campaign/outcome.h"
#include "raven2_trainer/campaign/plan.h"

// What is written of a campaign: outcomes.csv, one row an injection, sorted by run; campaign.json, what it was made of;
// and, while it runs, outcomes.part, from which a killed campaign goes on. The number of jobs changes only the order in
// outcomes.part, shards only campaign.json. Only runs that reach a time limit depend on a clock.

namespace raven2_trainer::campaign {

/** Report of a run's process. */
struct RunResult {
  Ending ending{Ending::kComplete};
  Figures figures{};  ///< valid if complete
};

/** Header of outcomes.csv, without the end of line. */
std::string header();
/** One row, without the end of line. */
std::string row(const Campaign& campaign, const CampaignRun& run, const RunResult& result);

/** Content of campaign.json. To resume, digest, shard and shards must be equal; to merge, digest and shards. */
struct Identity {
  std::string name, title, source;
  std::uint64_t seed{};
  std::string digest;   ///< of campaign, configuration and build
  std::size_t total{};  ///< runs of the whole campaign
  std::size_t shard{1}, shards{1};
  std::string experiments;  ///< JSON: what the report needs to know of them
};

/** @param[in] ingredients name and hash of everything else that decides over the outcomes. */
Identity identify(const Campaign& campaign, const std::map<std::string, std::string>& ingredients);

/** Paths in an output directory. */
struct OutputPaths {
  std::string directory;
  std::string outcomes() const { return directory + "/outcomes.csv"; }
  std::string part() const { return directory + "/outcomes.part"; }
  std::string identity() const { return directory + "/campaign.json"; }
  std::string timing() const { return directory + "/timing.json"; }
  std::string explanations(const std::string& name) const { return directory + "/" + name + "_explained.yaml"; }
};

/**
 * The rows so far, in a file that is only appended to; one process at a time.
 */
class PartialOutcomes {
 public:
  /**
   * Opens the directory for the runs of one shard. With `resume`, rows that an earlier process left are taken over:
   * those that are whole, up to the first that is not; runs without an outcome are to be made again.
   * @throw SessionException if there are results already and they are not to be resumed, or rows without their
 * campaign.json; if it is of another campaign, seed,
   * build or shard, if another process writes it, or if it cannot be written.
   */
  PartialOutcomes(const OutputPaths& paths,
                  const Identity& identity,
                  const Campaign& campaign,
                  bool resume,
                  int lock_wait = 0);
  ~PartialOutcomes();
  PartialOutcomes(const PartialOutcomes&) = delete;
  PartialOutcomes& operator=(const PartialOutcomes&) = delete;

  bool has(std::uint32_t run) const { return rows_.count(run) != 0; }
  std::size_t size() const { return rows_.size(); }
  const std::map<std::uint32_t, std::string>& rows() const { return rows_; }

  /** @throw SessionException if it cannot be written. */
  void add(std::uint32_t run, const std::string& row);

  /** Writes outcomes.csv and removes the partial file. @throw SessionException. */
  void finish();

 private:
  void openLocked(int wait);
  void lock(int wait);
  void takeOver(const Campaign& campaign);
  bool takeRow(const std::string& line, const Campaign& campaign);

  OutputPaths paths_;
  Identity identity_;
  int file_{-1};
  std::map<std::uint32_t, std::string> rows_;
};

/**
 * Puts the shards of a campaign together: the same bytes as one process would have written.
 * @throw SessionException for shards of different campaigns, a shard that is missing or given twice, a run that is
 * missing or twice.
 */
void mergeShards(const std::vector<std::string>& directories, const std::string& output);

}  // namespace raven2_trainer::campaign
