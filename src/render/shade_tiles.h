#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace raven2_trainer::render {

/** Pixels of a picture: from left and bottom up to, but not with, right and top; counted from the bottom left. */
struct PixelRun {
  int left, right, bottom, top;
};

/**
 * The tiles of a picture of fixed things that moving things may shade. In them a point looks up a part of the key
 * light's shadow map that differs from the map of fixed things alone. Some more tiles are found, never
 * fewer. No OpenGL.
 */
class ShadeTiles {
 public:
  static constexpr int kTile = 8;     ///< [px]
  static constexpr int kCells = 256;  ///< of the map, on x and y

  /** @param[in] map_size [texels] of the shadow map's edge. @throw RenderException unless it is two or four times
   * kCells. */
  explicit ShadeTiles(int map_size);

  /**
   * The picture of fixed things.
   * @param[in] depth [0, 1] of each pixel, bottom row first; 1: nothing is there.
   * @param[in] margin [-] in the light's clip space, by which a lookup may be off the point that it shades.
   * @param[in] fixed_map its own shadow map, bottom row first.
   */
  void setPicture(int width,
                  int height,
                  const std::vector<float>& depth,
                  const Eigen::Matrix4f& clip_from_world,
                  const Eigen::Matrix4f& shadow_clip_from_world,
                  float margin,
                  const std::vector<float>& fixed_map);

  /** Valid until the next call. @param[in] map with what moves in it. */
  const std::vector<PixelRun>& touched(const std::vector<float>& map);

 private:
  /** Extent of a tile's points in the light's space, in cells; empty without points. */
  struct Extent {
    std::array<int, 2> low{kCells, kCells}, high{-1, -1};
  };
  bool isTouched(const Extent& extent) const noexcept;
  template <std::size_t kTexels>
  void compare(const std::vector<float>& map) noexcept;
  void addUp() noexcept;
  void closeRun(int row, int from, int to);

  const int map_size_;
  int width_{0}, height_{0}, columns_{0}, rows_{0};
  std::vector<float> fixed_map_;
  std::vector<Extent> extents_;                          // tile by tile, bottom row first
  std::array<std::uint8_t, kCells * kCells> differs_{};  // cell by cell
  std::array<int, (kCells + 1) * (kCells + 1)> sums_{};  // of the cells below and to the left
  std::vector<PixelRun> runs_;
};

}  // namespace raven2_trainer::render
