#include "render/overlay_painter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <limits>
#include <set>
#include <string>
#include <tuple>
#include <vector>

namespace raven2_trainer::render {
namespace {

constexpr int kWidth = 640;
constexpr int kHeight = 360;

std::vector<std::uint8_t> grey() {
  return std::vector<std::uint8_t>(static_cast<std::size_t>(kWidth) * kHeight * 3, 128);
}

bool contains(const Region& r, int x, int y) {
  return x >= r.left && x < r.right && y >= r.top && y < r.bottom;
}

/** Bytes that differ from grey; fails if one lies outside both regions. */
int changedInside(const std::vector<std::uint8_t>& rgb, const Region& a, const Region& b) {
  int changed = 0;
  for (std::size_t i = 0; i < rgb.size(); ++i) {
    if (rgb[i] == 128) continue;
    ++changed;
    const int x = static_cast<int>(i / 3) % kWidth, y = static_cast<int>(i / 3) / kWidth;
    EXPECT_TRUE(contains(a, x, y) || contains(b, x, y)) << x << ", " << y;
    if (::testing::Test::HasFailure()) return -1;
  }
  return changed;
}

TEST(OverlayPainter, ChangesPixelsInItsRegionsOnly) {
  const OverlayPainter painter(kWidth, kHeight);
  Overlay overlay;
  overlay.lines = {"time 1.000 s", "a longer line of text, with descenders: jgpqy"};
  overlay.has_bars = true;
  overlay.force = {1.0, 9.0};
  overlay.max_force = 3.3;
  overlay.banner = "FAULT: sudden_jump";
  auto rgb = grey();
  painter.paint(overlay, &rgb);
  EXPECT_GT(changedInside(rgb, painter.panelRegion(overlay), painter.bannerRegion(overlay)), 5000);
}

TEST(OverlayPainter, ASmallPictureHasTheBriefLinesAndStaysVisible) {
  Overlay overlay;
  overlay.lines = std::vector<std::string>(9, "exercise  step 2 of 3, not so long");
  overlay.brief = {"teleoperating", "step 2 of 3, 3 s, 0 mistakes"};
  overlay.has_bars = true;
  Overlay brief = overlay;
  brief.lines = overlay.brief;
  for (const auto& [width, height, is_small] :
       {std::tuple{320, 180, true}, {426, 240, true}, {640, 360, false}, {1280, 720, false}}) {
    const OverlayPainter painter(width, height);
    const Region panel = painter.panelRegion(overlay);
    EXPECT_EQ(panel.bottom == painter.panelRegion(brief).bottom, is_small) << height;
    EXPECT_LT((panel.right - panel.left) * (panel.bottom - panel.top), width * height / 4) << height;
    std::vector<std::uint8_t> one(static_cast<std::size_t>(width) * height * 3, 128), other = one;
    painter.paint(overlay, &one);
    painter.paint(brief, &other);
    EXPECT_EQ(one == other, is_small) << height;
  }
  overlay.brief.clear();
  const OverlayPainter painter(320, 180);
  EXPECT_GT(painter.panelRegion(overlay).bottom, painter.panelRegion(brief).bottom)
      << "without a brief text the whole text is drawn";
}

TEST(OverlayPainter, AnEmptyOverlayChangesNothing) {
  const OverlayPainter painter(kWidth, kHeight);
  auto rgb = grey();
  painter.paint(Overlay{}, &rgb);
  EXPECT_EQ(rgb, grey());
}

TEST(OverlayPainter, OtherTextGivesOtherPixels) {
  const OverlayPainter painter(kWidth, kHeight);
  Overlay overlay;
  overlay.lines = {"gold error 1.23 mm"};
  auto one = grey(), other = grey();
  painter.paint(overlay, &one);
  overlay.lines = {"gold error 1.28 mm"};
  painter.paint(overlay, &other);
  EXPECT_NE(one, other);
}

TEST(OverlayPainter, BarsGrowWithTheForceUpToTheirEnd) {
  const OverlayPainter painter(kWidth, kHeight);
  const auto goldPixels = [&painter](double force) {
    Overlay overlay;
    overlay.lines = {"x"};
    overlay.has_bars = true;
    overlay.force = {force, 0.0};
    overlay.max_force = 2.0;
    auto rgb = grey();
    painter.paint(overlay, &rgb);
    int count = 0;
    for (std::size_t i = 0; i < rgb.size(); i += 3)
      count += rgb[i] == 236 && rgb[i + 1] == 186 && rgb[i + 2] == 60;
    return count;
  };
  EXPECT_LT(goldPixels(0.0), goldPixels(1.0));
  EXPECT_LT(goldPixels(1.0), goldPixels(2.0));
  EXPECT_LT(goldPixels(5.0), goldPixels(2.0) + goldPixels(1.0)) << "a bar ends at max_force";
}

TEST(OverlayPainter, EachArmsBarShowsItsOwnForce) {
  const OverlayPainter painter(kWidth, kHeight);
  using Colour = std::array<std::uint8_t, 3>;
  const auto count = [&painter](const PerArm<double>& force, const Colour& colour) {
    Overlay overlay;
    overlay.lines = {"x"};
    overlay.has_bars = true;
    overlay.force = force;
    overlay.max_force = 2.0;
    auto rgb = grey();
    painter.paint(overlay, &rgb);
    int pixels = 0;
    for (std::size_t i = 0; i < rgb.size(); i += 3)
      pixels += Colour{rgb[i], rgb[i + 1], rgb[i + 2]} == colour;
    return pixels;
  };
  const Colour gold{236, 186, 60}, green{94, 200, 110};
  EXPECT_GT(count({2.0, 0.0}, gold), count({0.0, 2.0}, gold) + 200);
  EXPECT_GT(count({0.0, 2.0}, green), count({2.0, 0.0}, green) + 200);
}

TEST(OverlayPainter, WarningsStandBelowTheLinesInAmber) {
  const OverlayPainter painter(kWidth, kHeight);
  const auto is_amber = [](const std::uint8_t* p) { return p[0] > 200 && p[1] > 130 && p[1] < 200 && p[2] < 90; };
  Overlay overlay;
  overlay.lines = {"plain"};
  const Region plain = painter.panelRegion(overlay);
  overlay.warnings = {"gold limit"};
  auto rgb = grey();
  painter.paint(overlay, &rgb);
  EXPECT_GT(painter.panelRegion(overlay).bottom, plain.bottom);
  int amber = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      if (!is_amber(&rgb[3 * static_cast<std::size_t>(y * kWidth + x)])) continue;
      ++amber;
      EXPECT_GT(2 * y, plain.bottom) << "amber only below the line";
    }
  }
  EXPECT_GT(amber, 20);
}

