#include "raven2_trainer/core/spsc_ring.h"

#include <gtest/gtest.h>

namespace raven2_trainer {
namespace {

TEST(SpscRing, KeepsOrderAndCountsWhatItDrops) {
  SpscRing<int, 4> ring;
  for (int i = 0; i < 4; ++i)
    EXPECT_TRUE(ring.tryPush(i));
  EXPECT_FALSE(ring.tryPush(99));
  EXPECT_EQ(ring.dropped(), 1U);
  int value = -1;
  for (int i = 0; i < 4; ++i) {
    ASSERT_TRUE(ring.tryPop(&value));
    EXPECT_EQ(value, i);
  }
  EXPECT_FALSE(ring.tryPop(&value));
  EXPECT_EQ(value, 3) << "an empty ring leaves the element alone";
}

TEST(SpscRing, WrapsForEver) {
  SpscRing<int, 4> ring;
  int value = 0;
  for (int i = 0; i < 1000; ++i) {
    ASSERT_TRUE(ring.tryPush(i));
    ASSERT_TRUE(ring.tryPop(&value));
    ASSERT_EQ(value, i);
  }
}

}  // namespace
}  // namespace raven2_trainer
