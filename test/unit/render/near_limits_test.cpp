#include "render/near_limits.h"

#include <gtest/gtest.h>

#include <limits>

#include "raven2_trainer/kinematics/arm_kinematics.h"

namespace raven2_trainer::render {
namespace {

class NearLimits : public ::testing::Test {
 protected:
  NearLimits() {
    geometry_.d4 = -0.47;
    geometry_.lw = 0.013;
    geometry_.q_min = {0.0, 0.79, 0.23, -3.1, -1.2, -1.8, -1.8};
    geometry_.q_max = {1.57, 2.35, 0.56, 3.1, 1.2, 1.8, 1.8};
    edge_.size_I = {0.07, 0.16, 0.12};
    edge_.margin = 0.01;
    X_WB_[1].p = {0.1, 0.2, 0.3};
    for (ArmState& arm : snapshot_.model.arms)
      arm.q = {0.5, 1.6, 0.40, 0.0, 0.0, 0.8, 0.8};
    snapshot_.model.pedal = 1;
  }

  std::vector<NearLimit> limits() const { return nearLimits(geometry_, X_WB_, edge_, snapshot_); }
  JointArray& green() { return snapshot_.model.arms[1].q; }

  ArmGeometry geometry_;
  PerArm<Pose> X_WB_{};
  EdgeConfig edge_;
  Snapshot snapshot_;
};

TEST_F(NearLimits, InTheMiddleThereAreNoneAndClosedJawsAreNoLimit) {
  EXPECT_TRUE(limits().empty());
  green()[kGrasp1] = 1.8;
  EXPECT_TRUE(limits().empty());
}

TEST_F(NearLimits, TheWallStandsWhereTheInsertionEnds) {
  green()[kInsertion] = 0.555;  // 5 mm, half of the margin
  ASSERT_EQ(limits().size(), 1U);
  const NearLimit limit = limits()[0];
  EXPECT_EQ(limit.arm, Arm::kGreen);
  EXPECT_EQ(limit.text, "green limit     insertion 5 mm");
  EXPECT_NEAR(limit.nearness, 0.5, 1e-9);
  JointArray there = green();
  there[kInsertion] = 0.56;
  const Vector3 stopped_W = X_WB_[1] * kinematics::forward(geometry_, Arm::kGreen, there).p;
  ASSERT_TRUE(limit.is_wall);
  EXPECT_LT((limit.p_W - stopped_W).norm(), 1e-9) << "the insertion moves the tip straight";
  const Vector3 tip_W = X_WB_[1] * kinematics::forward(geometry_, Arm::kGreen, green()).p;
  EXPECT_LT((limit.along_W - (stopped_W - tip_W).normalized()).norm(), 1e-6);
}

TEST_F(NearLimits, AtALowerLimitTheWallIsOnTheOtherSide) {
  green()[kElbow] = 0.79 + 0.02;
  ASSERT_EQ(limits().size(), 1U);
  JointArray there = green();
  there[kElbow] = 0.79;
  const Vector3 stopped_W = X_WB_[1] * kinematics::forward(geometry_, Arm::kGreen, there).p;
  EXPECT_LT((limits()[0].p_W - stopped_W).norm(), 5e-5) << "the arc of 0.02 rad is nearly straight";
  EXPECT_EQ(limits()[0].text, "green limit     elbow 1 deg");
}

TEST_F(NearLimits, AJointThatOnlyTurnsTheToolIsToldWithoutAWall) {
  green()[kToolRotation] = 3.09;
  ASSERT_EQ(limits().size(), 1U);
  EXPECT_EQ(limits()[0].text, "green limit     tool rotation 1 deg");
  EXPECT_FALSE(limits()[0].is_wall);
}

TEST_F(NearLimits, BeyondALimitNothingGrowsFurther) {
  green()[kShoulder] = -0.3;
  ASSERT_EQ(limits().size(), 1U);
  EXPECT_EQ(limits()[0].nearness, 1.0);
  EXPECT_EQ(limits()[0].text, "green limit     shoulder 0 deg");
}

TEST_F(NearLimits, TheEdgeOfTheMastersWorkspaceIsToldWhileItActs) {
  snapshot_.haptic.hand_I[0] = {0.0, -0.075, 0.0};  // 5 mm before the left face
  EXPECT_TRUE(limits().empty()) << "the edge is off";
  edge_.enabled = true;
  ASSERT_EQ(limits().size(), 1U);
  EXPECT_EQ(limits()[0].text, "gold  hand      at the edge, left");
  EXPECT_NEAR(limits()[0].nearness, 0.5, 1e-9);
  snapshot_.model.pedal = 0;
  EXPECT_TRUE(limits().empty()) << "with the pedal up the hand moves nothing";
}

TEST_F(NearLimits, EachFaceOfTheMastersWorkspaceHasItsName) {
  edge_.enabled = true;
  const std::array<std::pair<Vec3, const char*>, 6> faces{{{{0.03, 0, 0}, "forward"},
                                                           {{-0.03, 0, 0}, "backward"},
                                                           {{0, 0.075, 0}, "right"},
                                                           {{0, -0.075, 0}, "left"},
                                                           {{0, 0, 0.055}, "down"},
                                                           {{0, 0, -0.055}, "up"}}};
  for (const auto& [hand_I, way] : faces) {
    snapshot_.haptic.hand_I[1] = hand_I;
    ASSERT_EQ(limits().size(), 1U) << way;
    EXPECT_EQ(limits()[0].text, std::string("green hand      at the edge, ") + way);
  }
}

TEST_F(NearLimits, WhatIsNotFiniteHasNoLimit) {
  edge_.enabled = true;
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    green().fill(bad);
    snapshot_.haptic.hand_I[0] = {bad, bad, bad};
    EXPECT_TRUE(limits().empty());
  }
  green() = {-0.3, 1.6, std::numeric_limits<double>::quiet_NaN(), 0.0, 0.0, 0.8, 0.8};
  ASSERT_EQ(limits().size(), 1U);
  EXPECT_FALSE(limits()[0].is_wall) << "the tip's position is unknown";
}

TEST_F(NearLimits, EachArmsWallStandsBeforeItsOwnTip) {
  X_WB_[0].p = {-0.4, 0.5, 0.6};
  for (const Arm arm : kArms) {
    JointArray& q = at(snapshot_.model.arms, arm).q;
    q[kInsertion] = 0.555;
    JointArray there = q;
    there[kInsertion] = 0.56;
    const Vector3 tip_W = at(X_WB_, arm) * kinematics::forward(geometry_, arm, q).p;
    const Vector3 stopped_W = at(X_WB_, arm) * kinematics::forward(geometry_, arm, there).p;
    ASSERT_EQ(limits().size(), 1U) << name(arm);
    const NearLimit limit = limits()[0];
    EXPECT_EQ(limit.arm, arm);
    ASSERT_TRUE(limit.is_wall);
    EXPECT_LT((limit.p_W - stopped_W).norm(), 1e-9) << name(arm);
    EXPECT_LT((limit.along_W - (stopped_W - tip_W).normalized()).norm(), 1e-6) << name(arm);
    q[kInsertion] = 0.40;
  }
}

}  // namespace
}  // namespace raven2_trainer::render
