#include "raven2_trainer/render/video_file.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

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
  EXPECT_FALSE(isWholeVideo(path("zeros.mp4"))) << "a box of length 0 would never end";
  std::ofstream(path("free.mp4")) << std::string(
      "\0\0\0\x08"
      "free",
      8);
  EXPECT_FALSE(isWholeVideo(path("free.mp4"))) << "the file has boxes, but no index";
}

TEST_F(VideoFileTest, SaysOfWhatSettingsItIs) {
  encode("plain.mp4");
  EXPECT_EQ(videoSettings(path("plain.mp4")), "") << "the video does not name its settings";
  const auto comment = [&](const std::string& arguments) {
    const std::string command =
        "ffmpeg -nostdin -v error -y -i " + path("plain.mp4") + " -c copy " + arguments + " " + path("video.mp4");
    EXPECT_EQ(std::system(command.c_str()), 0) << command;
    return videoSettings(path("video.mp4"));
  };
  const std::string ours = "-metadata 'comment=" + settingsComment("0123456789abcdef") + "'";
  EXPECT_EQ(comment(ours), "0123456789abcdef");
  EXPECT_EQ(comment(ours + " -metadata title=A -metadata description=B -metadata genre=C -movflags +faststart"),
            "0123456789abcdef");
  EXPECT_EQ(comment("-metadata 'comment=of a holiday'"), "");
  EXPECT_EQ(comment("-metadata 'title=" + settingsComment("0123456789abcdef") + "'"), "")
      << "the settings are in the title, not in the comment";
  comment(ours);
  fs::resize_file(path("video.mp4"), fs::file_size(path("video.mp4")) - 1);
  EXPECT_EQ(videoSettings(path("video.mp4")), "") << "the video is incomplete";
  EXPECT_EQ(videoSettings(path("missing.mp4")), "");
}

TEST_F(VideoFileTest, SettingsAreLookedForInNothingThatIsBroken) {
  encode("plain.mp4");
  const std::string command = "ffmpeg -nostdin -v error -y -i " + path("plain.mp4") +
                              " -c copy -metadata 'comment=" + settingsComment("0123456789abcdef") + "' " +
                              path("video.mp4");
  ASSERT_EQ(std::system(command.c_str()), 0);
  std::ifstream file(path("video.mp4"), std::ios::binary);
  const std::string whole{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  int read = 0, unread = 0;
  for (std::size_t at = whole.find("moov"); at < whole.size(); ++at) {
    std::string broken = whole;
    broken[at] = static_cast<char>(broken[at] ^ 0x81);
    std::ofstream(path("broken.mp4"), std::ios::binary) << broken;
    const std::string settings = videoSettings(path("broken.mp4"));
    (settings == "0123456789abcdef" ? read : unread) += 1;
    EXPECT_LE(settings.size(), 1024U) << at;
  }
  EXPECT_GT(read, 100) << "bytes that the reader does not need may be broken";
  EXPECT_GT(unread, 16);
}

TEST_F(VideoFileTest, AWholeVideoIsMarkedToBeDrawnAgain) {
  markUnfinished(path("missing.mp4"));
  EXPECT_FALSE(fs::exists(path("missing.parts")));
  encode("video.mp4");
  markUnfinished(path("video.mp4"));
  EXPECT_TRUE(isUnfinished(path("video.mp4")));
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
