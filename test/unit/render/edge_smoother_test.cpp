#include "render/edge_smoother.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

namespace raven2_trainer::render {
namespace {

using Rgb = std::array<double, 3>;

/** A picture with alpha, the input of the smoother. */
struct Picture {
  Picture(int picture_width, int picture_height)
      : width(picture_width), height(picture_height), rgba(static_cast<std::size_t>(4 * width * height), 255) {}

  std::uint8_t* pixel(int x, int y) { return &rgba[static_cast<std::size_t>(4 * (y * width + x))]; }
  double brightness(int x, int y) {
    const std::uint8_t* p = pixel(x, y);
    return std::floor((77 * p[0] + 150 * p[1] + 29 * p[2]) / 256.0);
  }
  std::vector<std::uint8_t> plain() const {
    std::vector<std::uint8_t> rgb;
    for (std::size_t i = 0; i < rgba.size(); ++i)
      if (i % 4 != 3) rgb.push_back(rgba[i]);
    return rgb;
  }
  std::vector<std::uint8_t> smoothed() const {
    std::vector<std::uint8_t> rgb(rgba.size() / 4 * 3, 7);
    EdgeSmoother(width, height).smooth(rgba.data(), rgb.data());
    return rgb;
  }

  int width, height;
  std::vector<std::uint8_t> rgba;
};

/** Two colours with a straight line between them. */
Picture edge(int width, int height, double slope, const std::array<int, 3>& above, const std::array<int, 3>& below) {
  Picture picture(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const auto& colour = y - height / 2.0 < slope * (x - width / 2.0) ? above : below;
      std::copy(colour.begin(), colour.end(), picture.pixel(x, y));
    }
  }
  return picture;
}

Rgb bilinear(Picture* picture, double x, double y) {
  x = std::clamp(x, 0.0, picture->width - 1.0);
  y = std::clamp(y, 0.0, picture->height - 1.0);
  Rgb sum{};
  for (int v = 0; v < picture->height; ++v) {
    for (int u = 0; u < picture->width; ++u) {
      const double weight = std::max(0.0, 1.0 - std::abs(x - u)) * std::max(0.0, 1.0 - std::abs(y - v));
      for (std::size_t i = 0; i < 3; ++i)
        sum[i] += weight * picture->pixel(u, v)[i];
    }
  }
  return sum;
}

/** Mean of the two taps at (dx, dy) to either side. */
Rgb taps(Picture* picture, int x, int y, double dx, double dy) {
  const Rgb a = bilinear(picture, x - dx, y - dy), b = bilinear(picture, x + dx, y + dy);
  return {(a[0] + b[0]) / 2.0, (a[1] + b[1]) / 2.0, (a[2] + b[2]) / 2.0};
}

/** The values that a smoothed pixel may have. */
struct Smoothed {
  Rgb near{}, all{};  ///< mean of two taps, of four
  bool may_be_near{}, may_be_all{};
};

/** The published formula (FXAA 1, "console") in floating point: the mean of all four taps, or of the near two alone if
 *  the four give a brightness outside that of the neighbours. Where rounding decides, both are allowed. */
Smoothed expected(Picture* picture, int x, int y) {
  const double nw = picture->brightness(x - 1, y - 1), ne = picture->brightness(x + 1, y - 1);
  const double sw = picture->brightness(x - 1, y + 1), se = picture->brightness(x + 1, y + 1);
  double dx = sw + se - nw - ne, dy = nw + sw - ne - se;
  const double least = std::min(std::abs(dx), std::abs(dy)) + std::max((nw + ne + sw + se) / 32.0, 2.0);
  dx = std::clamp(dx / least, -4.0, 4.0);
  dy = std::clamp(dy / least, -4.0, 4.0);
  const Rgb near = taps(picture, x, y, dx / 6.0, dy / 6.0), far = taps(picture, x, y, dx / 2.0, dy / 2.0);
  const Rgb all{(near[0] + far[0]) / 2.0, (near[1] + far[1]) / 2.0, (near[2] + far[2]) / 2.0};
  const double brightness = (77.0 * all[0] + 150.0 * all[1] + 29.0 * all[2]) / 256.0;
  const auto [low, high] = std::minmax({nw, ne, sw, se, picture->brightness(x, y)});
  constexpr double kRounding = 4.0;  // the tolerance of isNear(), and one for the brightness
  return {near, all, brightness < low + kRounding || brightness > high - kRounding,
          brightness > low - kRounding && brightness < high + kRounding};
}

bool isEdge(Picture* picture, int x, int y) {
  if (x < 1 || y < 1 || x > picture->width - 2 || y > picture->height - 2) return false;
  const double falling = picture->brightness(x - 1, y - 1) - picture->brightness(x + 1, y + 1);
  const double rising = picture->brightness(x + 1, y - 1) - picture->brightness(x - 1, y + 1);
  return std::max(std::abs(falling), std::abs(rising)) > 20.0;
}

bool isNear(const Rgb& a, const std::uint8_t* b) {
  return std::abs(a[0] - b[0]) < 3.0 && std::abs(a[1] - b[1]) < 3.0 && std::abs(a[2] - b[2]) < 3.0;
}

TEST(EdgeSmoother, APictureWithoutEdgesStaysAsItIs) {
  std::mt19937 random(1);
  Picture picture(37, 21);
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x)
      for (int i = 0; i < 3; ++i)
        picture.pixel(x, y)[i] = static_cast<std::uint8_t>(100 + random() % 10);
  }
  EXPECT_EQ(picture.smoothed(), picture.plain());
}

