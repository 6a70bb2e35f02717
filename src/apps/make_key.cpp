// A new key for signed ITP. Copy it to the other computer over a channel you trust.

#include <CLI/CLI.hpp>
#include <string>

#include "apps/common/command_line.h"
#include "raven2_trainer/net/key_file.h"

int main(int argc, char** argv) {
  using namespace raven2_trainer;
  std::string path;
  CLI::App app{"Makes a key file for signed ITP packets (network.yaml: key_file). Never overwrites a file."};
  app.add_option("FILE", path, "File to create, with mode 0600")->required();
  return apps::runProgram(&app, argc, argv, [&] {
    net::writeKeyFile(path);
    std::fprintf(stderr, "%s: 64 hexadecimal digits, mode 0600\n", path.c_str());
    return 0;
  });
}
