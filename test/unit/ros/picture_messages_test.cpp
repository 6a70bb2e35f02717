#include <gtest/gtest.h>
#include <turbojpeg.h>

#include <array>
#include <cstdlib>
#include <memory>
#include <vector>

#include "ros/bridge/messages.h"
#include "ros/pictures/compressed_picture.h"
#include "ros/pictures/jpeg_encoder.h"
#include "ros/pictures/picture_stamp.h"

namespace raven2_trainer::ros_bridge {
namespace {

using Bytes = std::vector<std::uint8_t>;

/** Four fields of one colour each. */
Bytes fields(int width, int height) {
  constexpr std::uint8_t kColours[4][3] = {{200, 30, 40}, {20, 180, 60}, {30, 50, 220}, {240, 240, 235}};
  Bytes rgb;
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      const auto& colour = kColours[(v < height / 2 ? 0 : 2) + (u < width / 2 ? 0 : 1)];
      rgb.insert(rgb.end(), colour, colour + 3);
    }
  }
  return rgb;
}

/** Decodes a JPEG as a client of image_transport does. */
Bytes decoded(const Bytes& jpeg, int width, int height) {
  const std::unique_ptr<void, int (*)(tjhandle)> handle(tjInitDecompress(), &tjDestroy);
  int w = 0, h = 0, subsampling = 0, space = 0;
  EXPECT_EQ(tjDecompressHeader3(handle.get(), jpeg.data(), jpeg.size(), &w, &h, &subsampling, &space), 0);
  EXPECT_EQ(w, width);
  EXPECT_EQ(h, height);
  Bytes rgb(static_cast<std::size_t>(w) * static_cast<std::size_t>(h) * 3);
  EXPECT_EQ(tjDecompress2(handle.get(), jpeg.data(), jpeg.size(), rgb.data(), w, 0, h, TJPF_RGB, 0), 0);
  return rgb;
}

TEST(JpegEncoder, ColoursAndPlacesAreThoseOfThePicture) {
  JpegEncoder encoder(80);
  for (const auto& [width, height] : {std::pair<int, int>{640, 360}, {320, 180}, {33, 17}}) {
    const Bytes rgb = fields(width, height);
    Bytes jpeg;
    ASSERT_TRUE(encoder.encode(rgb, width, height, &jpeg));
    const Bytes back = decoded(jpeg, width, height);
    ASSERT_EQ(back.size(), rgb.size());
    for (const double u : {0.2, 0.8}) {
      for (const double v : {0.2, 0.8}) {
        const std::size_t at = 3 * (static_cast<std::size_t>(v * height) * static_cast<std::size_t>(width) +
                                    static_cast<std::size_t>(u * width));
        for (std::size_t c = 0; c < 3; ++c)
          EXPECT_NEAR(back[at + c], rgb[at + c], 6) << width << " " << u << " " << v << " " << c;
      }
    }
  }
}

TEST(JpegEncoder, QualityCostsBytes) {
  Bytes noise(160 * 120 * 3);
  std::srand(1);
  for (std::uint8_t& byte : noise)
    byte = static_cast<std::uint8_t>(std::rand() >> 4);
  Bytes coarse, fine;
  ASSERT_TRUE(JpegEncoder(20).encode(noise, 160, 120, &coarse));
  ASSERT_TRUE(JpegEncoder(95).encode(noise, 160, 120, &fine));
  EXPECT_LT(2 * coarse.size(), fine.size());
}

TEST(JpegEncoder, APictureOfAnotherSizeIsRefused) {
  JpegEncoder encoder(80);
  Bytes jpeg{1, 2, 3};
  EXPECT_FALSE(encoder.encode(fields(20, 10), 20, 11, &jpeg));
  EXPECT_TRUE(jpeg.empty());
  EXPECT_FALSE(encoder.encode({}, 0, 0, &jpeg));
  EXPECT_FALSE(encoder.encode({}, -4, 10, &jpeg));
}

TEST(CompressedImage, SaysItsFormatAsCompressedImageTransportDoes) {
  const sensor_msgs::CompressedImage message = compressedImage("endoscope_optical_frame", ros::Time(3, 4));
  EXPECT_EQ(message.format, "rgb8; jpeg compressed bgr8");
  EXPECT_EQ(message.header.stamp, ros::Time(3, 4));
  EXPECT_EQ(message.header.frame_id, "endoscope_optical_frame");
}

