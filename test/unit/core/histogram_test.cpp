#include "raven2_trainer/core/histogram.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "raven2_trainer/core/random.h"

namespace raven2_trainer {
namespace {

TEST(Histogram, EveryDurationLiesWithinItsBucket) {
  for (std::int64_t ns = 1; ns < std::int64_t{1} << 30; ns += 1 + ns / 97) {
    const std::size_t bucket = Histogram::bucketOf(ns);
    ASSERT_LT(bucket, Histogram::kBuckets);
    if (bucket > 0) {
      ASSERT_GE(ns, Histogram::upperEdge(bucket - 1)) << ns;
    }
    if (bucket < Histogram::kBuckets - 1) {
      ASSERT_LT(ns, Histogram::upperEdge(bucket)) << ns;
    }
  }
}

TEST(Histogram, BucketsAreAtMostAnEighthOfTheirDurationWide) {
  for (std::size_t i = 1; i + 1 < Histogram::kBuckets; ++i) {
    const double from = static_cast<double>(Histogram::upperEdge(i - 1));
    EXPECT_LE(static_cast<double>(Histogram::upperEdge(i)), 1.125 * from);
    EXPECT_GT(Histogram::upperEdge(i), Histogram::upperEdge(i - 1));
  }
}

TEST(Histogram, QuantilesAreThoseOfTheSortedDurationsOrUpToAnEighthMore) {
  Random random(7);
  Histogram histogram;
  std::vector<std::int64_t> sorted;
  for (int i = 0; i < 10000; ++i) {
    sorted.push_back(static_cast<std::int64_t>(std::exp(random.uniform(std::log(500.0), std::log(1e8)))));
    histogram.add(sorted.back());
  }
  std::sort(sorted.begin(), sorted.end());
  for (const double p : {0.001, 0.5, 0.9, 0.99, 0.999, 1.0}) {
    const auto exact = static_cast<double>(sorted[static_cast<std::size_t>(std::ceil(p * 10000)) - 1]);
    EXPECT_GE(static_cast<double>(histogram.quantile(p)), exact) << p;
    EXPECT_LE(static_cast<double>(histogram.quantile(p)), 1.126 * exact) << p;
  }
  EXPECT_EQ(histogram.total(), 10000U);
}

TEST(Histogram, WhatIsTooShortOrTooLongIsCountedAtTheEnds) {
  Histogram histogram;
  EXPECT_EQ(histogram.quantile(0.5), 0);
  histogram.add(-5);
  histogram.add(0);
  histogram.add(std::int64_t{1} << 40);
  EXPECT_EQ(histogram.counts.front(), 2U);
  EXPECT_EQ(histogram.counts.back(), 1U);
  EXPECT_EQ(histogram.quantile(0.5), 256);
  EXPECT_EQ(histogram.quantile(1.0), std::int64_t{1} << 28);
}

}  // namespace
}  // namespace raven2_trainer
