#include "render/edge_smoother.h"

#include <algorithm>
#include <cstring>

namespace raven2_trainer::render {

namespace {

constexpr int kThreshold = 20;    // [1/255] of brightness across a diagonal; below it no edge is seen
constexpr float kMaxSpan = 4.0F;  // [px] farthest tap along an edge
constexpr float kNear = 1.0F / 6.0F, kFar = 1.0F / 2.0F;  // of such a span: where the taps are
constexpr int kReduce = 32;      // the mean brightness over it shortens spans where little changes
constexpr int kReduceLeast = 2;  // [1/255]

// Places are counted in 1/64 px. A bilinear tap is a sum of weights 4096, so that red, green and blue of two taps fit
// side by side, in 21 bits each, in one word.
constexpr int kPlaceBits = 6;
constexpr int kPlace = 1 << kPlaceBits;
constexpr int kLane = 21;
constexpr int kTwoTapsBits = 2 * kPlaceBits + 1;
constexpr std::uint64_t kAllHalves = ~(std::uint64_t{1} << (kLane - 1) | std::uint64_t{1} << (2 * kLane - 1));

/** Red, green and blue in a lane each. */
std::uint64_t spread(const std::uint8_t* rgba) noexcept {
  return std::uint64_t{rgba[0]} | std::uint64_t{rgba[1]} << kLane | std::uint64_t{rgba[2]} << (2 * kLane);
}

/** Of lanes that hold two taps. */
int channel(std::uint64_t taps, int i) noexcept {
  const auto lane = static_cast<int>(taps >> (i * kLane) & ((std::uint64_t{1} << kLane) - 1));
  return (lane + (1 << (kTwoTapsBits - 1))) >> kTwoTapsBits;
}

std::uint64_t halved(std::uint64_t taps) noexcept {
  return taps >> 1 & kAllHalves;
}

std::uint8_t luma(int r, int g, int b) noexcept {
  return static_cast<std::uint8_t>(static_cast<std::uint16_t>(77 * r + 150 * g + 29 * b) >> 8);
}

/** [1/64 px] of a tap at so much of a step [px] along an edge. */
int toPlace(float step, float share) noexcept {
  constexpr int kLong = 1 << 20;  // above zero, conversion rounds all numbers alike
  const int place = static_cast<int>(step * (share * kPlace) + (kLong + 0.5F)) - kLong;
  const int most = static_cast<int>(kMaxSpan * share * kPlace + 0.5F);
  return std::min(std::max(place, -most), most);
}

}  // namespace

EdgeSmoother::EdgeSmoother(int width, int height)
    : width_(width),
      height_(height),
      luma_(index(0, height) + 2 * kBlock),
      edges_(static_cast<std::size_t>(width) + kBlock, 0) {}

/** Drops the alpha and notes the brightness. */
void EdgeSmoother::splitRow(const std::uint8_t* rgba, int y, std::uint8_t* rgb) noexcept {
  const auto width = static_cast<std::size_t>(width_);
  const std::uint8_t* from = rgba + 4 * index(0, y);
  std::uint8_t* to = rgb + 3 * index(0, y);
  std::uint8_t* l = &luma_[index(0, y)];
  for (std::size_t i = 0; i < width; ++i)
    l[i] = luma(from[4 * i], from[4 * i + 1], from[4 * i + 2]);
  for (std::size_t i = 0; i + 1 < width; ++i)
    std::memcpy(to + 3 * i, from + 4 * i, 4);  // the next pixel takes the alpha's place
  std::memcpy(to + 3 * (width - 1), from + 4 * (width - 1), 3);
}

/** Bilinear, clamped at the border; @param[in] x, y [1/64 px]. */
std::uint64_t EdgeSmoother::sample(const std::uint8_t* rgba, int x, int y) const noexcept {
  x = std::clamp(x, 0, (width_ - 1) * kPlace);
  y = std::clamp(y, 0, (height_ - 1) * kPlace);
  const int x0 = std::min(x >> kPlaceBits, width_ - 2), y0 = std::min(y >> kPlaceBits, height_ - 2);
  const auto fx = static_cast<std::uint64_t>(x - x0 * kPlace), fy = static_cast<std::uint64_t>(y - y0 * kPlace);
  const std::uint8_t* p = rgba + 4 * index(x0, y0);
  const std::uint8_t* q = p + 4 * static_cast<std::size_t>(width_);
  return (kPlace - fy) * ((kPlace - fx) * spread(p) + fx * spread(p + 4)) +
         fy * ((kPlace - fx) * spread(q) + fx * spread(q + 4));
}

/** Along the edge at each of kBlock pixels in a row: square to the steepest change of brightness. */
EdgeSmoother::Steps EdgeSmoother::stepsAt(int x, int y) const noexcept {
  const std::uint8_t* above = &luma_[index(x, y - 1)];
  const std::uint8_t* below = &luma_[index(x, y + 1)];
  float x_step[kBlock], y_step[kBlock], least[kBlock];
  for (int i = 0; i < kBlock; ++i) {
    const int nw = above[i - 1], ne = above[i + 1], sw = below[i - 1], se = below[i + 1];
    const int dx = (sw + se) - (nw + ne), dy = (nw + sw) - (ne + se);
    const int x_size = std::max(dx, -dx), y_size = std::max(dy, -dy);
    x_step[i] = static_cast<float>(kReduce * dx);
    y_step[i] = static_cast<float>(kReduce * dy);
    const int reduce = std::max(nw + ne + sw + se, kReduceLeast * kReduce);
    least[i] = static_cast<float>(kReduce * std::min(x_size, y_size) + reduce);
  }
  Steps steps;
  for (int i = 0; i < kBlock; ++i) {
    const float x_px = x_step[i] / least[i], y_px = y_step[i] / least[i];
    steps.near_x[i] = toPlace(x_px, kNear);
    steps.near_y[i] = toPlace(y_px, kNear);
    steps.far_x[i] = toPlace(x_px, kFar);
    steps.far_y[i] = toPlace(y_px, kFar);
  }
  return steps;
}

/** To either side of a pixel. */
std::uint64_t EdgeSmoother::twoTaps(const std::uint8_t* rgba, int x, int y, int u, int v) const noexcept {
  return sample(rgba, x * kPlace - u, y * kPlace - v) + sample(rgba, x * kPlace + u, y * kPlace + v);
}

void EdgeSmoother::smoothPixel(const std::uint8_t* rgba, int x, int y, const Steps& steps, int i, std::uint8_t* out)
    const noexcept {
  const std::uint64_t near = twoTaps(rgba, x, y, steps.near_x[i], steps.near_y[i]);
  const std::uint64_t far = halved(near) + halved(twoTaps(rgba, x, y, steps.far_x[i], steps.far_y[i]));
  // The far taps left the edge if they bring a brightness that is not there.
  const int far_luma = luma(channel(far, 0), channel(far, 1), channel(far, 2));
  const std::uint8_t* l = &luma_[index(x, y)];
  const int nw = l[-width_ - 1], ne = l[-width_ + 1], sw = l[width_ - 1], se = l[width_ + 1];
  const int low = std::min({nw, ne, sw, se, int{*l}}), high = std::max({nw, ne, sw, se, int{*l}});
  const std::uint64_t chosen = far_luma < low || far_luma > high ? near : far;
  for (int k = 0; k < 3; ++k)
    out[k] = static_cast<std::uint8_t>(channel(chosen, k));
}

/** Looks across both diagonals: an edge in any direction shows in one of them. */
void EdgeSmoother::findEdges(int y) noexcept {
  const std::uint8_t* above = &luma_[index(1, y - 1)];
  const std::uint8_t* below = &luma_[index(1, y + 1)];
  std::uint8_t* edge = edges_.data();
  const auto difference = [](std::uint8_t a, std::uint8_t b) {
    return static_cast<std::uint8_t>(std::max(a, b) - std::min(a, b));
  };
  const int count = width_ - 2;
  for (int i = 0; i < count; ++i) {
    const std::uint8_t falling = difference(above[i - 1], below[i + 1]),
                       rising = difference(above[i + 1], below[i - 1]);
    edge[i] = std::max(falling, rising) > kThreshold ? 1 : 0;
  }
}

void EdgeSmoother::smoothRow(const std::uint8_t* rgba, int y, std::uint8_t* rgb) const noexcept {
  for (int first = 1; first < width_ - 1; first += kBlock) {
    const std::uint8_t* edge = &edges_[static_cast<std::size_t>(first - 1)];
    std::uint64_t any = 0;
    static_assert(sizeof any == kBlock);
    std::memcpy(&any, edge, sizeof any);
    if (any == 0) continue;
    const Steps steps = stepsAt(first, y);
    for (int i = 0; i < kBlock; ++i) {
      if (edge[i] != 0) smoothPixel(rgba, first + i, y, steps, i, rgb + 3 * index(first + i, y));
    }
  }
}

void EdgeSmoother::smooth(const std::uint8_t* rgba, std::uint8_t* rgb) {
  splitRow(rgba, 0, rgb);
  if (height_ > 1) splitRow(rgba, 1, rgb);
  for (int y = 1; y < height_ - 1; ++y) {
    splitRow(rgba, y + 1, rgb);
    findEdges(y);
    smoothRow(rgba, y, rgb);
  }
}

}  // namespace raven2_trainer::render
