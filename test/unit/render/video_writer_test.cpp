#include "raven2_trainer/render/video_writer.h"

#include <gtest/gtest.h>

#include <unistd.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::render {
namespace {

RenderConfig smallVideo() {
  RenderConfig config;
  config.video_width = 64;
  config.video_height = 48;
  config.video_fps = 30;
  config.encoder_crf = 23;
  config.encoder_preset = "ultrafast";
  return config;
}

std::vector<std::uint8_t> frame(int k) {
  return std::vector<std::uint8_t>(64 * 48 * 3, static_cast<std::uint8_t>(20 * k));
}

std::string output(const std::string& command) {
  std::FILE* pipe = popen(command.c_str(), "r");
  std::array<char, 256> line{};
  std::string text;
  while (std::fgets(line.data(), line.size(), pipe) != nullptr)
    text += line.data();
  pclose(pipe);
  return text;
}

class VideoWriterTest : public ::testing::Test {
 protected:
  VideoWriterTest()
      : folder_(std::filesystem::temp_directory_path() / ("video_writer_test_" + std::to_string(::getpid()))) {
    std::filesystem::create_directories(folder_);
  }
  ~VideoWriterTest() override { std::filesystem::remove_all(folder_); }
  std::string path(const std::string& file) const { return (folder_ / file).string(); }

 private:
  std::filesystem::path folder_;
};

TEST_F(VideoWriterTest, TenFramesGiveAVideoOfTenFrames) {
  VideoWriter writer(path("video.mp4"), smallVideo());
  for (int k = 0; k < 10; ++k)
    writer.write(frame(k));
  writer.finish();
  EXPECT_EQ(writer.frames(), 10U);
  const std::string probe =
      "ffprobe -v error -count_frames -select_streams v:0 -show_entries "
      "stream=codec_name,width,height,pix_fmt,r_frame_rate,nb_read_frames -of csv=p=0 ";
  EXPECT_EQ(output(probe + path("video.mp4")), "h264,64,48,yuv420p,30/1,10\n");
}

TEST_F(VideoWriterTest, APngPatternGivesOnePictureAFrame) {
  VideoWriter writer(path("frame_%03d.png"), smallVideo());
  for (int k = 0; k < 3; ++k)
    writer.write(frame(k));
  writer.finish();
  EXPECT_TRUE(std::filesystem::exists(path("frame_000.png")));
  EXPECT_TRUE(std::filesystem::exists(path("frame_002.png")));
  EXPECT_FALSE(std::filesystem::exists(path("frame_003.png")));
}

TEST_F(VideoWriterTest, APictureTakesItsNameOnceItIsWhole) {
  // A direct write would change the file behind the link. A rename replaces the link itself.
  std::ofstream(path("other.png")) << "another picture";
  std::filesystem::create_symlink(path("other.png"), path("frame_000.png"));
  VideoWriter writer(path("frame_%03d.png"), smallVideo());
  writer.write(frame(0));
  writer.finish();
  EXPECT_TRUE(std::filesystem::is_regular_file(std::filesystem::symlink_status(path("frame_000.png"))));
  EXPECT_EQ(std::filesystem::file_size(path("other.png")), 15U);
  EXPECT_FALSE(std::filesystem::exists(path("frame_000.png.tmp")));
}

TEST_F(VideoWriterTest, AFrameOfAnotherSizeIsRefused) {
  VideoWriter writer(path("video.mp4"), smallVideo());
  EXPECT_THROW(writer.write(std::vector<std::uint8_t>(10)), RenderException);
}

TEST_F(VideoWriterTest, OddSizesAreRefused) {
  RenderConfig config = smallVideo();
  config.video_width = 63;
  EXPECT_THROW(VideoWriter(path("video.mp4"), config), RenderException);
}

TEST_F(VideoWriterTest, AnEncoderThatGoesAwayIsAnExceptionWithItsMessageAndNoSignal) {
  VideoWriter writer(path("missing_folder/video.mp4"), smallVideo());
  try {
    for (int k = 0; k < 100'000; ++k)
      writer.write(frame(k % 10));
    writer.finish();
    FAIL() << "no exception";
  } catch (const RenderException& e) {
    EXPECT_NE(std::string(e.what()).find("No such file or directory"), std::string::npos) << e.what();
  }
  EXPECT_THROW(writer.write(frame(0)), RenderException) << "a writer that failed stays unusable";
}

TEST_F(VideoWriterTest, AnUnknownPresetFailsWithFfmpegsMessage) {
  RenderConfig config = smallVideo();
  config.encoder_preset = "warp_speed";
  VideoWriter writer(path("video.mp4"), config);
  EXPECT_THROW(
      {
        for (int k = 0; k < 100'000; ++k)
          writer.write(frame(0));
        writer.finish();
      },
      RenderException);
}

}  // namespace
}  // namespace raven2_trainer::render
