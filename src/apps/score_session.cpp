// score_session DIR: what a trainee did in a session, in figures, and whether it was good enough.

#include <CLI/CLI.hpp>
#include <cstdio>

#include "apps/common/command_line.h"
#include "raven2_trainer/recording/finish_session.h"

int main(int argc, char** argv) {
  using namespace raven2_trainer;
  CLI::App app{
      "Scores a recorded session: metrics, responses to hazards, and whether each attempt passed.",
      "score_session"};
  app.footer(
      "Writes DIR/score.json (always the same bytes) and, for a trainee, an entry in index.json next to DIR, as "
      "simulator\n"
      "and simulate do at the end of a session with an exercise. Metrics, bands and both files: doc/scores.md.\n"
      "Exit status: 0 scored, else failed.");
  std::string directory;
  recording::ScoringOptions options;
  app.add_option("DIR", directory, "Session directory, with session.rlog")->required();
  app.add_option("--output", options.output, "File to write (default: DIR/score.json)")->type_name("FILE");
  app.add_option("--band", options.band, "File of the experts' band (default: the session's)")->type_name("FILE");
  app.add_option("--trainee", options.trainee, "ID for the index: 1 to 32 of a-z, 0-9, _, - (default: the session's)")
      ->type_name("ID");
  app.add_option("--index", options.index, "Index of sessions (default: index.json next to DIR)")->type_name("FILE");
  app.add_flag("--no-index", options.no_index, "Do not change the index");
  return apps::runProgram(&app, argc, argv, [&] {
    const recording::ScoredSession scored = recording::scoreRecorded(directory, options);
    std::printf("%s%s\n", recording::describe(scored).c_str(), scored.path.c_str());
    return 0;
  });
}
