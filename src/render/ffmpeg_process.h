#pragma once

#include <cstddef>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

namespace raven2_trainer::render {

/** One run of the program `ffmpeg` (linking x264 would make the binary GPL), fed through its standard input. An ffmpeg
 *  that goes away raises no SIGPIPE. */
class FfmpegProcess {
 public:
  /** @param[in] arguments behind the program's name. @param[in] label of messages, as a rule the file that is written.
   *  @throw RenderException if it cannot be started. */
  FfmpegProcess(std::vector<std::string> arguments, std::string label);
  /** Without finish(): closes its input and waits; errors are lost. */
  ~FfmpegProcess();
  FfmpegProcess(const FfmpegProcess&) = delete;
  FfmpegProcess& operator=(const FfmpegProcess&) = delete;

  /** Into its standard input. @throw RenderException if it went away. */
  void send(const void* bytes, std::size_t count);
  /** Closes its input and waits. @throw RenderException with its last message if it failed. */
  void finish();

 private:
  int end() noexcept;
  std::string lastMessage() const;

  int input_{-1};
  int process_{-1};
  std::string label_;
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> messages_;  // its stderr
};

/** First line of `ffmpeg -version`: what coded a file. @throw RenderException if there is no ffmpeg. */
std::string ffmpegVersion();

}  // namespace raven2_trainer::render
