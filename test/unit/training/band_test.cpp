#include "raven2_trainer/training/band.h"

#include <limits>

#include "gtest/gtest.h"

namespace raven2_trainer::training {
namespace {

BandMetric makeMetric(double mean, double deviation, Better better = Better::kLower, double least = 0.0) {
  return {"time", mean, deviation, better, least};
}

TEST(Band, GrantsTheGreatestOfItsThreeSpreads) {
  EXPECT_EQ(judge(0.0, makeMetric(40.0, 12.0, Better::kLower, 5.0), 0.25, 1.0).spread, 12.0);
  EXPECT_EQ(judge(0.0, makeMetric(80.0, 12.0, Better::kLower, 5.0), 0.25, 1.0).spread, 20.0);
  EXPECT_EQ(judge(0.0, makeMetric(-80.0, 12.0, Better::kLower, 5.0), 0.25, 1.0).spread, 20.0);
  EXPECT_EQ(judge(0.0, makeMetric(4.0, 1.2, Better::kLower, 5.0), 0.25, 1.0).spread, 5.0);
}

TEST(Band, GrantsNoShareOfALogarithm) {
  const BandMetric ldlj{"ldlj", -24.0, 0.1, Better::kHigher, 0.6931};
  EXPECT_EQ(judge(-24.0, ldlj, 0.25, 1.0).spread, 0.6931);  // a quarter of it would be a jerk 400 times as great
  EXPECT_TRUE(judge(-24.6, ldlj, 0.25, 1.0).passed);
  EXPECT_FALSE(judge(-24.8, ldlj, 0.25, 1.0).passed);
}

TEST(Band, PassesUpToItsLimitWhereLowerIsBetter) {
  const BandMetric metric = makeMetric(40.0, 12.0);
  EXPECT_EQ(judge(0.0, metric, 0.0, 1.0).limit, 52.0);
  EXPECT_TRUE(judge(52.0, metric, 0.0, 1.0).passed);
  EXPECT_FALSE(judge(52.01, metric, 0.0, 1.0).passed);
  EXPECT_TRUE(judge(-1000.0, metric, 0.0, 1.0).passed);
  EXPECT_EQ(judge(0.0, metric, 0.0, 2.0).limit, 64.0);
}

TEST(Band, PassesDownToItsLimitWhereHigherIsBetter) {
  const BandMetric metric = makeMetric(-3.0, 0.5, Better::kHigher);
  EXPECT_EQ(judge(0.0, metric, 0.0, 1.0).limit, -3.5);
  EXPECT_TRUE(judge(-3.5, metric, 0.0, 1.0).passed);
  EXPECT_FALSE(judge(-3.51, metric, 0.0, 1.0).passed);
  EXPECT_TRUE(judge(0.0, metric, 0.0, 1.0).passed);
}

TEST(Band, TellsByHowManySpreadsAValueIsBeyondItsLimit) {
  const BandMetric lower = makeMetric(40.0, 10.0), higher = makeMetric(40.0, 10.0, Better::kHigher);
  EXPECT_DOUBLE_EQ(judge(75.0, lower, 0.0, 1.0).excess, 2.5);
  EXPECT_DOUBLE_EQ(judge(45.0, lower, 0.0, 1.0).excess, -0.5);
  EXPECT_DOUBLE_EQ(judge(5.0, higher, 0.0, 1.0).excess, 2.5);
}

TEST(Band, ACountThatIsAlwaysZeroMayBeItsLeastWhateverIsGranted) {
  const BandMetric drops = makeMetric(0.0, 0.0);
  EXPECT_TRUE(judge(0.0, drops, 0.25, 3.0).passed);
  EXPECT_FALSE(judge(1.0, drops, 0.25, 3.0).passed);
  EXPECT_GT(judge(1.0, drops, 0.25, 3.0).excess, 1e8);
  const BandMetric touches = makeMetric(0.0, 0.0, Better::kLower, 2.0);
  EXPECT_TRUE(judge(2.0, touches, 0.25, 3.0).passed);
  EXPECT_FALSE(judge(3.0, touches, 0.25, 3.0).passed);
}

TEST(Band, AValueThatIsNotFiniteDoesNotPass) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(judge(nan, makeMetric(1.0, 1.0), 0.25, 1.0).passed);
  EXPECT_GT(judge(nan, makeMetric(1.0, 1.0), 0.25, 1.0).excess, 1e8);
  EXPECT_FALSE(judge(std::numeric_limits<double>::infinity(), makeMetric(1.0, 1.0), 0.25, 1.0).passed);
}

TEST(Band, AnAbsoluteLimitGrantsNoSpread) {
  EXPECT_TRUE(judgeByLimit(5.0, 5.0, Better::kLower).passed);
  EXPECT_FALSE(judgeByLimit(5.1, 5.0, Better::kLower).passed);
  EXPECT_FALSE(judgeByLimit(4.9, 5.0, Better::kHigher).passed);
  EXPECT_DOUBLE_EQ(judgeByLimit(7.5, 5.0, Better::kLower).excess, 0.5);
  EXPECT_DOUBLE_EQ(judgeByLimit(-6.0, -5.0, Better::kHigher).excess, 0.2);
  EXPECT_GT(judgeByLimit(1.0, 0.0, Better::kLower).excess, 1e8);
  EXPECT_FALSE(judgeByLimit(std::numeric_limits<double>::quiet_NaN(), 5.0, Better::kLower).passed);
}

TEST(Band, FindsItsMetricsByName) {
  Band band;
  band.metrics = {makeMetric(1.0, 1.0)};
  EXPECT_EQ(find(band, "time"), &band.metrics[0]);
  EXPECT_EQ(find(band, "path"), nullptr);
}

}  // namespace
}  // namespace raven2_trainer::training
