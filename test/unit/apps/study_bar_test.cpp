#include "apps/common/study_bar.h"

#include <gtest/gtest.h>

#include <limits>

namespace raven2_trainer::apps {
namespace {

TEST(TimeLeft, IsWhatTheRestTakesAtTheSameSpeed) {
  EXPECT_EQ(timeLeft(10.0, 0.5, 0.5), "10 s left");
  EXPECT_EQ(timeLeft(10.0, 200.0, 3000.0), "2 min 30 s left") << "of any unit";
  EXPECT_EQ(timeLeft(3600.0, 1.0, 9.5), "9 h 30 min left");
  EXPECT_EQ(timeLeft(10.0, 1.0, 0.0), "0 s left");
}

TEST(TimeLeft, WhatWasThereBeforeCountsNeitherAsDoneNorAsLeft) {
  // Nine tenths were done before the start. Half of the last tenth took 30 s.
  const double share = 0.95, found = 0.9;
  EXPECT_EQ(timeLeft(30.0, share - found, 1.0 - share).substr(0, 2), "30");
}

TEST(TimeLeft, IsNotToldWhereNothingCanBeSaid) {
  EXPECT_EQ(timeLeft(2.0, 0.1, 0.9), "") << "the first frames compile shaders";
  EXPECT_EQ(timeLeft(10.0, 0.0, 1.0), "");
  EXPECT_EQ(timeLeft(10.0, -0.1, 1.0), "");
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(timeLeft(10.0, nan, nan), "");
  EXPECT_EQ(timeLeft(10.0, 1e-300, 1e300).substr(0, 6), "277777") << "no overflow";
}

}  // namespace
}  // namespace raven2_trainer::apps
