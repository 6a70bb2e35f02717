#include "render/ffmpeg_process.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>

#include "raven2_trainer/core/exceptions.h"

extern char** environ;

namespace raven2_trainer::render {

FfmpegProcess::FfmpegProcess(std::vector<std::string> arguments, std::string label)
    : label_(std::move(label)), messages_(std::tmpfile(), &std::fclose) {
  if (messages_ == nullptr) throw RenderException(std::string("tmpfile: ") + std::strerror(errno));
  // A socket in place of a pipe: send() can be called without SIGPIPE.
  std::array<int, 2> ends{};
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0)
    throw RenderException(std::string("socketpair: ") + std::strerror(errno));
  for (const char* first : {"error", "-loglevel", "-hide_banner", "ffmpeg"})
    arguments.insert(arguments.begin(), first);
  std::vector<char*> argv;
  for (std::string& argument : arguments)
    argv.push_back(argument.data());
  argv.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, ends[0], STDIN_FILENO);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_adddup2(&actions, fileno(messages_.get()), STDERR_FILENO);
  pid_t process = -1;
  const int error = posix_spawnp(&process, "ffmpeg", &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  close(ends[0]);
  if (error != 0) {
    close(ends[1]);
    throw RenderException(std::string("ffmpeg cannot be started: ") + std::strerror(error));
  }
  input_ = ends[1];
  process_ = process;
}

FfmpegProcess::~FfmpegProcess() {
  end();
}

void FfmpegProcess::send(const void* bytes, std::size_t count) {
  if (input_ < 0) throw RenderException(label_ + ": written to after its end");
  const char* from = static_cast<const char*>(bytes);
  for (std::size_t done = 0; done < count;) {
    const ssize_t sent = ::send(input_, from + done, count - done, MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR) continue;
    if (sent < 0) {
      end();
      throw RenderException(label_ + ": ffmpeg went away: " + lastMessage());
    }
    done += static_cast<std::size_t>(sent);
  }
}

void FfmpegProcess::finish() {
  if (end() != 0) throw RenderException(label_ + ": ffmpeg failed: " + lastMessage());
}

/** @return 0 if ffmpeg ended well or had ended before. */
int FfmpegProcess::end() noexcept {
  if (input_ >= 0) close(input_);
  input_ = -1;
  if (process_ < 0) return 0;
  int status = 0;
  while (waitpid(process_, &status, 0) < 0 && errno == EINTR) {
  }
  process_ = -1;
  return status;
}

std::string FfmpegProcess::lastMessage() const {
  std::rewind(messages_.get());
  std::array<char, 512> line{};
  std::string last = "no message";
  while (std::fgets(line.data(), static_cast<int>(line.size()), messages_.get()) != nullptr) {
    std::string text = line.data();
    while (!text.empty() && (text.back() == '\n' || text.back() == '\r'))
      text.pop_back();
    if (!text.empty()) last = text;
  }
  return last;
}

namespace {

std::string askVersion() {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> pipe(popen("ffmpeg -version 2>/dev/null", "r"), &pclose);
  std::array<char, 512> line{};
  if (!pipe || std::fgets(line.data(), static_cast<int>(line.size()), pipe.get()) == nullptr)
    throw RenderException("ffmpeg cannot be started");
  return line.data();
}

}  // namespace

std::string ffmpegVersion() {
  static const std::string version = askVersion();  // it takes a tenth of a second to start
  return version;
}

}  // namespace raven2_trainer::render
