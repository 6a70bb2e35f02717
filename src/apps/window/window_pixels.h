#pragma once

#include <cstdint>
#include <vector>

// Pixels of a window that shows a picture. Needs no display.

namespace raven2_trainer::apps {

/** [bits] by which the 8 bits of each colour are shifted to their place in a pixel of the display. */
struct PixelLayout {
  int red{}, green{}, blue{};
};

/** Shifts 8 bits of a colour to the highest bits of its mask: on a display with 10 bits a colour the lowest two stay 0.
 * @param[in] mask of a visual, with at least 8 bits. */
int shiftOf(unsigned long mask) noexcept;

/** Place of a picture in a window: in the middle, as large as possible with its shape kept; the rest is black. */
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
