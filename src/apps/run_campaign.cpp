// Makes all runs of a campaign of fault injections in lockstep, faster than real time, each in its own process.

#include <sys/resource.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "apps/common/command_line.h"
#include "raven2_trainer/campaign/judgement.h"
#include "raven2_trainer/campaign/run_campaign.h"
#include "raven2_trainer/config/share_folder.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/model/mesh_files.h"
#include "raven2_trainer/physics/raven_world.h"
#include "raven2_trainer/recording/build_identity.h"
#include "raven2_trainer/session/session_directory.h"

namespace raven2_trainer {
namespace {

using Clock = std::chrono::steady_clock;

struct Options {
  std::string campaign, config, output, shard{"1/1"};
  std::uint64_t seed{1};
  std::size_t jobs{1};
  bool resume{false};
};

/** A file, or the name of one in config/campaigns. */
std::string campaignFile(const std::string& name) {
  if (name.find('/') != std::string::npos || name.find(".yaml") != std::string::npos) return name;
  return config::shareFolder() + "/config/campaigns/" + name + ".yaml";
}

constexpr int kLockWait = 120;  // [s] leases of network file systems are shorter

/** "I/N". */
void parseShard(const std::string& text, std::size_t* shard, std::size_t* shards) {
  char rest = 0;
  if (std::sscanf(text.c_str(), "%zu/%zu%c", shard, shards, &rest) != 2 || *shard < 1 || *shard > *shards)
    throw ConfigException("--shard is \"" + text + "\", expected I/N with 1 <= I <= N");
}

/** Everything that decides over the outcomes: files by their contents, wherever they lie. */
std::map<std::string, std::string> ingredients(const TrainerConfig& config, const campaign::Campaign& campaign) {
  std::map<std::string, std::string> all = recording::buildIdentity();
  std::size_t n = 0;
  for (const std::string& file : config.files)
    all["configuration " + std::to_string(n++)] = session::fileHash(file);
  for (const std::string& urdf : {config.robot_urdf, config.scene_urdf}) {
    all["urdf " + std::to_string(n++)] = session::fileHash(urdf);
    for (const std::string& mesh : model::meshFiles(urdf))
      all["mesh " + std::to_string(n++)] = session::fileHash(mesh);
  }
  all["campaign"] = session::fileHash(campaign.file);
  return all;
}

double seconds(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

double processorTime(int who) {
  rusage usage{};
  getrusage(who, &usage);
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

void writeTiming(const campaign::OutputPaths& paths, std::size_t runs, std::size_t jobs, double wall) {
  const double children = processorTime(RUSAGE_CHILDREN);
  const double all = children + processorTime(RUSAGE_SELF);
  const nlohmann::ordered_json timing{{"runs", runs},
                                      {"jobs", jobs},
                                      {"wall_s", wall},
                                      {"cpu_s", all},
                                      {"cpu_s_of_runs", children},
                                      {"cpu_s_per_run", runs == 0 ? 0.0 : all / static_cast<double>(runs)}};
  std::ofstream(paths.timing()) << timing.dump(1) << "\n";
}

std::string timeLeft(Clock::time_point start, std::size_t done, std::size_t all) {
  const double passed = std::chrono::duration<double>(Clock::now() - start).count();
  const auto left = static_cast<long>(passed / static_cast<double>(done) * static_cast<double>(all - done));
  char text[64];
  std::snprintf(text, sizeof(text), "%zu of %zu runs, %ld:%02ld min left", done, all, left / 60, left % 60);
  return text;
}

/** Those of the shard that are not there yet. */
std::vector<campaign::CampaignRun> runsToMake(const campaign::Campaign& campaign,
                                              const campaign::Identity& identity,
                                              const campaign::PartialOutcomes& outcomes) {
  std::vector<campaign::CampaignRun> runs;
  for (const campaign::CampaignRun& run : campaign::shardOf(campaign.runs, identity.shard, identity.shards)) {
    if (!outcomes.has(run.number)) runs.push_back(run);
  }
  return runs;
}

void makeRuns(const TrainerConfig& config,
              const campaign::Campaign& campaign,
              const std::vector<campaign::CampaignRun>& runs,
              std::size_t jobs,
              campaign::PartialOutcomes* outcomes) {
  const Clock::time_point start = Clock::now();
  apps::ProgressBar bar(campaign.name);
  std::size_t done = 0;
  const auto report = [&](const campaign::CampaignRun& run, const campaign::RunResult& result) {
    outcomes->add(run.number, campaign::row(campaign, run, result));
    ++done;
    bar.update(static_cast<double>(done) / static_cast<double>(runs.size()), timeLeft(start, done, runs.size()));
  };
  campaign::makeRuns(config, campaign, runs, jobs, report);
  char text[64];
  std::snprintf(text, sizeof(text), "%zu runs in %.1f s", runs.size(),
                std::chrono::duration<double>(Clock::now() - start).count());
  bar.done(text);
}

int run(const Options& options) {
  const TrainerConfig loaded = apps::CommonOptions{options.config, {}, {}, {}, {}}.load();
  const campaign::Campaign campaign =
      campaign::loadCampaign(campaignFile(options.campaign), options.seed, loaded.impairment_names);
  const campaign::Explanations explanations =
      campaign::loadExplanations(campaign::explanationsOf(campaign.file), campaign);
  const TrainerConfig config = campaign::configurationFor(campaign, loaded);
  campaign::Identity identity = campaign::identify(campaign, ingredients(config, campaign));
  parseShard(options.shard, &identity.shard, &identity.shards);
  const campaign::OutputPaths paths{options.output};
  campaign::PartialOutcomes outcomes(paths, identity, campaign, options.resume, options.resume ? kLockWait : 0);
  const std::vector<campaign::CampaignRun> runs = runsToMake(campaign, identity, outcomes);
  physics::initialiseOde();
  const Clock::time_point start = Clock::now();
  makeRuns(config, campaign, runs, options.jobs, &outcomes);
  outcomes.finish();
  campaign::keepExplanations(campaign, paths);
  writeTiming(paths, runs.size(), options.jobs, std::chrono::duration<double>(Clock::now() - start).count());
  std::fprintf(stderr, "%s\n", paths.outcomes().c_str());
  const campaign::Judgement judgement = campaign::judge(campaign, explanations, outcomes.rows());
  std::fputs(campaign::inWords(judgement).c_str(), stderr);
  return judgement.isGood() ? 0 : 1;
}

}  // namespace
}  // namespace raven2_trainer

int main(int argc, char** argv) {
  using namespace raven2_trainer;
  Options options;
  CLI::App app{"Runs a campaign of fault injections and writes outcomes.csv, one row per run."};
  app.footer(
      "Exit status: 0 done; 1 failed, a fault never acted, a run has no outcome, an outcome is neither published nor\n"
      "explained, or all runs of a scenario are unexpectedly masked; above 100 wrong arguments.");
  app.add_option("campaign", options.campaign, "Campaign: a name of config/campaigns, or FILE.yaml")->required();
  app.add_option("--output", options.output, "Directory for the results")->type_name("DIR")->required();
  app.add_option("--seed", options.seed, "Seed of all random numbers")
      ->capture_default_str()
      ->check(CLI::Range(std::uint64_t{0}, std::uint64_t{1} << 53));
  apps::within(app.add_option("--jobs", options.jobs, "Runs at the same time"), 1, 1024);
  app.add_option("--shard", options.shard, "I/N: run part I of N only; merge_campaign joins the parts")
      ->type_name("I/N")
      ->capture_default_str();
  app.add_flag("--resume", options.resume, "Continue an interrupted run of the same campaign");
  app.add_option("--config", options.config, "Root configuration file (default: the packaged config/trainer.yaml)")
      ->type_name("FILE");
  return apps::runProgram(&app, argc, argv, [&] { return run(options); });
}
