#include "ros/crtk/crtk_kinematics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"

namespace raven2_trainer::ros_bridge {
namespace {

class CrtkKinematicsTest : public ::testing::TestWithParam<Arm> {
 protected:
  const ArmGeometry geometry =
      config::loadTrainerConfig(RAVEN2_TRAINER_SOURCE_DIR "/config/trainer.yaml").arms.geometry;
  const Pose X_WB{Matrix3(Eigen::AngleAxisd(0.7, Vector3(1.0, 2.0, -0.5).normalized())), Vector3(0.2, -0.1, 0.3)};
};

/** Joints well within their limits, where the arm has its solutions (seeded). */
std::vector<double> someJoints(std::mt19937* random) {
  const auto between = [random](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(*random);
  };
  return {between(0.3, 1.2),  between(1.0, 2.2),  between(0.28, 0.42),
          between(-1.5, 1.5), between(-0.8, 0.8), between(-0.8, 0.8)};
}

TEST_P(CrtkKinematicsTest, TheInverseOfAForwardIsWhereItCameFrom) {
  std::mt19937 random(7);
  for (const CrtkFrame& frame : {worldFrame(X_WB), baseFrame(GetParam())}) {
    for (int i = 0; i < 200; ++i) {
      crtk::ForwardRequest there;
      there.jp = someJoints(&random);
      const crtk::ForwardResponse at = answer(geometry, GetParam(), frame, false, there);
      ASSERT_EQ(at.result, 1) << at.message;
      crtk::InverseRequest back;
      back.cp = at.cp;
      back.jp = there.jp;
      for (double& q : back.jp)
        q += 0.01;
      const crtk::InverseResponse found = answer(geometry, GetParam(), frame, false, back);
      ASSERT_EQ(found.result, 1) << found.message;
      for (std::size_t j = 0; j < 6; ++j)
        EXPECT_NEAR(found.jp[j], there.jp[j], 1e-6) << j;
      crtk::ForwardRequest again;
      again.jp = found.jp;
      const crtk::ForwardResponse same = answer(geometry, GetParam(), frame, false, again);
      EXPECT_NEAR(same.cp.position.x, at.cp.position.x, 1e-7);
      EXPECT_NEAR(same.cp.position.z, at.cp.position.z, 1e-7);
    }
  }
}

TEST_P(CrtkKinematicsTest, JointsThatAreFarAwayStillLeadToASolutionWithinTheLimits) {
  std::mt19937 random(8);
  for (int i = 0; i < 100; ++i) {
    crtk::ForwardRequest there;
    there.jp = someJoints(&random);
    const crtk::ForwardResponse at = answer(geometry, GetParam(), worldFrame(X_WB), false, there);
    crtk::InverseRequest back;
    back.cp = at.cp;
    back.jp = {0.7, 1.5, 0.5, 0.0, 0.0, 0.0};  // up to 0.2 m of insertion away
    const crtk::InverseResponse found = answer(geometry, GetParam(), worldFrame(X_WB), false, back);
    ASSERT_EQ(found.result, 1) << found.message;
    crtk::ForwardRequest again;
    again.jp = found.jp;
    const crtk::ForwardResponse same = answer(geometry, GetParam(), worldFrame(X_WB), false, again);
    EXPECT_EQ(same.result, 1) << "the solution is within the limits";
    EXPECT_NEAR(same.cp.position.y, at.cp.position.y, 1e-7);
  }
}

/** Rounding takes the joints of such a pose beyond their limits. */
TEST_P(CrtkKinematicsTest, TheInverseOfAPoseAtALimitIsWhereItCameFrom) {
  std::mt19937 random(9);
  int at_limit = 0;
  for (std::size_t j = 0; j < 6; ++j) {
    const bool is_midline = j == 5;
    for (const double limit : {geometry.q_min[is_midline ? kGrasp1 : j], geometry.q_max[is_midline ? kGrasp2 : j]}) {
      for (int i = 0; i < 100; ++i) {
        crtk::ForwardRequest there;
        there.jp = someJoints(&random);
        there.jp[j] = limit;
        const crtk::ForwardResponse at = answer(geometry, GetParam(), worldFrame(X_WB), false, there);
        ASSERT_EQ(at.result, 1) << at.message;
        crtk::InverseRequest back;
        back.cp = at.cp;
        back.jp = there.jp;
        const crtk::InverseResponse near = answer(geometry, GetParam(), worldFrame(X_WB), false, back);
        ASSERT_EQ(near.result, 1) << j << " at " << limit << ": " << near.message;
        EXPECT_NEAR(near.jp[j], limit, 1e-9);
        EXPECT_TRUE(is_midline || (near.jp[j] >= geometry.q_min[j] && near.jp[j] <= geometry.q_max[j]));
        at_limit += near.jp[j] == limit ? 1 : 0;
        back.jp = {0.7, 1.5, j == kInsertion && limit > 0.5 ? 0.52 : 0.3, 0.0, 0.0, 0.0};
        const crtk::InverseResponse far = answer(geometry, GetParam(), worldFrame(X_WB), false, back);
        EXPECT_EQ(far.result, 1) << j << " at " << limit << ": " << far.message;
      }
    }
  }
  EXPECT_GT(at_limit, 100) << "rounding did so";
}

TEST_P(CrtkKinematicsTest, APoseHardlyBeyondALimitIsRefused) {
  for (const double beyond : {-1e-6, 1e-6}) {
    const double limit = beyond < 0.0 ? geometry.q_min[kElbow] : geometry.q_max[kElbow];
    crtk::ForwardRequest there;
    there.jp = {0.7, limit + beyond, 0.35, 0.2, 0.3, 0.1};
    crtk::InverseRequest back;
    back.cp = answer(geometry, GetParam(), worldFrame(X_WB), false, there).cp;
    back.jp = there.jp;
    EXPECT_EQ(answer(geometry, GetParam(), worldFrame(X_WB), false, back).result, 0) << beyond;
  }
}

TEST_P(CrtkKinematicsTest, WhatHasNoAnswerSaysWhy) {
  const CrtkFrame frame = worldFrame(X_WB);
  const auto forward = [&](std::vector<double> jp, bool is_raven = false) {
    crtk::ForwardRequest query;
    query.jp = std::move(jp);
    return answer(geometry, GetParam(), frame, is_raven, query);
  };
  EXPECT_EQ(forward({0.5, 1.5}).message, "2 joints where there are 6");
  EXPECT_EQ(forward({0.5, 1.5, 0.3, 0, 0, 0}, true).message, "6 joints where there are 7");
  EXPECT_EQ(forward({0.5, 1.5, std::nan(""), 0, 0, 0}).message, "a number is NaN or infinite");
  EXPECT_EQ(forward({0.5, 1.5, 0.9, 0, 0, 0}).message, "a joint is beyond its limits");
  EXPECT_EQ(forward({0.5, 1.5, 0.3, 0, 0, 0.1, 0.1}, true).result, 1);
  crtk::InverseRequest query;
  query.jp = {0.5, 1.5, 0.3, 0, 0, 0};
  query.cp.orientation.w = 1.0;
  query.cp.position.x = 5.0;
  const crtk::InverseResponse far = answer(geometry, GetParam(), frame, false, query);
  EXPECT_EQ(far.result, 0);
  EXPECT_NE(far.message.find("limits"), std::string::npos) << far.message;
  EXPECT_EQ(far.jp, query.jp) << "the joints come back unchanged";
  query.cp.orientation.w = 0.0;
  EXPECT_NE(answer(geometry, GetParam(), frame, false, query).message.find("quaternion"), std::string::npos);
}

INSTANTIATE_TEST_SUITE_P(BothArms, CrtkKinematicsTest, ::testing::ValuesIn(kArms));

}  // namespace
}  // namespace raven2_trainer::ros_bridge
