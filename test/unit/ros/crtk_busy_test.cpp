#include "ros/crtk/crtk_busy.h"

#include <gtest/gtest.h>

namespace raven2_trainer::ros_bridge {
namespace {

TEST(CrtkBusy, IsWhatTheArmIs) {
  CrtkBusy busy;
  EXPECT_FALSE(busy.of(false, 7, 1000)) << "moves of the time before it looked";
  EXPECT_TRUE(busy.of(true, 8, 1010));
  EXPECT_TRUE(busy.of(true, 8, 3000));
  EXPECT_FALSE(busy.of(false, 8, 3010));
}

TEST(CrtkBusy, ShowsAMoveThatWasOverBeforeItLooked) {
  CrtkBusy busy;
  EXPECT_FALSE(busy.of(false, 0, 1000));
  EXPECT_TRUE(busy.of(false, 1, 1500)) << "begun and ended in half a second in which nobody looked";
  EXPECT_TRUE(busy.of(false, 1, 1549));
  EXPECT_FALSE(busy.of(false, 1, 1550));
  EXPECT_TRUE(busy.of(false, 2, 1560)) << "another one";
}

TEST(CrtkBusy, ShowsAMoveThatFollowedAnother) {
  CrtkBusy busy;
  EXPECT_FALSE(busy.of(false, 0, 1000));
  EXPECT_TRUE(busy.of(true, 1, 1010));
  EXPECT_TRUE(busy.of(false, 2, 2000)) << "the second began and ended since";
  EXPECT_FALSE(busy.of(false, 2, 2050));
}

TEST(CrtkBusy, ForgetsWhenTheLoopStartsAgain) {
  CrtkBusy busy;
  EXPECT_FALSE(busy.of(false, 0, 100'000));
  EXPECT_TRUE(busy.of(false, 1, 100'010));
  EXPECT_FALSE(busy.of(false, 1, 5));
}

}  // namespace
}  // namespace raven2_trainer::ros_bridge
