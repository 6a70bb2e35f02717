#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "raven2_trainer/render/render_config.h"

namespace raven2_trainer::render {

class FfmpegProcess;

/**
 * H.264 in an MP4 through a pipe to an `ffmpeg` process (linking x264 would make the binary GPL). One encoder thread:
 * the same frames give the same bytes. Every file begins with its own picture and refers to no other, so that
 * files of the same settings can be put one behind the other without coding again. A path that ends in `.png` makes
 * numbered pictures instead and must hold a `%d` pattern for the number; each takes its name in one rename once it is
 * whole, `.tmp` behind it until then. An ffmpeg that goes away raises no SIGPIPE.
 */
class VideoWriter {
 public:
  /** Size, rate, quality and preset are those of the video in `config`; width and height must be even.
   *  @param[in] first number of the first picture, if they are pictures.
   *  @throw RenderException if the size is odd or ffmpeg cannot be started. */
  VideoWriter(const std::string& path, const RenderConfig& config, std::uint64_t first = 0);
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
  std::size_t frame_size_{0};
  std::uint64_t frames_{0};
  std::string path_;
  std::unique_ptr<FfmpegProcess> ffmpeg_;
};

}  // namespace raven2_trainer::render
