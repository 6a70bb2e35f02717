#include "raven2_trainer/core/counters.h"

#include <gtest/gtest.h>

#include "raven2_trainer/core/random.h"

namespace raven2_trainer {
namespace {

TEST(LinkCounts, AlwaysAddUp) {
  LinkCounts counts;
  Random random(5);
  for (int i = 0; i < 10000; ++i)
    counts.count(static_cast<Reject>(random.next() % kRejectCount));
  EXPECT_TRUE(counts.addsUp());
  EXPECT_EQ(counts.received, 10000U);
  EXPECT_EQ(counts.rejected[0], 0U);
}

TEST(Random, IsThePublishedPcg32) {
  // First outputs of pcg32_srandom(42, 54) of the reference implementation's demo (www.pcg-random.org, pcg32-demo).
  Random random(42, 54);
  for (const std::uint32_t expected : {0xa15c02b7U, 0x7b47f409U, 0xba1d3330U, 0x83d2f293U, 0xbfa4784bU, 0xcbed606eU}) {
    EXPECT_EQ(random.next(), expected);
  }
}

TEST(Random, NormalHasMeanZeroAndDeviationOne) {
  Random random(3);
  double sum = 0, squares = 0;
  constexpr int kCount = 100000;
  for (int i = 0; i < kCount; ++i) {
    const double x = random.normal();
    sum += x;
    squares += x * x;
  }
  EXPECT_NEAR(sum / kCount, 0.0, 0.02);
  EXPECT_NEAR(squares / kCount, 1.0, 0.02);
}

}  // namespace
}  // namespace raven2_trainer