TEST(OverlayPainter, NotFiniteForcesAndEndlessTextStayInThePicture) {
  const OverlayPainter painter(kWidth, kHeight);
  Overlay overlay;
  overlay.lines.assign(500, std::string(1000, 'W'));
  overlay.has_bars = true;
  overlay.force = {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()};
  overlay.max_force = 0.0;
  overlay.banner = std::string(1000, 'M');
  auto rgb = grey();
  painter.paint(overlay, &rgb);
  const Region panel = painter.panelRegion(overlay), banner = painter.bannerRegion(overlay);
  EXPECT_LE(panel.right, kWidth);
  EXPECT_LE(panel.bottom, kHeight);
  EXPECT_GE(banner.left, 0);
  EXPECT_GT(changedInside(rgb, panel, banner), 0);
}

TEST(StrokeFont, EveryPrintableCharacterHasItsOwnShape) {
  const StrokeFont font(2.0);
  const auto size = static_cast<std::size_t>(font.cellWidth() * font.cellHeight());
  std::set<std::vector<std::uint8_t>> shapes;
  for (char c = ' '; c <= '~'; ++c)
    shapes.insert(std::vector<std::uint8_t>(font.mask(c), font.mask(c) + size));
  EXPECT_EQ(shapes.size(), 95U);
}

TEST(StrokeFont, OnlyTheSpaceIsBlankAndUnknownCharactersShowAsQuestionMarks) {
  const StrokeFont font(2.0);
  const int size = font.cellWidth() * font.cellHeight();
  for (char c = ' '; c <= '~'; ++c) {
    EXPECT_EQ(std::any_of(font.mask(c), font.mask(c) + size, [](std::uint8_t m) { return m > 200; }), c != ' ') << c;
  }
  EXPECT_EQ(font.mask('\n'), font.mask('?'));
  EXPECT_EQ(font.mask(static_cast<char>(0xE9)), font.mask('?'));
}

}  // namespace
}  // namespace raven2_trainer::render
