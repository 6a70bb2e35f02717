#pragma once

#include <cstdint>
#include <vector>

namespace raven2_trainer::render {

/**
 * Softens stair-steps of finished pixels: where the brightness across a pixel's diagonals differs, colours are averaged
 * along the edge (the idea of FXAA, T. Lottes, 2009). On the processor, because only edges cost time here, while
 * llvmpipe pays for every pixel: 17 ms at 1280x720 as a shader. Four-fold multisampling costs 60 ms.
 */
class EdgeSmoother {
 public:
  EdgeSmoother(int width, int height);

  /** @param[in] rgba width x height x 4 bytes. @param[out] rgb width x height x 3 bytes, same rows. */
  void smooth(const std::uint8_t* rgba, std::uint8_t* rgb);

 private:
  struct Rgb {
    float r, g, b;
  };
  void split(const std::uint8_t* rgba, std::uint8_t* rgb);
  void smoothPixel(const std::uint8_t* rgba, int x, int y, std::uint8_t* out) const;
  Rgb sample(const std::uint8_t* rgba, float x, float y) const;

  int width_, height_;
  std::vector<std::uint8_t> luma_;  // brightness of every pixel
};

}  // namespace raven2_trainer::render
