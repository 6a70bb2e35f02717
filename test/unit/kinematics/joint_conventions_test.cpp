#include "raven2_trainer/kinematics/joint_conventions.h"

#include <gtest/gtest.h>

namespace raven2_trainer::kinematics {
namespace {

TEST(JointConventions, FollowTheRobotsJointStates) {
  // raven2.md 5.4: insertion + d4, tool roll -45 deg on L and +45 on R, wrist negated on R, grasper 2 negated
  const JointArray q{0.1, 0.2, 0.4, 0.3, 0.5, 0.6, 0.7};
  const JointArray gold = toUrdf(Arm::kGold, -0.47, q);
  const JointArray green = toUrdf(Arm::kGreen, -0.47, q);
  EXPECT_DOUBLE_EQ(gold[kInsertion], 0.4 - 0.47);
  EXPECT_DOUBLE_EQ(gold[kToolRotation], 0.3 - kPi / 4);
  EXPECT_DOUBLE_EQ(green[kToolRotation], 0.3 + kPi / 4);
  EXPECT_DOUBLE_EQ(gold[kWrist], 0.5);
  EXPECT_DOUBLE_EQ(green[kWrist], -0.5);
  EXPECT_DOUBLE_EQ(gold[kGrasp1], 0.6);
  EXPECT_DOUBLE_EQ(gold[kGrasp2], -0.7);
}

TEST(JointConventions, RoundTrip) {
  const JointArray q{0.1, 0.2, 0.4, 0.3, 0.5, 0.6, 0.7};
  for (const Arm arm : kArms) {
    const JointArray back = fromUrdf(arm, -0.47, toUrdf(arm, -0.47, q));
    for (std::size_t j = 0; j < kJointCount; ++j)
      EXPECT_NEAR(back[j], q[j], 1e-15);
    EXPECT_EQ(rateToUrdf(arm, rateToUrdf(arm, q)), q);
  }
}

}  // namespace
}  // namespace raven2_trainer::kinematics
