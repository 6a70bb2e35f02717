#include "apps/window/window_pixels.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

namespace raven2_trainer::apps {
namespace {

using Pixels = std::vector<std::uint32_t>;

constexpr PixelLayout kLayout{16, 8, 0};
constexpr std::uint32_t kRed = 0xFF0000, kGreen = 0x00FF00, kBlue = 0x0000FF, kWhite = 0xFFFFFF;

std::vector<std::uint8_t> bytesOf(const Pixels& picture) {
  std::vector<std::uint8_t> rgb;
  for (const std::uint32_t p : picture)
    for (const int shift : {16, 8, 0})
      rgb.push_back(static_cast<std::uint8_t>(p >> shift));
  return rgb;
}

Pixels shown(const Pixels& picture, int picture_width, int picture_height, int width, int height) {
  Pixels pixels{1, 2, 3};
  drawFitted(bytesOf(picture), picture_width, picture_height, kLayout, width, height, &pixels);
  return pixels;
}

TEST(PixelLayout, ColoursAreTheHighestBitsOfTheirMasks) {
  EXPECT_EQ(shiftOf(0xFF0000), 16);
  EXPECT_EQ(shiftOf(0x00FF00), 8);
  EXPECT_EQ(shiftOf(0x0000FF), 0);
  EXPECT_EQ(shiftOf(0xFF000000), 24);
  // 30 bits a pixel: 10 a colour
  EXPECT_EQ(shiftOf(0x3FF00000), 22);
  EXPECT_EQ(shiftOf(0x000FFC00), 12);
  EXPECT_EQ(shiftOf(0x000003FF), 2);
}

TEST(PixelLayout, WhiteIsWhiteOnADisplayOfTenBitsAColour) {
  const PixelLayout layout{shiftOf(0x3FF00000), shiftOf(0x000FFC00), shiftOf(0x000003FF)};
  Pixels pixels;
  drawFitted({255, 255, 255}, 1, 1, layout, 1, 1, &pixels);
  ASSERT_EQ(pixels.size(), 1U);
  for (const int first : {20, 10, 0})
    EXPECT_EQ(pixels[0] >> first & 0x3FFU, 1020U) << "of 1023";
}

TEST(WindowPixels, APictureOfTheWindowsSizeIsItself) {
  const Pixels picture{kRed, kGreen, 0x102030, kBlue, 0, kWhite};
  EXPECT_EQ(shown(picture, 3, 2, 3, 2), picture);
  EXPECT_EQ(shown(picture, 2, 3, 2, 3), picture);
}

TEST(WindowPixels, WhatIsTooHighOrTooWideForItStaysBlack) {
  EXPECT_EQ(shown({kRed, kGreen}, 2, 1, 4, 4), (Pixels{0, 0, 0, 0,                  //
                                                       kRed, kRed, kGreen, kGreen,  //
                                                       kRed, kRed, kGreen, kGreen,  //
                                                       0, 0, 0, 0}));
  EXPECT_EQ(shown({kRed, kGreen}, 1, 2, 4, 2), (Pixels{0, kRed, 0, 0,  //
                                                       0, kGreen, 0, 0}));
  EXPECT_EQ(shown({kRed, kGreen}, 1, 2, 5, 4), (Pixels{0, kRed,   kRed,   0, 0,  //
                                                       0, kRed,   kRed,   0, 0,  //
                                                       0, kGreen, kGreen, 0, 0,  //
                                                       0, kGreen, kGreen, 0, 0}));
}

TEST(WindowPixels, ASmallerWindowTakesTheNearestPixels) {
  Pixels picture;
  for (std::uint32_t i = 0; i < 16; ++i)
    picture.push_back(i);
  EXPECT_EQ(shown(picture, 4, 4, 2, 2), (Pixels{0, 2, 8, 10}));
}

/** Pictures of all shapes are within the window, and as large as it allows in one direction. */
TEST(WindowPixels, EveryFitIsWithinTheWindowAndTouchesIt) {
  for (const int picture_width : {1, 2, 3, 100, 640}) {
    for (const int picture_height : {1, 2, 7, 360}) {
      for (const int width : {1, 2, 3, 640, 999}) {
        for (const int height : {1, 2, 5, 360, 777}) {
          const PictureFit place = fit(picture_width, picture_height, width, height);
          EXPECT_GE(place.left, 0);
          EXPECT_GE(place.top, 0);
          EXPECT_GE(place.width, 1);
          EXPECT_GE(place.height, 1);
          EXPECT_LE(place.left + place.width, width);
          EXPECT_LE(place.top + place.height, height);
          EXPECT_TRUE(place.width == width || place.height == height)
              << picture_width << "x" << picture_height << " in " << width << "x" << height;
        }
      }
    }
  }
}

}  // namespace
}  // namespace raven2_trainer::apps
