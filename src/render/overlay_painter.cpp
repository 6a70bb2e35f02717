#include "render/overlay_painter.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace raven2_trainer::render {

namespace {

constexpr int kOpaque = 256;  // of blend()
constexpr int kPanelOpacity = 168;
constexpr double kBarWidth = 60.0;  // [grid units] of a full bar
constexpr std::size_t kMaxLines = 40;
constexpr double kMostHigh = 0.4;  // [-] of the picture's height; a higher panel has the brief lines

double gridUnit(int height) {
  return std::max(1.0, height / 720.0 * 1.8);  // 11 px capitals at 720 lines
}

std::string barText(const Overlay& overlay, std::size_t arm) {
  char text[48];
  const double force = std::isfinite(overlay.force[arm]) ? std::min(std::abs(overlay.force[arm]), 999.0) : 0.0;
  std::snprintf(text, sizeof text, "%-5s %5.2f N", kArmNames[arm], force);
  return text;
}

double barFill(const Overlay& overlay, std::size_t arm) {
  const double fill = std::abs(overlay.force[arm]) / overlay.max_force;
  return std::isfinite(fill) ? std::clamp(fill, 0.0, 1.0) : 0.0;
}

bool isInside(const Region& r, int x, int y) noexcept {
  return x >= r.left && x < r.right && y >= r.top && y < r.bottom;
}

/** Where two regions overlap; empty, never inverted, if they do not. */
Region common(const Region& a, const Region& b) noexcept {
  const int left = std::max(a.left, b.left), top = std::max(a.top, b.top);
  return {left, top, std::max(left, std::min(a.right, b.right)), std::max(top, std::min(a.bottom, b.bottom))};
}

int textColumns(const Overlay& overlay, const std::vector<std::string>& lines) {
  std::size_t columns = overlay.has_bars ? barText(overlay, 0).size() + 1 : 0;
  for (const auto* each : {&lines, &overlay.warnings}) {
    for (const std::string& line : *each)
      columns = std::max(columns, line.size());
  }
  return static_cast<int>(std::min<std::size_t>(columns, 200));
}

}  // namespace

OverlayPainter::OverlayPainter(int width, int height)
    : width_(width),
      height_(height),
      unit_(gridUnit(height)),
      margin_(static_cast<int>(std::lround(6.0 * unit_))),
      small_(unit_),
      large_(2.0 * unit_) {}

Region OverlayPainter::clip(Region r) const noexcept {
  r.left = std::clamp(r.left, 0, width_);
  r.right = std::clamp(r.right, r.left, width_);
  r.top = std::clamp(r.top, 0, height_);
  r.bottom = std::clamp(r.bottom, r.top, height_);
  return r;
}

int OverlayPainter::panelHeight(const Overlay& overlay, const std::vector<std::string>& lines) const noexcept {
  const std::size_t rows = std::min(lines.size() + overlay.warnings.size(), kMaxLines);
  return 2 * margin_ + static_cast<int>(rows + (overlay.has_bars ? kArmCount : 0)) * small_.cellHeight();
}

const std::vector<std::string>& OverlayPainter::linesOf(const Overlay& overlay) const noexcept {
  const bool is_high = panelHeight(overlay, overlay.lines) > kMostHigh * height_;
  return is_high && !overlay.brief.empty() ? overlay.brief : overlay.lines;
}

std::size_t OverlayPainter::textRows(const Overlay& overlay) const noexcept {
  return std::min(linesOf(overlay).size() + overlay.warnings.size(), kMaxLines);
}

Region OverlayPainter::panelRegion(const Overlay& overlay) const noexcept {
  if (textRows(overlay) == 0 && !overlay.has_bars) return {};
  const int bar = overlay.has_bars ? small_.width(barText(overlay, 0) + " ") + static_cast<int>(kBarWidth * unit_) : 0;
  const std::vector<std::string>& lines = linesOf(overlay);
  const int width = std::max(textColumns(overlay, lines) * small_.cellWidth(), bar) + 2 * margin_;
  return clip({margin_, margin_, margin_ + width, margin_ + panelHeight(overlay, lines)});
}

Region OverlayPainter::bannerRegion(const Overlay& overlay) const noexcept {
  if (overlay.banner.empty()) return {};
  const int half = (std::min(large_.width(overlay.banner), width_) + 4 * margin_) / 2;
  const int tall = 2 * margin_ + large_.cellHeight();
  return clip({width_ / 2 - half, height_ - margin_ - tall, width_ / 2 + half, height_ - margin_});
}

