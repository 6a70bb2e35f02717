#include "render/shade_tiles.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>

#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::render {

namespace {

/** Beyond the map its edge is looked up. */
int cellOf(float clip) noexcept {
  constexpr float kLast = static_cast<float>(ShadeTiles::kCells - 1);
  const float cell = 0.5F * (clip + 1.0F) * static_cast<float>(ShadeTiles::kCells);
  return static_cast<int>(std::floor(std::clamp(cell, 0.0F, kLast)));
}

}  // namespace

ShadeTiles::ShadeTiles(int map_size) : map_size_(map_size) {
  if (map_size != 2 * kCells && map_size != 4 * kCells)
    throw RenderException("a shadow map of " + std::to_string(map_size) + " texels, expected " +
                          std::to_string(2 * kCells) + " or " + std::to_string(4 * kCells));
}

void ShadeTiles::setPicture(int width,
                            int height,
                            const std::vector<float>& depth,
                            const Eigen::Matrix4f& clip_from_world,
                            const Eigen::Matrix4f& shadow_clip_from_world,
                            float margin,
                            const std::vector<float>& fixed_map) {
  width_ = width;
  height_ = height;
  columns_ = (width + kTile - 1) / kTile;
  rows_ = (height + kTile - 1) / kTile;
  fixed_map_ = fixed_map;
  extents_.assign(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_), Extent{});
  const Eigen::Matrix4d light_from_clip =
      shadow_clip_from_world.cast<double>() * clip_from_world.cast<double>().inverse();
  std::size_t pixel = 0;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x, ++pixel) {
      if (depth[pixel] >= 1.0F) continue;
      const Eigen::Vector4d clip(2.0 * (x + 0.5) / width - 1.0, 2.0 * (y + 0.5) / height - 1.0,
                                 2.0 * static_cast<double>(depth[pixel]) - 1.0, 1.0);
      const Eigen::Vector2f at = (light_from_clip * clip).hnormalized().head<2>().cast<float>();
      Extent& extent = extents_[static_cast<std::size_t>((y / kTile) * columns_ + x / kTile)];
      for (int i = 0; i < 2; ++i) {
        const auto axis = static_cast<std::size_t>(i);
        extent.low[axis] = std::min(extent.low[axis], cellOf(at[i] - margin));
        extent.high[axis] = std::max(extent.high[axis], cellOf(at[i] + margin));
      }
    }
  }
}

/** A cell of a row at a time: as whole words, or one by one it would take a millisecond and more. A cell has kTexels
 * texels a row. */
template <std::size_t kTexels>
void ShadeTiles::compare(const std::vector<float>& map) noexcept {
  differs_.fill(0);
  constexpr std::size_t kBytes = kTexels * sizeof(float);
  const auto size = static_cast<std::size_t>(map_size_);
  for (std::size_t y = 0; y < size; ++y) {
    const float* row = &map[y * size];
    const float* fixed_row = &fixed_map_[y * size];
    std::uint8_t* cells = &differs_[(y / kTexels) * kCells];
    for (std::size_t cell = 0; cell < kCells; ++cell) {
      std::array<std::uint64_t, kTexels / 2> a{}, b{};
      std::memcpy(a.data(), row + cell * kTexels, kBytes);
      std::memcpy(b.data(), fixed_row + cell * kTexels, kBytes);
      cells[cell] |= static_cast<std::uint8_t>(a != b);
    }
  }
}

void ShadeTiles::addUp() noexcept {
  constexpr int kStride = kCells + 1;
  for (int y = 0; y < kCells; ++y) {
    int row = 0;
    for (int x = 0; x < kCells; ++x) {
      row += differs_[static_cast<std::size_t>(y * kCells + x)];
      const int below = sums_[static_cast<std::size_t>(y * kStride + x + 1)];
      sums_[static_cast<std::size_t>((y + 1) * kStride + x + 1)] = below + row;
    }
  }
}

bool ShadeTiles::isTouched(const Extent& extent) const noexcept {
  if (extent.high[0] < extent.low[0]) return false;
  const auto sum = [this](int x, int y) { return sums_[static_cast<std::size_t>(y * (kCells + 1) + x)]; };
  const int left = extent.low[0], right = extent.high[0] + 1, bottom = extent.low[1], top = extent.high[1] + 1;
  return sum(right, top) - sum(left, top) - sum(right, bottom) + sum(left, bottom) > 0;
}

void ShadeTiles::closeRun(int row, int from, int to) {
  if (from < 0) return;
  runs_.push_back({from * kTile, std::min(to * kTile, width_), row * kTile, std::min((row + 1) * kTile, height_)});
}

const std::vector<PixelRun>& ShadeTiles::touched(const std::vector<float>& map) {
  runs_.clear();
  map_size_ == 2 * kCells ? compare<2>(map) : compare<4>(map);
  addUp();
  for (int row = 0; row < rows_; ++row) {
    int from = -1;
    for (int column = 0; column < columns_; ++column) {
      const bool is_touched = isTouched(extents_[static_cast<std::size_t>(row * columns_ + column)]);
      if (is_touched && from < 0) from = column;
      if (is_touched) continue;
      closeRun(row, from, column);
      from = -1;
    }
    closeRun(row, from, columns_);
  }
  return runs_;
}

}  // namespace raven2_trainer::render
