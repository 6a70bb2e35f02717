#include "ros/pictures/picture.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace raven2_trainer::ros_bridge {
namespace {

sensor_msgs::Image message(const std::string& encoding, std::uint32_t step, std::vector<std::uint8_t> data) {
  sensor_msgs::Image image;
  image.width = 2;
  image.height = 2;
  image.encoding = encoding;
  image.step = step;
  image.data = std::move(data);
  return image;
}

const std::vector<std::uint8_t> kRgb{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12};

TEST(Picture, EachEncodingGivesTheSameColours) {
  const std::vector<sensor_msgs::Image> images{
      message("rgb8", 6, kRgb), message("rgb8", 8, {1, 2, 3, 4, 5, 6, 0, 0, 7, 8, 9, 10, 11, 12, 0, 0}),  // rows padded
      message("bgr8", 6, {3, 2, 1, 6, 5, 4, 9, 8, 7, 12, 11, 10}),
      message("rgba8", 8, {1, 2, 3, 0, 4, 5, 6, 0, 7, 8, 9, 0, 10, 11, 12, 0}),
      message("bgra8", 8, {3, 2, 1, 9, 6, 5, 4, 9, 9, 8, 7, 9, 12, 11, 10, 9})};
  for (const sensor_msgs::Image& image : images) {
    Picture picture;
    ASSERT_TRUE(toPicture(image, &picture)) << image.encoding;
    EXPECT_EQ(picture.rgb, kRgb) << image.encoding;
    EXPECT_EQ(picture.width, 2);
    EXPECT_EQ(picture.height, 2);
  }
  Picture grey;
  ASSERT_TRUE(toPicture(message("mono8", 2, {1, 2, 3, 4}), &grey));
  EXPECT_EQ(grey.rgb, (std::vector<std::uint8_t>{1, 1, 1, 2, 2, 2, 3, 3, 3, 4, 4, 4}));
}

TEST(Picture, WhatIsNotWholeIsRefused) {
  Picture picture{1, 1, {7, 8, 9}};
  std::vector<sensor_msgs::Image> bad{message("rgb8", 6, {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11}), message("rgb8", 5, kRgb),
                                      message("yuv422", 6, kRgb), message("", 6, kRgb)};
  bad.push_back(message("rgb8", 6, kRgb));
  bad.back().height = 0;
  bad.push_back(message("rgb8", 0xFFFFFFFF, kRgb));
  bad.back().width = 0x55555556;  // the number of bytes overflows to a small one
  for (const sensor_msgs::Image& image : bad) {
    EXPECT_FALSE(toPicture(image, &picture)) << image.encoding << " " << image.width;
    EXPECT_EQ(picture.rgb.size(), 3U) << "the last picture stays";
  }
}

}  // namespace
}  // namespace raven2_trainer::ros_bridge
