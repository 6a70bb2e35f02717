#pragma once

#include <cstdint>
#include <vector>

// What a window shows of a picture, as numbers: needs no display.

namespace raven2_trainer::apps {

/** [bits] by which the 8 bits of each colour are shifted to their place in a pixel of the display. */
struct PixelLayout {
  int red{}, green{}, blue{};
};

/** Those of a colour become the highest of its mask, which has at least as many: of a display of 10 bits a colour the
 * lowest two stay 0, and white is as good as white. @param[in] mask of a visual. */
int shiftOf(unsigned long mask) noexcept;

/** A picture in a window: as large as that allows, in its middle, its shape kept; nearest pixels, the rest black. */
struct PictureFit {
  int left{}, top{}, width{}, height{};  ///< [px] of the picture in the window
};
PictureFit fit(int picture_width, int picture_height, int width, int height) noexcept;

/**
 * The window's pixels.
 * @param[in] rgb top row first, picture_width x picture_height x 3 bytes. All sizes at least 1.
 * @param[out] pixels width x height, top row first.
 */
void drawFitted(const std::vector<std::uint8_t>& rgb,
                int picture_width,
                int picture_height,
                const PixelLayout& layout,
                int width,
                int height,
                std::vector<std::uint32_t>* pixels);

}  // namespace raven2_trainer::apps
