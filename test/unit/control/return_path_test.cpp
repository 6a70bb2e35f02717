#include "raven2_trainer/control/return_path.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace raven2_trainer::control {
namespace {

constexpr JointArray kFastest{0.5, 0.5, 0.07, 2.0, 2.0, 2.0, 2.0};
constexpr JointArray kHardest{2.0, 2.0, 0.5, 10.0, 10.0, 10.0, 10.0};
constexpr JointArray kHere{0.5, 1.5, 0.40, 0.1, 0.0, 0.7, 0.8};
constexpr JointArray kThere{0.8, 1.2, 0.43, 0.4, 0.5, 0.2, 0.9};
constexpr JointArray kNear{0.51, 1.5, 0.40, 0.1, 0.0, 0.7, 0.8};

TEST(ReturnPath, BothArmsArriveTogetherAndExactly) {
  ReturnPath path(kFastest, kHardest);
  path.start({kHere, kHere}, {kThere, kNear});
  PerArm<JointArray> q{};
  int ticks = 0;
  for (; !path.isOver(); ++ticks) {
    if (ticks > 0) {
      EXPECT_NE(at(q, Arm::kGold), kThere);
    }
    q = path.tick();
  }
  EXPECT_EQ(at(q, Arm::kGold), kThere);
  EXPECT_EQ(at(q, Arm::kGreen), kNear);
  EXPECT_EQ(ticks, static_cast<int>(std::ceil(path.duration() * 1000.0)));
  // 0.3 rad at a peak of 15/8 of the mean and at most 0.5 rad/s
  EXPECT_NEAR(path.duration(), 15.0 / 8.0 * 0.3 / 0.5, 1e-12);
  EXPECT_EQ(path.tick()[0], kThere) << "and stays there";
}

TEST(ReturnPath, KeepsItsLimitsFromRestToRest) {
  ReturnPath path(kFastest, kHardest);
  path.start({kHere, kHere}, {kThere, kNear});
  PerArm<JointArray> before{kHere, kHere};
  JointArray rate_before{};
  double fastest = 0.0, hardest = 0.0;
  while (!path.isOver()) {
    const PerArm<JointArray> q = path.tick();
    for (std::size_t j = 0; j < kJointCount; ++j) {
      const double rate = (q[0][j] - before[0][j]) * 1000.0;
      fastest = std::max(fastest, std::abs(rate) / kFastest[j]);
      hardest = std::max(hardest, std::abs(rate - rate_before[j]) * 1000.0 / kHardest[j]);
      rate_before[j] = rate;
    }
    before = q;
  }
  EXPECT_GT(fastest, 0.99) << "as fast as it may";
  EXPECT_LE(fastest, 1.0 + 1e-9);
  EXPECT_LE(hardest, 1.0 + 1e-9);
  for (std::size_t j = 0; j < kJointCount; ++j)
    EXPECT_LT(std::abs(rate_before[j]), 1e-3 * kFastest[j]) << "at rest";
}

TEST(ReturnPath, TakesTheTimeOfTheSlowerArmWhicheverThatIs) {
  for (const Arm slower : kArms) {
    ReturnPath path(kFastest, kHardest);
    PerArm<JointArray> to{kNear, kNear};
    at(to, slower) = kThere;
    path.start({kHere, kHere}, to);
    EXPECT_NEAR(path.duration(), 15.0 / 8.0 * 0.3 / 0.5, 1e-12) << name(slower);
  }
}

TEST(ReturnPath, AnotherStartIsAsTheFirst) {
  ReturnPath used(kFastest, kHardest), fresh(kFastest, kHardest);
  used.start({kHere, kHere}, {kThere, kNear});
  for (int i = 0; i < 700; ++i)
    used.tick();
  for (ReturnPath* path : {&used, &fresh})
    path->start({kNear, kThere}, {kHere, kHere});
  EXPECT_FALSE(used.isOver());
  EXPECT_EQ(used.goal()[1], kHere);
  while (!fresh.isOver())
    ASSERT_EQ(used.tick(), fresh.tick());
  EXPECT_TRUE(used.isOver());
}

TEST(ReturnPath, HasNothingToDoWhereItIs) {
  ReturnPath path(kFastest, kHardest);
  EXPECT_TRUE(path.isOver());
  path.start({kHere, kThere}, {kHere, kThere});
  EXPECT_TRUE(path.isOver());
  EXPECT_EQ(path.tick()[1], kThere);
}

}  // namespace
}  // namespace raven2_trainer::control
