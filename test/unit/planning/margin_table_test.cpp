#include "planning/margin_table.h"

#include <gtest/gtest.h>

#include <cmath>

#include "raven2_trainer/core/random.h"

namespace raven2_trainer::planning {
namespace {

/** Changes by at most 0.5 per unit of a and by at most 0.2 per unit of b. */
double wavy(double a, double b) {
  return 0.5 * std::sin(a) + 0.2 * std::cos(b);
}

TEST(MarginTable, IsALowerBoundAndLosesNoMoreThanAStep) {
  const MarginTable table({-1.0, 2.0, 31, 0.5}, {0.0, 1.0, 11, 0.2}, wavy);
  Random random(1);
  const double step_loss = 0.5 * 0.1 + 0.2 * 0.1;
  for (int i = 0; i < 10000; ++i) {
    const double a = random.uniform(-1.0, 2.0), b = random.uniform(0.0, 1.0);
    ASSERT_LE(table.at(a, b), wavy(a, b));
    ASSERT_GE(table.at(a, b), wavy(a, b) - step_loss);
  }
}

TEST(MarginTable, OneNodeIsForWhatDoesNotMatter) {
  const MarginTable table({0.0, 1.0, 101, 1.0}, {}, [](double a, double /*b*/) { return a; });
  for (const double b : {-7.0, 0.0, 1e6})
    EXPECT_NEAR(table.at(0.5, b), 0.5 - 0.005, 1e-12);
}

TEST(MarginTable, RecallsWhatItWasToldUntilItForgets) {
  MarginTable memo({0.0, 1.0, 11, 0.5}, {0.0, 1.0, 11, 0.2}), full({0.0, 1.0, 11, 0.5}, {0.0, 1.0, 11, 0.2}, wavy);
  int asked = 0;
  const auto ask = [&asked](double a, double b) {
    ++asked;
    return wavy(a, b);
  };
  Random random(2);
  for (int i = 0; i < 5000; ++i) {
    const double a = random.uniform(0.0, 1.0), b = random.uniform(0.0, 1.0);
    ASSERT_EQ(memo.recall(a, b, ask), full.at(a, b));
  }
  EXPECT_EQ(asked, 11 * 11);
  memo.forget();
  memo.recall(0.5, 0.5, ask);
  EXPECT_EQ(asked, 11 * 11 + 1);
}

TEST(MarginTable, KnowsNothingBeyondItsEnds) {
  const MarginTable table({0.0, 1.0, 11, 1.0}, {0.0, 1.0, 11, 1.0}, wavy);
  EXPECT_TRUE(std::isfinite(table.at(0.0, 0.0)));
  for (const auto& [a, b] : {std::pair{-0.01, 0.5}, {1.01, 0.5}, {0.5, -0.01}, {0.5, 1.01}, {std::nan(""), 0.5}})
    EXPECT_EQ(table.at(a, b), -std::numeric_limits<double>::infinity());
  EXPECT_EQ(MarginTable().at(0.0, 0.0), -std::numeric_limits<double>::infinity());
}

}  // namespace
}  // namespace raven2_trainer::planning
