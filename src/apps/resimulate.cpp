// Simulates a session again from its log and compares every tick, bit for bit.

#include <CLI/CLI.hpp>
#include <string>

#include "apps/common/command_line.h"
#include "apps/common/resimulate_session.h"

int main(int argc, char** argv) {
  using namespace raven2_trainer;
  std::string directory, output;
  CLI::App app{
      "Simulates a recorded session again and compares each tick bit for bit. Exit status: 0 equal, else "
      "different or impossible."};
  app.add_option("session", directory, "Session directory, with session.rlog and configuration/")->required();
  app.add_option("--output", output, "Directory for the new session (default: writes no session)")->type_name("DIR");
  return apps::runProgram(&app, argc, argv, [&] { return apps::resimulateSession(directory, output); });
}
