// Puts the shards of a campaign together: the same outcomes.csv as from one machine, or a refusal.

#include <CLI/CLI.hpp>
#include <cstdio>
#include <string>
#include <vector>

#include "apps/common/command_line.h"
#include "raven2_trainer/campaign/results.h"

int main(int argc, char** argv) {
  using namespace raven2_trainer;
  std::vector<std::string> shards;
  std::string output;
  CLI::App app{"Merges the parts of a campaign that several computers ran. Refuses missing, duplicate and foreign parts."};
  app.add_option("shards", shards, "Output directories of run_campaign --shard, all parts of one campaign")->required();
  app.add_option("--output", output, "Directory for the whole campaign")->type_name("DIR")->required();
  return apps::runProgram(&app, argc, argv, [&] {
    campaign::mergeShards(shards, output);
    std::fprintf(stderr, "%zu shards merged: %s/outcomes.csv\n", shards.size(), output.c_str());
    return 0;
  });
}
