// score_session DIR: what a trainee did in a session, in figures, and whether it was good enough.

#include <CLI/CLI.hpp>
#include <cstdio>

#include "apps/common/command_line.h"
#include "raven2_trainer/recording/finish_session.h"

int main(int argc, char** argv) {
  using namespace raven2_trainer;
  CLI::App app{
      "Scores a recorded session: metrics of every attempt, responses to hazards, and, where the exercise has a "
      "band, what passed.",
      "score_session"};
  app.footer(
      "Writes DIR/score.json (the same bytes each time) and, for a trainee, an entry in index.json beside DIR.\n"
      "simulator and simulate do so themselves at the end of a session with an exercise.\n"
      "Metrics, bands and both files are described in doc/scores.md. Exit status: 0 scored, 1 otherwise.");
  std::string directory;
  recording::ScoringOptions options;
  app.add_option("DIR", directory, "Session directory: the one that holds session.rlog")->required();
  app.add_option("--output", options.output, "File to write (default: DIR/score.json)");
  app.add_option("--band", options.band, "Band to judge by (default: the one the session was run with)");
  app.add_option("--trainee", options.trainee, "Id for the index (default: the session's): 1 to 32 of a-z, 0-9, _, -");
  app.add_option("--index", options.index, "Index of sessions (default: index.json beside DIR)");
  app.add_flag("--no-index", options.no_index, "Leave the index as it is");
  return apps::runProgram(&app, argc, argv, [&] {
    const recording::ScoredSession scored = recording::scoreRecorded(directory, options);
    std::printf("%s%s\n", recording::describe(scored).c_str(), scored.path.c_str());
    return 0;
  });
}
