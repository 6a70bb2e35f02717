#include "raven2_trainer/wire/replay_window.h"

#include <gtest/gtest.h>

#include <set>

#include "raven2_trainer/core/random.h"

namespace raven2_trainer::wire {
namespace {

TEST(ReplayWindow, TakesEachNumberOnceAndNoneFartherBackThan63) {
  ReplayWindow window;
  window.mark(1000);
  EXPECT_FALSE(window.isFresh(1000));
  EXPECT_TRUE(window.isFresh(1001));
  EXPECT_TRUE(window.isFresh(1000 - 63));
  EXPECT_FALSE(window.isFresh(1000 - 64));
  window.mark(950);
  EXPECT_FALSE(window.isFresh(950));
  EXPECT_EQ(window.newest(), 1000U);
  EXPECT_TRUE(window.isFresh(951));
}

TEST(ReplayWindow, ReachesTheEndsOfTheCounter) {
  ReplayWindow window;
  EXPECT_TRUE(window.isFresh(0));
  window.mark(0);
  EXPECT_FALSE(window.isFresh(0));
  window.mark(~std::uint64_t{0});
  EXPECT_FALSE(window.isFresh(~std::uint64_t{0}));
  EXPECT_FALSE(window.isFresh(0)) << "it does not wrap";
  EXPECT_TRUE(window.isFresh(~std::uint64_t{0} - 63));
}

TEST(ReplayWindow, AgreesWithASetOfAllThatWasSeen) {
  ReplayWindow window;
  std::set<std::uint64_t> seen;
  Random random(3);
  std::uint64_t base = 100;
  for (int i = 0; i < 20000; ++i) {
    base += random.next() % 3;
    const std::uint64_t counter = base - random.next() % 90;
    const std::uint64_t newest = seen.empty() ? 0 : *seen.rbegin();
    const bool expected = seen.empty() || (seen.count(counter) == 0 && counter + 64 > newest);
    ASSERT_EQ(window.isFresh(counter), expected) << i;
    if (!expected) continue;
    window.mark(counter);
    seen.insert(counter);
  }
}

}  // namespace
}  // namespace raven2_trainer::wire