void OverlayPainter::blend(const Region& region, Colour colour, int opacity, std::uint8_t* rgb) const {
  const Region r = clip(region);
  const int add[3] = {colour.r * opacity, colour.g * opacity, colour.b * opacity};
  for (int y = r.top; y < r.bottom; ++y) {
    std::uint8_t* p = rgb + 3 * (static_cast<std::size_t>(y) * width_ + r.left);
    for (int i = 0; i < 3 * (r.right - r.left); ++i) {
      p[i] = static_cast<std::uint8_t>((p[i] * (kOpaque - opacity) + add[i % 3]) / kOpaque);
    }
  }
}

void OverlayPainter::drawGlyph(const StrokeFont& font,
                               const Region& limit,
                               char c,
                               int x,
                               int y,
                               Colour colour,
                               std::uint8_t* rgb) const {
  const std::uint8_t* mask = font.mask(c);
  for (int row = y; row < y + font.cellHeight(); ++row) {
    for (int column = x; column < x + font.cellWidth(); ++column, ++mask) {
      if (*mask == 0 || !isInside(limit, column, row)) continue;
      blend({column, row, column + 1, row + 1}, colour, *mask + (*mask >> 7), rgb);
    }
  }
}

void OverlayPainter::drawText(const StrokeFont& font,
                              const Region& limit,
                              const std::string& text,
                              int x,
                              int y,
                              Colour colour,
                              std::uint8_t* rgb) const {
  for (const char c : text) {
    if (x >= limit.right) return;
    drawGlyph(font, limit, c, x, y, colour, rgb);
    x += font.cellWidth();
  }
}

void OverlayPainter::drawBars(const Overlay& overlay, const Region& panel, std::uint8_t* rgb) const {
  static constexpr Colour kArmColours[kArmCount] = {{236, 186, 60}, {94, 200, 110}};
  const int full = static_cast<int>(kBarWidth * unit_);
  const int inset = static_cast<int>(std::lround(1.5 * unit_));
  const int x = panel.left + margin_ + small_.width(barText(overlay, 0) + " ");
  int y = panel.top + margin_ + static_cast<int>(textRows(overlay)) * small_.cellHeight();
  for (std::size_t arm = 0; arm < kArmCount; ++arm, y += small_.cellHeight()) {
    drawText(small_, panel, barText(overlay, arm), panel.left + margin_, y, kArmColours[arm], rgb);
    const int filled = static_cast<int>(std::lround(full * barFill(overlay, arm)));
    const int top = y + inset / 2, bottom = y + small_.cellHeight() - 2 * inset;
    blend(common({x, top, x + full, bottom}, panel), {90, 96, 104}, kOpaque, rgb);
    blend(common({x, top, x + filled, bottom}, panel), kArmColours[arm], kOpaque, rgb);
  }
}

void OverlayPainter::drawLines(const Overlay& overlay, const Region& panel, std::uint8_t* rgb) const {
  static constexpr Colour kText{240, 243, 246}, kWarning{255, 176, 46};
  const std::vector<std::string>& lines = linesOf(overlay);
  const std::size_t plain = lines.size();
  int y = panel.top + margin_;
  for (std::size_t i = 0; i < textRows(overlay); ++i, y += small_.cellHeight()) {
    const std::string& line = i < plain ? lines[i] : overlay.warnings[i - plain];
    drawText(small_, panel, line, panel.left + margin_, y, i < plain ? kText : kWarning, rgb);
  }
}

void OverlayPainter::paint(const Overlay& overlay, std::vector<std::uint8_t>* rgb) const {
  if (const Region panel = panelRegion(overlay); panel.right > panel.left) {
    blend(panel, {16, 20, 26}, kPanelOpacity, rgb->data());
    drawLines(overlay, panel, rgb->data());
    if (overlay.has_bars) drawBars(overlay, panel, rgb->data());
  }
  if (!overlay.banner.empty()) {
    const Region banner = bannerRegion(overlay);
    blend(banner, {190, 24, 28}, 232, rgb->data());
    drawText(large_, banner, overlay.banner, banner.left + 2 * margin_, banner.top + margin_, {255, 255, 255},
             rgb->data());
  }
}

}  // namespace raven2_trainer::render
