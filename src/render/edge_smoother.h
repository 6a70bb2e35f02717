#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace raven2_trainer::render {

/**
 * Softens stair-steps of finished pixels: where the brightness across a pixel's diagonals differs, colours are averaged
 * along the edge (the idea of FXAA, T. Lottes, 2009). On the processor, because only edges cost time here, while
 * llvmpipe pays for every pixel: 17 ms at 1280x720 as a shader. Four-fold multisampling costs 60 ms. Colours are whole
 * numbers throughout, so that compilers can take many pixels at once; steps along edges are floats, the same ones on
 * every x86-64 as long as multiplications and additions are not fused, which the build sees to.
 */
class EdgeSmoother {
 public:
  EdgeSmoother(int width, int height);

  /** @param[in] rgba width x height x 4 bytes. @param[out] rgb width x height x 3 bytes, same rows. */
  void smooth(const std::uint8_t* rgba, std::uint8_t* rgb);

 private:
  static constexpr int kBlock = 8;  // pixels of a row that are looked at together
  /** [1/64 px] from each pixel of a block to its taps on one side. */
  struct Steps {
    int near_x[kBlock], near_y[kBlock], far_x[kBlock], far_y[kBlock];
  };
  void splitRow(const std::uint8_t* rgba, int y, std::uint8_t* rgb) noexcept;
  void findEdges(int y) noexcept;
  Steps stepsAt(int x, int y) const noexcept;
  void smoothRow(const std::uint8_t* rgba, int y, std::uint8_t* rgb) const noexcept;
  void smoothPixel(const std::uint8_t* rgba, int x, int y, const Steps& steps, int i, std::uint8_t* out) const noexcept;
  std::uint64_t twoTaps(const std::uint8_t* rgba, int x, int y, int u, int v) const noexcept;
  std::uint64_t sample(const std::uint8_t* rgba, int x, int y) const noexcept;
  std::size_t index(int x, int y) const noexcept {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
  }

  int width_, height_;
  std::vector<std::uint8_t> luma_;   // brightness of every pixel; room for a block behind them
  std::vector<std::uint8_t> edges_;  // of one row, from its second pixel on: 0 where nothing is to be smoothed
};

}  // namespace raven2_trainer::render
