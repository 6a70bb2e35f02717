#pragma once

#include <cstdint>
#include <vector>

#include "raven2_trainer/render/scene.h"
#include "render/stroke_font.h"

namespace raven2_trainer::render {

/** Pixels left <= x < right, top <= y < bottom. */
struct Region {
  int left{}, top{}, right{}, bottom{};
};

/** Draws the overlay into finished pixels in software: text and bars on a dark panel at the top left, the banner on a
 *  red strip at the middle of the bottom edge. Sizes follow the height of the picture, down to what can be read;
 *  in smaller pictures the panel has fewer lines. */
class OverlayPainter {
 public:
  OverlayPainter(int width, int height);

  /** @param[in,out] rgb width x height x 3 bytes, top row first. Nothing outside the two regions changes. */
  void paint(const Overlay& overlay, std::vector<std::uint8_t>* rgb) const;

  /** Of the panel; empty if there are no lines, no warnings and no bars. Never reaches outside the picture. */
  Region panelRegion(const Overlay& overlay) const noexcept;

  /** Of the banner; empty without one. Never reaches outside the picture. */
  Region bannerRegion(const Overlay& overlay) const noexcept;

 private:
  struct Colour {
    int r, g, b;
  };
  void blend(const Region& region, Colour colour, int opacity, std::uint8_t* rgb) const;
  void drawGlyph(const StrokeFont& font, const Region& limit, char c, int x, int y, Colour colour, std::uint8_t* rgb)
      const;
  void drawText(const StrokeFont& font,
                const Region& limit,
                const std::string& text,
                int x,
                int y,
                Colour colour,
                std::uint8_t* rgb) const;
  void drawLines(const Overlay& overlay, const Region& panel, std::uint8_t* rgb) const;
  void drawBars(const Overlay& overlay, const Region& panel, std::uint8_t* rgb) const;
  Region clip(Region region) const noexcept;
  /** [px] of a panel with these lines. */
  int panelHeight(const Overlay& overlay, const std::vector<std::string>& lines) const noexcept;
  /** The lines, or the brief ones where the picture is too small for them. */
  const std::vector<std::string>& linesOf(const Overlay& overlay) const noexcept;
  /** Lines and warnings, as many as there is room for. */
  std::size_t textRows(const Overlay& overlay) const noexcept;

  int width_, height_;
  double unit_;  ///< [px] of the small font's grid
  int margin_;   ///< [px]
  StrokeFont small_, large_;
};

}  // namespace raven2_trainer::render
