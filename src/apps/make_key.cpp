// A new key for signed ITP. Copy it to the other computer over a channel you trust.

#include <CLI/CLI.hpp>
#include <string>

#include "apps/common/command_line.h"
#include "raven2_trainer/net/key_file.h"

int main(int argc, char** argv) {
  using namespace raven2_trainer;
  std::string path;
  CLI::App app{"Makes a random 256-bit key for signed ITP (network.yaml: key_file), mode 0600. Never overwrites."};
  app.add_option("FILE", path, "File to make")->required();
  return apps::runProgram(&app, argc, argv, [&] {
    net::writeKeyFile(path);
    std::fprintf(stderr, "%s: 64 hexadecimal digits, mode 0600\n", path.c_str());
    return 0;
  });
}
