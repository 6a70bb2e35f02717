#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace raven2_trainer::render {

/** Printable ASCII as strokes on a grid, drawn once into smooth-edged masks of one size. */
class StrokeFont {
 public:
  /** @param[in] unit [px] of a grid square: capitals are 6 units tall, letters advance by 5.5. */
  explicit StrokeFont(double unit);

  /** Coverage 0..255 of a character, cellWidth() x cellHeight(), row by row. Others than ASCII 32..126 show as '?'. */
  const std::uint8_t* mask(char c) const noexcept;

  int cellWidth() const noexcept { return cell_width_; }
  int cellHeight() const noexcept { return cell_height_; }

  /** [px] Width of a line of text. */
  int width(const std::string& text) const noexcept { return cell_width_ * static_cast<int>(text.size()); }

 private:
  int cell_width_, cell_height_;
  std::vector<std::uint8_t> masks_;
};

}  // namespace raven2_trainer::render
