#include "render/frame_source.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <stdexcept>

#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::render {
namespace {

constexpr std::size_t kBytes = 200'000;  // more than a pipe holds

/** Frame k holds nothing but k; frame `bad` cannot be drawn. */
MakeDrawFrame numbered(std::size_t bad = 1000) {
  return [bad]() -> DrawFrame {
    const auto pixels = std::make_shared<Pixels>(kBytes);
    return [pixels, bad](std::size_t k) -> const Pixels& {
      if (k == bad) throw std::runtime_error("frame cannot be drawn");
      std::fill(pixels->begin(), pixels->end(), static_cast<std::uint8_t>(k));
      return *pixels;
    };
  };
}

TEST(FrameSource, FramesComeInOrderFromAnyNumberOfProcesses) {
  for (const int processes : {1, 2, 3, 8}) {
    const auto source = makeFrameSource(20, kBytes, processes, numbered());
    for (std::size_t k = 0; k < 20; ++k) {
      ASSERT_EQ(source->next(), Pixels(kBytes, static_cast<std::uint8_t>(k))) << processes << " processes, frame " << k;
    }
  }
}

TEST(FrameSource, AProcessThatFailsIsAnException) {
  const auto source = makeFrameSource(20, kBytes, 2, numbered(5));
  for (std::size_t k = 0; k < 5; ++k)
    source->next();
  EXPECT_THROW(source->next(), RenderException);
}

TEST(FrameSource, EndsItsProcessesWhenItIsNoLongerNeeded) {
  // Waits for both processes, of which each still has frames to write: comes back only if they end.
  const auto source = makeFrameSource(200, kBytes, 2, numbered());
  source->next();
}

}  // namespace
}  // namespace raven2_trainer::render
