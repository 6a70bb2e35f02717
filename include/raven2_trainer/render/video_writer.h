#pragma once

#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "raven2_trainer/core/config.h"

namespace raven2_trainer::render {

/**
 * H.264 through a pipe to an `ffmpeg` process (linking x264 would make the binary GPL). One encoder thread.
 * A path that ends in `.png` makes numbered pictures instead and must hold a `%d` pattern for the number, from 0.
 * An ffmpeg that goes away raises no SIGPIPE.
 */
class VideoWriter {
 public:
  /** Size, rate, quality and preset are those of the video in `config`; width and height must be even.
   *  @throw RenderException if the size is odd or ffmpeg cannot be started. */
  VideoWriter(const std::string& path, const RenderConfig& config);
  /** Without finish(): ends ffmpeg, which closes its file with what it got; errors are lost. */
  ~VideoWriter();
  VideoWriter(const VideoWriter&) = delete;
  VideoWriter& operator=(const VideoWriter&) = delete;

  /** One frame, RGB, top row first. @throw RenderException if its size is wrong or ffmpeg went away. */
  void write(const std::vector<std::uint8_t>& rgb);

  /** Waits for ffmpeg. @throw RenderException with its last message if it failed. */
  void finish();

  std::uint64_t frames() const noexcept { return frames_; }

 private:
  void start(std::vector<std::string> arguments);
  int endProcess() noexcept;
  std::string lastMessage() const;

  int pipe_{-1};
  int process_{-1};
  std::size_t frame_size_{0};
  std::uint64_t frames_{0};
  std::string path_;
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> messages_;  // ffmpeg's stderr
};

}  // namespace raven2_trainer::render
