#include "apps/common/run_script.h"

#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::apps {
namespace {

namespace fs = std::filesystem;

constexpr const char* kPython = "/usr/bin/python3";  // Debian's: the one that has matplotlib

}  // namespace

std::string scriptPath(const std::string& name) {
  std::error_code error;
  const fs::path next_to_program = fs::read_symlink("/proc/self/exe", error).parent_path() / name;
  const fs::path in_source = fs::path(RAVEN2_TRAINER_SOURCE_DIR) / "scripts" / name;
  for (const fs::path& path : {next_to_program, in_source}) {
    if (fs::is_regular_file(path, error)) return path.string();
  }
  throw ConfigException(name + " is neither " + next_to_program.string() + " nor " + in_source.string());
}

int runScript(const std::string& name, const std::vector<std::string>& arguments) {
  std::vector<std::string> words{kPython, scriptPath(name)};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words)
    argv.push_back(word.data());
  argv.push_back(nullptr);
  pid_t process = 0;
  const int error = posix_spawn(&process, kPython, nullptr, nullptr, argv.data(), environ);
  if (error != 0) throw ConfigException(std::string(kPython) + " cannot be started: " + std::strerror(error));
  int status = 0;
  while (waitpid(process, &status, 0) < 0 && errno == EINTR) {
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 1;
}

}  // namespace raven2_trainer::apps
