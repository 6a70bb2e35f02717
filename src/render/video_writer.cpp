#include "raven2_trainer/render/video_writer.h"

#include "raven2_trainer/core/exceptions.h"
#include "render/ffmpeg_process.h"

namespace raven2_trainer::render {

namespace {

bool endsWith(const std::string& text, const std::string& end) {
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

std::vector<std::string> inputArguments(const RenderConfig& config) {
  const std::string size = std::to_string(config.video_width) + "x" + std::to_string(config.video_height);
  return {"-y", "-f", "rawvideo", "-pix_fmt", "rgb24", "-s", size, "-r", std::to_string(config.video_fps), "-i", "-"};
}

std::vector<std::string> outputArguments(const std::string& path, const RenderConfig& config, std::uint64_t first) {
  // "file:" keeps a path from being read as an option or a protocol.
  if (endsWith(path, ".png")) {
    return {"-threads",        "1", "-c:v",        "png", "-start_number", std::to_string(first), "-f", "image2",
            "-atomic_writing", "1", "file:" + path};
  }
  return {"-threads",    "1",
          "-c:v",        "libx264",
          "-preset",     config.encoder_preset,
          "-crf",        std::to_string(config.encoder_crf),
          "-pix_fmt",    "yuv420p",
          "-flags",      "+cgop",
          "-fflags",     "+bitexact",
          "-f",          "mp4",
          "file:" + path};
}

}  // namespace

VideoWriter::VideoWriter(const std::string& path, const RenderConfig& config, std::uint64_t first)
    : frame_size_(static_cast<std::size_t>(config.video_width) * static_cast<std::size_t>(config.video_height) * 3),
      path_(path) {
  if (config.video_width < 2 || config.video_height < 2 || config.video_width % 2 != 0 ||
      config.video_height % 2 != 0) {
    throw RenderException("video size " + std::to_string(config.video_width) + "x" +
                          std::to_string(config.video_height) + ", must be even and positive");
  }
  std::vector<std::string> arguments = inputArguments(config);
  for (std::string& argument : outputArguments(path, config, first))
    arguments.push_back(std::move(argument));
  ffmpeg_ = std::make_unique<FfmpegProcess>(std::move(arguments), path);
}

VideoWriter::~VideoWriter() = default;

void VideoWriter::write(const std::vector<std::uint8_t>& rgb) {
  if (rgb.size() != frame_size_) {
    throw RenderException(path_ + ": frame of " + std::to_string(rgb.size()) + " bytes, must be " +
                          std::to_string(frame_size_));
  }
  ffmpeg_->send(rgb.data(), rgb.size());
  ++frames_;
}

void VideoWriter::finish() {
  ffmpeg_->finish();
}

}  // namespace raven2_trainer::render