/** The real camera's pictures pass through the view like this one. */
TEST(CompressedImage, OfAnothersPictureHasItsColoursAndItsHeader) {
  sensor_msgs::Image picture;
  picture.header.stamp = ros::Time(7, 8);
  picture.header.frame_id = "real";
  picture.width = 64;
  picture.height = 48;
  picture.encoding = "bgr8";
  picture.step = 3 * 64 + 4;  // rows padded
  for (int i = 0; i < 48; ++i) {
    for (int u = 0; u < 64; ++u)
      picture.data.insert(picture.data.end(), {40, 30, 200});
    picture.data.insert(picture.data.end(), 4, 0);
  }
  JpegEncoder encoder(80);
  sensor_msgs::CompressedImage message;
  ASSERT_TRUE(compress(picture, &encoder, &message));
  EXPECT_EQ(message.header.stamp, ros::Time(7, 8));
  EXPECT_EQ(message.header.frame_id, "real");
  EXPECT_EQ(message.format, "rgb8; jpeg compressed bgr8");
  const Bytes back = decoded(message.data, 64, 48);
  ASSERT_EQ(back.size(), 64U * 48U * 3U);
  const std::array<int, 3> red{200, 30, 40};
  for (std::size_t i = 0; i < back.size(); ++i)
    ASSERT_NEAR(back[i], red[i % 3], 6) << i;
  picture.encoding = "yuv422";
  EXPECT_FALSE(compress(picture, &encoder, &message)) << "this encoding passes through the view only raw";
}

TEST(PictureStamp, PicturesOfOneStateHaveOne) {
  PictureStamp stamp;
  const ros::Time now(1000, 500);
  const ros::Time left = stamp.of(40'000'000, 45'000'000, now);
  EXPECT_EQ(left, ros::Time(999, 995'000'500));
  EXPECT_EQ(stamp.of(40'000'000, 45'020'000, now + ros::Duration(0, 20'007)), left)
      << "the difference is that of reading two clocks";
  EXPECT_EQ(stamp.of(73'000'000, 75'000'000, now), ros::Time(999, 998'000'500)) << "the stamp of the next state";
  EXPECT_EQ(stamp.of(0, 75'000'000, now), now);
  EXPECT_EQ(stamp.of(0, 76'000'000, now + ros::Duration(0, 1'000'000)), ros::Time(1000, 1'000'500))
      << "an unknown time is now";
}

/** Each picture of an unknown time is stamped with the present time. */
TEST(PictureStamp, OfNoTimeIsNowEachTime) {
  PictureStamp stamp;
  for (const std::int64_t then : {std::int64_t{0}, std::int64_t{-1}}) {
    for (const std::uint32_t second : {1000U, 1001U, 1002U})
      EXPECT_EQ(stamp.of(then, 75'000'000, ros::Time(second, 0)), ros::Time(second, 0));
  }
}

TEST(PictureStatus, WarnsWhileThePictureIsLessThanConfigured) {
  using diagnostic_msgs::DiagnosticStatus;
  LivePicture picture;
  EXPECT_EQ(pictureStatus(picture).message, "none");
  EXPECT_EQ(pictureStatus(picture).level, DiagnosticStatus::OK) << "the daemon runs with --no-render";
  picture.fps = 30;
  picture.width = 640;
  picture.height = 360;
  EXPECT_EQ(pictureStatus(picture).message, "30 Hz, 640 x 360");
  EXPECT_EQ(pictureStatus(picture).level, DiagnosticStatus::OK);
  picture.fps = 20;
  picture.level = 1;
  EXPECT_EQ(pictureStatus(picture).level, DiagnosticStatus::WARN);
  EXPECT_NE(pictureStatus(picture).message.find("20 Hz"), std::string::npos);
}

TEST(PictureStatus, IsAnErrorOnceItHasFailed) {
  using diagnostic_msgs::DiagnosticStatus;
  LivePicture picture;
  picture.failed = 1;
  EXPECT_EQ(pictureStatus(picture).level, DiagnosticStatus::ERROR) << "before the first frame";
  EXPECT_NE(pictureStatus(picture).message.find("failed"), std::string::npos);
  picture.fps = 20;
  picture.level = 1;
  EXPECT_EQ(pictureStatus(picture).level, DiagnosticStatus::ERROR) << "after the last good frame";
  EXPECT_EQ(pictureStatus(picture).message.find("20 Hz"), std::string::npos);
}

}  // namespace
}  // namespace raven2_trainer::ros_bridge
