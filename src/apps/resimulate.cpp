// Simulates a session again from its log and compares every tick, bit for bit.

#include <CLI/CLI.hpp>
#include <string>

#include "apps/common/command_line.h"
#include "apps/common/resimulate_session.h"

int main(int argc, char** argv) {
  using namespace raven2_trainer;
  std::string directory, output;
  CLI::App app{
      "Simulates a session again from its log and compares every tick, bit for bit. Exit code 0: equal, "
      "1: different, or it cannot be simulated again."};
  app.add_option("session", directory, "Session directory (with session.rlog and configuration/)")->required();
  app.add_option("--output", output, "Directory for the re-simulated session (default: none is written)");
  return apps::runProgram(&app, argc, argv, [&] { return apps::resimulateSession(directory, output); });
}
