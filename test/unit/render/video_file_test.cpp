#include "raven2_trainer/render/video_file.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "raven2_trainer/render/video_writer.h"

namespace raven2_trainer::render {
namespace {

namespace fs = std::filesystem;

class VideoFileTest : public ::testing::Test {
 protected:
  VideoFileTest() : folder_(fs::temp_directory_path() / ("video_file_test_" + std::to_string(::getpid()))) {
    fs::create_directories(folder_);
  }
  ~VideoFileTest() override { fs::remove_all(folder_); }
  std::string path(const std::string& file) const { return (folder_ / file).string(); }

  void encode(const std::string& file) const {
    RenderConfig config;
    config.video_width = 64;
    config.video_height = 48;
    config.video_fps = 30;
    config.encoder_preset = "ultrafast";
    VideoWriter writer(path(file), config);
    for (int k = 0; k < 10; ++k)
      writer.write(std::vector<std::uint8_t>(64 * 48 * 3, static_cast<std::uint8_t>(20 * k)));
    writer.finish();
  }

 private:
  fs::path folder_;
};

TEST_F(VideoFileTest, AVideoIsWholeAtItsFullLengthOnly) {
  encode("video.mp4");
  EXPECT_TRUE(isWholeVideo(path("video.mp4")));
  const auto size = fs::file_size(path("video.mp4"));
  for (std::uintmax_t length = 0; length < size; length += 7) {
    fs::copy_file(path("video.mp4"), path("cut.mp4"), fs::copy_options::overwrite_existing);
    fs::resize_file(path("cut.mp4"), length);
    EXPECT_FALSE(isWholeVideo(path("cut.mp4"))) << length << " of " << size;
  }
}

TEST_F(VideoFileTest, OtherFilesAreNoVideo) {
  EXPECT_FALSE(isWholeVideo(path("missing.mp4")));
  EXPECT_FALSE(isWholeVideo(path(".")));
  std::ofstream(path("text.mp4")) << std::string(1000, 'x');
  EXPECT_FALSE(isWholeVideo(path("text.mp4")));
  std::ofstream(path("zeros.mp4")) << std::string(1000, '\0');
  EXPECT_FALSE(isWholeVideo(path("zeros.mp4"))) << "a box of no length would never end";
  std::ofstream(path("free.mp4")) << std::string(
      "\0\0\0\x08"
      "free",
      8);
  EXPECT_FALSE(isWholeVideo(path("free.mp4"))) << "boxes, and no index among them";
}

TEST_F(VideoFileTest, AVideoIsUnfinishedWhileItsPartsLieBesideIt) {
  EXPECT_EQ(partFolder("/a/session.3/video.mp4"), "/a/session.3/video.parts");
  EXPECT_FALSE(isUnfinished(path("video.mp4")));
  fs::create_directories(path("video.parts"));
  EXPECT_TRUE(isUnfinished(path("video.mp4")));
  std::ofstream(path("video.parts/notes.txt")) << "somebody's own";
  EXPECT_FALSE(isUnfinished(path("video.mp4")));
  std::ofstream(path("video.parts/lock")) << "";
  EXPECT_TRUE(isUnfinished(path("video.mp4")));
}

}  // namespace
}  // namespace raven2_trainer::render
