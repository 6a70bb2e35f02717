#include "console/tool_hand.h"

#include <gtest/gtest.h>

#include "console_support.h"

namespace raven2_trainer::console {
namespace {

/** A tool that follows a hand's increments exactly, from wherever it is. */
struct Follower {
  void follow(const ToolHand& hand, Tick now, bool counts) {
    const Vector3 p_I = toEigen(hand.position(now));
    const Quaternion q_I = toEigen(hand.turn(now));
    if (counts) {
      X_WT.p += 0.1 * worldToItp(p_I - last_p);  // the scale of testConfig
      const Eigen::AngleAxisd step(q_I * last_q.conjugate());
      X_WT.R = Eigen::AngleAxisd(step.angle(), worldToItp(step.axis())) * X_WT.R;
    }
    last_p = p_I;
    last_q = q_I;
  }
  Pose X_WT;
  Vector3 last_p{0, 0, 0};
  Quaternion last_q{Quaternion::Identity()};
};

Pose pose(double angle, const Vector3& axis, const Vector3& p) {
  return {Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix(), p};
}

class ToolHandTest : public ::testing::Test {
 protected:
  void SetUp() override {
    tool_.X_WT = start_;
    hand_.takeUp(start_);
  }
  void run(Tick ticks, bool counts = true) {
    for (Tick i = 0; i < ticks; ++i)
      tool_.follow(hand_, ++now_, counts);
  }
  void expectAt(const Pose& wanted) const {
    EXPECT_NEAR(errorOf(tool_.X_WT, wanted).distance, 0.0, 1e-9);
    EXPECT_NEAR(errorOf(tool_.X_WT, wanted).angle, 0.0, 1e-7);
  }

  const Pose start_ = pose(0.7, {1, 2, 3}, {0.01, 0.02, 0.06});
  const Pose there_ = pose(-1.1, {2, -1, 0.5}, {0.03, -0.01, 0.04});
  Random random_{1};
  ToolHand hand_{testConfig(), /*shaking=*/0.0, /*opening=*/1.0, &random_};
  Follower tool_;
  Tick now_{0};
};

TEST_F(ToolHandTest, LeadsTheToolToWhereItIsWanted) {
  hand_.move(now_, there_, 800);
  run(400);
  EXPECT_NEAR(errorOf(tool_.X_WT, start_).distance, 0.5 * errorOf(there_, start_).distance, 1e-6) << "halfway";
  run(400);
  expectAt(there_);
}

TEST_F(ToolHandTest, ComesBackToItsMiddleWithoutTheTool) {
  hand_.move(now_, there_, 500);
  run(500);
  EXPECT_NEAR(hand_.stretch(now_, there_), 10.0 * (there_.p - start_.p).norm(), 1e-9);
  hand_.comeBack(now_, 300);
  run(400, /*counts=*/false);
  EXPECT_NEAR(toEigen(hand_.position(now_)).norm(), 0.0, 1e-12);
  EXPECT_NEAR(toEigen(hand_.turn(now_)).vec().norm(), 0.0, 1e-9);
  expectAt(there_);
  hand_.move(now_, start_, 500);
  run(500);
  expectAt(start_);
}

TEST_F(ToolHandTest, MovesSomethingElse) {
  const Vector3 by_I(0.004, -0.003, 0.002);
  const Vector3 before = toEigen(hand_.position(now_));
  hand_.moveHand(now_, by_I, 300);
  run(300, /*counts=*/false);
  EXPECT_NEAR((toEigen(hand_.position(now_)) - before - 10.0 * by_I).norm(), 0.0, 1e-12);
  hand_.move(now_, there_, 300);
  run(300);
  expectAt(there_);
}

TEST_F(ToolHandTest, BringsAToolThatWentElsewhereBackToWhereItWasWanted) {
  hand_.move(now_, there_, 500);
  run(500);
  tool_.X_WT = pose(0.2, {0, 1, 0}, {0.001, 0.002, -0.001}) * there_;
  hand_.rebase(now_, tool_.X_WT, 200);
  run(200);
  expectAt(there_);
}

TEST_F(ToolHandTest, AsksForMoreWhereTheToolStaysBehind) {
  // GIVEN a tool that always hangs 1.5 mm low and is 0.05 rad off
  const Pose sag = pose(0.05, {1, 0, 0}, {0.0, 0.0, -0.0015});
  const auto seen = [&] { return Pose{sag.R * tool_.X_WT.R, tool_.X_WT.p + sag.p}; };
  hand_.move(now_, there_, 500);
  run(500);
  hand_.correct(now_, seen(), 200);
  run(200);
  EXPECT_NEAR(errorOf(seen(), there_).distance, 0.0, 1e-9);
  EXPECT_NEAR(errorOf(seen(), there_).angle, 0.0, 1e-7);
  EXPECT_EQ(hand_.goal().p, there_.p) << "the goal has not changed";
}

TEST_F(ToolHandTest, DoesNotPushHarderAgainstWhatHoldsTheTool) {
  const Pose held = tool_.X_WT;
  hand_.move(now_, there_, 500);
  run(500);
  const Vector3 before = toEigen(hand_.position(now_));
  for (int i = 0; i < 20; ++i) {
    hand_.correct(now_, held, 100);  // the tool is stuck
    run(100);
  }
  const Vector3 more = toEigen(hand_.position(now_)) - before;
  EXPECT_NEAR(more.norm(), 0.04, 1e-9) << "4 mm of the tool at scale 0.1";
}

TEST_F(ToolHandTest, OpensAndClosesSmoothly) {
  EXPECT_EQ(hand_.jaws(now_), 1.0);
  hand_.moveJaws(now_, 0.0, 100);
  run(50);
  EXPECT_NEAR(hand_.jaws(now_), 0.5, 1e-9);
  run(50);
  EXPECT_EQ(hand_.jaws(now_), 0.0);
  EXPECT_EQ(hand_.jawGoal(), 0.0);
}

}  // namespace
}  // namespace raven2_trainer::console
