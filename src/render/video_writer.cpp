#include "raven2_trainer/render/video_writer.h"

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

namespace {

bool endsWith(const std::string& text, const std::string& end) {
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

std::vector<std::string> inputArguments(const RenderConfig& config) {
  const std::string size = std::to_string(config.video_width) + "x" + std::to_string(config.video_height);
  return {"ffmpeg",
          "-hide_banner",
          "-loglevel",
          "error",
          "-y",
          "-f",
          "rawvideo",
          "-pix_fmt",
          "rgb24",
          "-s",
          size,
          "-r",
          std::to_string(config.video_fps),
          "-i",
          "-"};
}

std::vector<std::string> outputArguments(const std::string& path, const RenderConfig& config) {
  // "file:" keeps a path from being read as an option or a protocol.
  if (endsWith(path, ".png"))
    return {"-threads", "1", "-c:v", "png", "-start_number", "0", "-f", "image2", "file:" + path};
  return {"-threads",    "1",
          "-c:v",        "libx264",
          "-preset",     config.encoder_preset,
          "-crf",        std::to_string(config.encoder_crf),
          "-pix_fmt",    "yuv420p",
          "-movflags",   "+faststart",
          "file:" + path};
}

}  // namespace

VideoWriter::VideoWriter(const std::string& path, const RenderConfig& config)
    : frame_size_(static_cast<std::size_t>(config.video_width) * static_cast<std::size_t>(config.video_height) * 3),
      path_(path),
      messages_(std::tmpfile(), &std::fclose) {
  if (config.video_width < 2 || config.video_height < 2 || config.video_width % 2 != 0 ||
      config.video_height % 2 != 0) {
    throw RenderException("video size " + std::to_string(config.video_width) + "x" +
                          std::to_string(config.video_height) + ", must be even and positive");
  }
  if (messages_ == nullptr) throw RenderException(std::string("tmpfile: ") + std::strerror(errno));
  std::vector<std::string> arguments = inputArguments(config);
  for (std::string& argument : outputArguments(path, config))
    arguments.push_back(std::move(argument));
  start(std::move(arguments));
}

VideoWriter::~VideoWriter() {
  endProcess();
}

void VideoWriter::start(std::vector<std::string> arguments) {
  // A socket in place of a pipe: send() can be told not to raise SIGPIPE.
  std::array<int, 2> ends{};
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0) {
    throw RenderException(std::string("socketpair: ") + std::strerror(errno));
  }
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
  pipe_ = ends[1];
  process_ = process;
}

void VideoWriter::write(const std::vector<std::uint8_t>& rgb) {
  if (rgb.size() != frame_size_) {
    throw RenderException(path_ + ": frame of " + std::to_string(rgb.size()) + " bytes, must be " +
                          std::to_string(frame_size_));
  }
  if (pipe_ < 0) throw RenderException(path_ + ": written to after its end");
  for (std::size_t done = 0; done < rgb.size();) {
    const ssize_t sent = send(pipe_, rgb.data() + done, rgb.size() - done, MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR) continue;
    if (sent < 0) {
      endProcess();
      throw RenderException(path_ + ": ffmpeg went away: " + lastMessage());
    }
    done += static_cast<std::size_t>(sent);
  }
  ++frames_;
}

void VideoWriter::finish() {
  const int status = endProcess();
  if (status == 0) return;
  throw RenderException(path_ + ": ffmpeg failed: " + lastMessage());
}

/** Closes the pipe and waits. @return 0 if ffmpeg ended well or had ended before. */
int VideoWriter::endProcess() noexcept {
  if (pipe_ >= 0) close(pipe_);
  pipe_ = -1;
  if (process_ < 0) return 0;
  int status = 0;
  while (waitpid(process_, &status, 0) < 0 && errno == EINTR) {
  }
  process_ = -1;
  return status;
}

std::string VideoWriter::lastMessage() const {
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

}  // namespace raven2_trainer::render
