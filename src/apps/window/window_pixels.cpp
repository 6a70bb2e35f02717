#include "apps/window/window_pixels.h"

#include <algorithm>
#include <cstddef>

namespace raven2_trainer::apps {

int shiftOf(unsigned long mask) noexcept {
  constexpr int kBits = 8;  // of a colour of ours
  int highest = -1;
  for (; mask != 0; mask >>= 1)
    ++highest;
  return std::max(0, highest - (kBits - 1));
}

PictureFit fit(int picture_width, int picture_height, int width, int height) noexcept {
  const double share =
      std::min(static_cast<double>(width) / picture_width, static_cast<double>(height) / picture_height);
  const int w = std::clamp(static_cast<int>(picture_width * share + 0.5), 1, width);
  const int h = std::clamp(static_cast<int>(picture_height * share + 0.5), 1, height);
  return {(width - w) / 2, (height - h) / 2, w, h};
}

void drawFitted(const std::vector<std::uint8_t>& rgb,
                int picture_width,
                int picture_height,
                const PixelLayout& layout,
                int width,
                int height,
                std::vector<std::uint32_t>* pixels) {
  pixels->assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 0);
  const PictureFit place = fit(picture_width, picture_height, width, height);
  for (int v = 0; v < place.height; ++v) {
    const long long from = static_cast<long long>(v) * picture_height / place.height;
    const std::uint8_t* row = rgb.data() + 3LL * picture_width * from;
    std::uint32_t* out = pixels->data() + static_cast<std::ptrdiff_t>(place.top + v) * width + place.left;
    for (int u = 0; u < place.width; ++u) {
      const std::uint8_t* p = row + 3LL * (static_cast<long long>(u) * picture_width / place.width);
      out[u] = static_cast<std::uint32_t>(p[0]) << layout.red | static_cast<std::uint32_t>(p[1]) << layout.green |
               static_cast<std::uint32_t>(p[2]) << layout.blue;
    }
  }
}

}  // namespace raven2_trainer::apps
