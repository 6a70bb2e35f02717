#include "raven2_trainer/wire/frame_delay.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "raven2_trainer/core/random.h"

namespace raven2_trainer::wire {
namespace {

constexpr std::int64_t kMs = 1'000'000;
constexpr std::int64_t kSecond = 1'000 * kMs;
constexpr std::int64_t kRounding = 1'000;  // [ns] of clocks and drift to whole nanoseconds, generously

/** A peer at 1 kHz with a separate clock; the test knows the true delay. */
struct Peer {
  /** @param[in] delay [ns] of this frame. @return the estimate. */
  std::int64_t frame(std::int64_t delay) {
    ++cycle;
    true_ns += kMs;
    return next(delay);
  }

  std::int64_t next(std::int64_t delay) {
    const double ran = static_cast<double>(true_ns - kSecond) * (1.0 + 1e-6 * ppm);
    return estimate.next(cycle, clock_start + static_cast<std::int64_t>(ran), true_ns + delay);
  }

  FrameDelay estimate;
  double ppm{0.0};                         ///< how much faster the peer's clock runs
  std::int64_t clock_start{77 * kSecond};  ///< far from ours
  std::int64_t true_ns{kSecond};           ///< our clock
  std::uint64_t cycle{0};
};

TEST(FrameDelay, IsZeroWhereNothingIsDelayed) {
  Peer peer;
  for (int i = 0; i < 30000; ++i)
    ASSERT_EQ(peer.frame(0), 0);
}

TEST(FrameDelay, IsTheTimeAboveTheQuickestFrame) {
  Peer peer;
  Random random(3);
  for (int i = 0; i < 1000; ++i)
    peer.frame(2 * kMs + static_cast<std::int64_t>(random.uniform(0.0, 1e6)));
  peer.frame(2 * kMs);
  EXPECT_NEAR(static_cast<double>(peer.frame(32 * kMs)), 30e6, 1e3);
  EXPECT_NEAR(static_cast<double>(peer.frame(2 * kMs + kMs / 2)), 0.5e6, 2e3);
}

TEST(FrameDelay, WhatWaitedInABufferIsAsOldAsItIs) {
  Peer peer;
  for (int i = 0; i < 5000; ++i)
    peer.frame(0);
  // WHEN the reader stops for 12 s, longer than the window, and then reads the frames of its first 100 ms
  for (int i = 0; i < 100; ++i) {
    const std::int64_t waited = 12 * kSecond - i * kMs;
    EXPECT_NEAR(static_cast<double>(peer.frame(waited)), static_cast<double>(waited), 0.1e6) << i;
  }
  // THEN the frames after that are fresh
  peer.true_ns += 12 * kSecond;
  EXPECT_EQ(peer.frame(0), 0);
}

TEST(FrameDelay, ASilenceDoesNotWearTheReferenceOut) {
  Peer peer;
  for (int i = 0; i < 1000; ++i)
    peer.frame(0);
  peer.true_ns += 60 * kSecond;
  EXPECT_NEAR(static_cast<double>(peer.frame(100 * kMs)), 100e6, 60e9 / FrameDelay::kDriftDivisor + 1e3);
}

TEST(FrameDelay, DriftOfTheClocksIsNoDelay) {
  for (const double ppm : {-200.0, -100.0, 100.0, 200.0}) {
    Peer peer;
    peer.ppm = ppm;
    for (int i = 0; i < 120000; ++i)
      ASSERT_LE(peer.frame(0), kRounding) << ppm << " ppm after " << i << " ms";
    // and a delay is found, at most kMaxErrorNs too small and never too large
    const std::int64_t found = peer.frame(50 * kMs);
    EXPECT_LE(found, 50 * kMs + kRounding) << ppm;
    EXPECT_GE(found, 50 * kMs - FrameDelay::kMaxErrorNs - kRounding) << ppm;
  }
}

TEST(FrameDelay, IsNeverTooLargeNorTooSmallByMoreThanItSays) {
  // GIVEN any drift, jitter and stalls of up to 3 s, and between these now and then a frame without delay
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Random random(seed);
    Peer peer;
    peer.ppm = random.uniform(-200.0, 200.0);
    std::int64_t stall = 0;
    for (int i = 0; i < 40000; ++i) {
      stall = i % 4000 == 2000 ? static_cast<std::int64_t>(random.uniform(0.0, 3e9)) : stall - kMs;
      const bool is_quick = i == 0 || (stall <= 0 && i % 50 == 0);
      const auto jitter = is_quick ? 0 : static_cast<std::int64_t>(random.uniform(0.0, 3e6));
      const std::int64_t delay = std::max<std::int64_t>(stall, 0) + jitter;
      const std::int64_t found = peer.frame(delay);
      ASSERT_LE(found, delay + kRounding) << "seed " << seed << " frame " << i;
      ASSERT_GE(found, delay - FrameDelay::kMaxErrorNs - kRounding) << "seed " << seed << " frame " << i;
    }
  }
}

TEST(FrameDelay, APeerThatStartedAnewIsMeasuredAnew) {
  Peer peer;
  for (int i = 0; i < 1000; ++i)
    peer.frame(0);
  peer.clock_start -= 70 * kSecond;  // its computer was started again: the clock is behind by 70 s
  EXPECT_EQ(peer.frame(0), 0);
  EXPECT_NEAR(static_cast<double>(peer.frame(3 * kMs)), 3e6, 1e3);
  peer.cycle = 0;  // its program was, on another computer with a clock still later
  peer.clock_start -= 500 * kMs;
  peer.true_ns += kSecond;
  EXPECT_EQ(peer.frame(0), 0);
}

TEST(FrameDelay, AClockThatStoodStillIsTrustedAgainAfterTheWindow) {
  Peer peer;
  for (int i = 0; i < 1000; ++i)
    peer.frame(0);
  peer.clock_start -= 500 * kMs;  // suspended for 0.5 s
  peer.true_ns += kSecond;
  std::int64_t late = 0;
  for (std::int64_t i = 0; i < 10001; ++i) {
    if (peer.frame(0) > 0) late = i + 1;
  }
  EXPECT_GT(late, 4900);
  EXPECT_LE(late * kMs, FrameDelay::kWindowNs);
}

TEST(FrameDelay, AnyStampIsTakenWithoutOverflow) {  // checked by the sanitizer build
  constexpr std::int64_t kLast = std::numeric_limits<std::int64_t>::max();
  FrameDelay estimate;
  std::int64_t now = 0;
  for (const std::int64_t stamp : {kLast, std::int64_t{0}, kLast, kLast, std::int64_t{1}, kLast / 2, kLast}) {
    EXPECT_GE(estimate.next(1, stamp, now += kSecond), 0);
  }
  Random random(9);
  for (int i = 0; i < 100000; ++i) {
    const auto stamp =
        static_cast<std::int64_t>(std::ldexp(random.uniform(0.5, 1.0), static_cast<int>(random.uniform(0, 63))));
    EXPECT_GE(estimate.next(static_cast<std::uint64_t>(i), stamp, now += kMs), 0);
  }
}

}  // namespace
}  // namespace raven2_trainer::wire
