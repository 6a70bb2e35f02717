#include "raven2_trainer/wire/token_bucket.h"

#include <gtest/gtest.h>

namespace raven2_trainer::wire {
namespace {

int taken(TokenBucket* bucket, int offered, std::int64_t from_ns, std::int64_t step_ns) {
  int count = 0;
  for (int i = 0; i < offered; ++i)
    count += bucket->take(from_ns + i * step_ns) ? 1 : 0;
  return count;
}

TEST(TokenBucket, GivesTheBurstAtOnceAndNoMore) {
  TokenBucket bucket(1200, 40);
  EXPECT_EQ(taken(&bucket, 1000, 0, 0), 40);
}

TEST(TokenBucket, TenTimesTheRateForTenSecondsGivesRateTimesTimePlusBurst) {
  TokenBucket bucket(1200, 40);
  EXPECT_NEAR(taken(&bucket, 100000, 0, 100000), 12000 + 40, 1);
}

TEST(TokenBucket, AnHonestMasterLosesNothing) {
  TokenBucket bucket(1200, 40);
  EXPECT_EQ(taken(&bucket, 60000, 0, 1000000), 60000);
}

TEST(TokenBucket, TimeThatGoesBackGivesNothing) {
  TokenBucket bucket(1000, 2);
  EXPECT_EQ(taken(&bucket, 10, 1000000000, 0), 2);
  EXPECT_EQ(taken(&bucket, 10, 0, 0), 0);
  EXPECT_EQ(taken(&bucket, 10, 1000000000, 0), 0);
  EXPECT_EQ(taken(&bucket, 10, 1001000000, 0), 1);
}

}  // namespace
}  // namespace raven2_trainer::wire
