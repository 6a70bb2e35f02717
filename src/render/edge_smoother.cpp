#include "render/edge_smoother.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace raven2_trainer::render {

namespace {

constexpr int kThreshold = 20;    // [1/255] of brightness across a diagonal; below it no edge is seen
constexpr float kMaxSpan = 4.0F;  // [px] farthest tap along an edge
constexpr float kReduceFactor = 1.0F / 32.0F;
constexpr float kReduceLeast = 2.0F;  // [1/255]

float luma(float r, float g, float b) {
  return 0.30F * r + 0.59F * g + 0.11F * b;
}

}  // namespace

EdgeSmoother::EdgeSmoother(int width, int height)
    : width_(width), height_(height), luma_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height)) {}

/** Drops the alpha and notes the brightness. */
void EdgeSmoother::split(const std::uint8_t* rgba, std::uint8_t* rgb) {
  for (std::uint8_t& l : luma_) {
    l = static_cast<std::uint8_t>((77 * rgba[0] + 150 * rgba[1] + 29 * rgba[2]) >> 8);
    rgb[0] = rgba[0];
    rgb[1] = rgba[1];
    rgb[2] = rgba[2];
    rgba += 4;
    rgb += 3;
  }
}

/** Bilinear, clamped at the border. */
EdgeSmoother::Rgb EdgeSmoother::sample(const std::uint8_t* rgba, float x, float y) const {
  x = std::clamp(x, 0.0F, static_cast<float>(width_ - 1));
  y = std::clamp(y, 0.0F, static_cast<float>(height_ - 1));
  const int x0 = std::min(static_cast<int>(x), width_ - 2), y0 = std::min(static_cast<int>(y), height_ - 2);
  const float fx = x - static_cast<float>(x0), fy = y - static_cast<float>(y0);
  const std::uint8_t* p = rgba + 4 * (static_cast<std::size_t>(y0) * static_cast<std::size_t>(width_) + x0);
  const std::uint8_t* q = p + 4 * static_cast<std::size_t>(width_);
  const auto mix = [&](int i) {
    const float top = (1.0F - fx) * p[i] + fx * p[4 + i];
    const float bottom = (1.0F - fx) * q[i] + fx * q[4 + i];
    return (1.0F - fy) * top + fy * bottom;
  };
  return {mix(0), mix(1), mix(2)};
}

void EdgeSmoother::smoothPixel(const std::uint8_t* rgba, int x, int y, std::uint8_t* out) const {
  const std::uint8_t* l = luma_.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + x;
  const float nw = l[-width_ - 1], ne = l[-width_ + 1], sw = l[width_ - 1], se = l[width_ + 1];
  float dx = (sw + se) - (nw + ne), dy = (nw + sw) - (ne + se);
  const float reduce = std::max((nw + ne + sw + se) * kReduceFactor, kReduceLeast);
  const float scale = 1.0F / (std::min(std::abs(dx), std::abs(dy)) + reduce);
  dx = std::clamp(dx * scale, -kMaxSpan, kMaxSpan);
  dy = std::clamp(dy * scale, -kMaxSpan, kMaxSpan);

  const auto fx = static_cast<float>(x), fy = static_cast<float>(y);
  const Rgb a = sample(rgba, fx - dx / 6.0F, fy - dy / 6.0F), b = sample(rgba, fx + dx / 6.0F, fy + dy / 6.0F);
  const Rgb c = sample(rgba, fx - dx / 2.0F, fy - dy / 2.0F), d = sample(rgba, fx + dx / 2.0F, fy + dy / 2.0F);
  const Rgb near{(a.r + b.r) / 2.0F, (a.g + b.g) / 2.0F, (a.b + b.b) / 2.0F};
  const Rgb far{near.r / 2.0F + (c.r + d.r) / 4.0F, near.g / 2.0F + (c.g + d.g) / 4.0F,
                near.b / 2.0F + (c.b + d.b) / 4.0F};
  // The far taps left the edge if they bring a brightness that is not there.
  const float far_luma = luma(far.r, far.g, far.b);
  const float low = std::min({nw, ne, sw, se, static_cast<float>(*l)});
  const float high = std::max({nw, ne, sw, se, static_cast<float>(*l)});
  const Rgb& chosen = far_luma < low || far_luma > high ? near : far;
  out[0] = static_cast<std::uint8_t>(chosen.r + 0.5F);
  out[1] = static_cast<std::uint8_t>(chosen.g + 0.5F);
  out[2] = static_cast<std::uint8_t>(chosen.b + 0.5F);
}

/** Looks across both diagonals: an edge in any direction shows in one of them. */
void EdgeSmoother::smooth(const std::uint8_t* rgba, std::uint8_t* rgb) {
  split(rgba, rgb);
  for (int y = 1; y < height_ - 1; ++y) {
    const std::size_t row = static_cast<std::size_t>(y) * static_cast<std::size_t>(width_);
    const std::uint8_t* above = luma_.data() + row - static_cast<std::size_t>(width_);
    const std::uint8_t* below = luma_.data() + row + static_cast<std::size_t>(width_);
    for (int x = 1; x < width_ - 1; ++x) {
      const int falling = std::abs(above[x - 1] - below[x + 1]), rising = std::abs(above[x + 1] - below[x - 1]);
      if (falling > kThreshold || rising > kThreshold)
        smoothPixel(rgba, x, y, rgb + 3 * (row + static_cast<std::size_t>(x)));
    }
  }
}

}  // namespace raven2_trainer::render