/** Counts of the pixels of each kind for which rounding does not decide. */
struct Kinds {
  int near{0}, all{0};
};

Kinds expectFormula(Picture picture) {
  Kinds kinds;
  const auto plain = picture.plain(), smoothed = picture.smoothed();
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      const auto at = static_cast<std::size_t>(3 * (y * picture.width + x));
      if (!isEdge(&picture, x, y)) {
        EXPECT_TRUE(std::equal(&plain[at], &plain[at] + 3, &smoothed[at]))
            << "a pixel without an edge must not change: " << x << " " << y;
        continue;
      }
      const Smoothed due = expected(&picture, x, y);
      EXPECT_TRUE((due.may_be_near && isNear(due.near, &smoothed[at])) ||
                  (due.may_be_all && isNear(due.all, &smoothed[at])))
          << x << " " << y;
      if (!due.may_be_all) ++kinds.near;
      if (!due.may_be_near) ++kinds.all;
    }
  }
  return kinds;
}

TEST(EdgeSmoother, PixelsAtEdgesAreThoseOfTheFormulaAndOthersStay) {
  int all = 0;
  for (const double slope : {0.2, -0.35, 1.0, 2.5, -8.0}) {
    SCOPED_TRACE(slope);
    all += expectFormula(edge(43, 30, slope, {230, 60, 40}, {20, 80, 200})).all;
  }
  EXPECT_GT(all, 20);
}

/** An edge of two greys, crossed by bright lines. Only the far taps of pixels two columns away reach the lines. */
TEST(EdgeSmoother, TapsThatLeaveTheEdgeAreNotTaken) {
  Picture picture = edge(43, 30, 0.0, {100, 100, 100}, {130, 130, 130});
  for (int x = 0; x < picture.width; x += 5) {
    for (int y = 0; y < picture.height; ++y)
      std::fill_n(picture.pixel(x, y), 3, std::uint8_t{250});
  }
  EXPECT_GT(expectFormula(picture).near, 10);
}

TEST(EdgeSmoother, AStairStepGetsInBetweenColours) {
  const Picture picture = edge(64, 32, 0.2, {255, 255, 255}, {0, 0, 0});
  const auto smoothed = picture.smoothed();
  const auto between = std::count_if(smoothed.begin(), smoothed.end(), [](int c) { return c > 40 && c < 215; });
  EXPECT_GT(between, 64);
}

/** Smooths into memory filled with a value, with `guard` bytes before and after the picture. */
std::vector<std::uint8_t> guarded(const Picture& picture, std::uint8_t filling, std::size_t guard) {
  std::vector<std::uint8_t> bytes(picture.rgba.size() / 4 * 3 + 2 * guard, filling);
  EdgeSmoother(picture.width, picture.height).smooth(picture.rgba.data(), bytes.data() + guard);
  return bytes;
}

TEST(EdgeSmoother, PicturesOfAnySizeAreSmoothedWithinTheirBounds) {
  constexpr std::ptrdiff_t kGuard = 64;
  for (const int width : {1, 2, 3, 9, 10, 17}) {
    for (const int height : {1, 2, 3, 5}) {
      const Picture picture = edge(width, height, 0.5, {255, 255, 255}, {0, 0, 0});
      const auto first = guarded(picture, 0xA5, kGuard), second = guarded(picture, 0x5A, kGuard);
      EXPECT_EQ(std::count(first.begin(), first.begin() + kGuard, 0xA5), kGuard) << width << " " << height;
      EXPECT_EQ(std::count(first.end() - kGuard, first.end(), 0xA5), kGuard) << width << " " << height;
      EXPECT_TRUE(std::equal(first.begin() + kGuard, first.end() - kGuard, second.begin() + kGuard))
          << "the smoother must write every byte: " << width << " " << height;
    }
  }
}

}  // namespace
}  // namespace raven2_trainer::render
