#include "raven2_trainer/raven/cable_coupling.h"

#include <gtest/gtest.h>

#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/core/random.h"
#include "unit/raven/raven_fixture.h"

namespace raven2_trainer::raven {
namespace {

using test::trainerConfig;

constexpr double kPrinted = 5e-7;  // the reference prints six decimals

TEST(CableCoupling, PositioningBlockHasThePublishedNumbers) {
  for (const Arm arm : kArms) {
    const Eigen::Matrix<double, 7, 7> A = CableCoupling(arm, trainerConfig().virtual_raven).matrix();
    Eigen::Matrix3d expected;
    expected << 136.196255, 0, 0, 17.675386, 121.522075, 0, 16.831355, 17.435769, 2158.590308;
    EXPECT_LT((A.topLeftCorner<3, 3>() - expected).cwiseAbs().maxCoeff(), 1e-6);
    EXPECT_EQ((A.topRightCorner<3, 4>().norm()), 0.0);
  }
}

TEST(CableCoupling, InverseBlockHasThePublishedNumbers) {
  const Eigen::Matrix<double, 7, 7> inverse = CableCoupling(Arm::kGold, trainerConfig().virtual_raven).inverse();
  Eigen::Matrix3d expected;
  expected << 7.3423458e-3, 0, 0, -1.0679442e-3, 8.2289576e-3, 0, -4.8624881e-5, -6.6468475e-5, 4.6326531e-4;
  EXPECT_LT((inverse.topLeftCorner<3, 3>() - expected).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(CableCoupling, ToolRowsCarryTheInsertionMotorWithTheSignsOfTheArm) {
  // s = +1 gold, -1 green; grasper 1 opposite because of OPPOSE_GRIP.
  const std::array<double, 4> gold_signs{1, 1, -1, 1};
  for (const Arm arm : kArms) {
    const Eigen::Matrix<double, 7, 7> A = CableCoupling(arm, trainerConfig().virtual_raven).matrix();
    for (std::size_t k = 0; k < 4; ++k) {
      const double s = arm == Arm::kGold ? gold_signs[k] : -gold_signs[k];
      const auto row = static_cast<Eigen::Index>(kToolRotation + k);
      EXPECT_NEAR(A(row, kShoulder), s * 5.786555, kPrinted);
      EXPECT_NEAR(A(row, kElbow), s * 5.994350, kPrinted);
      EXPECT_NEAR(A(row, kInsertion), s * 742.115028, kPrinted * 10);
    }
    EXPECT_DOUBLE_EQ(A(kToolRotation, kToolRotation), 5.39517625);
    EXPECT_DOUBLE_EQ(A(kGrasp1, kGrasp1), 8.99196042);
    EXPECT_EQ(A(kGrasp1, kWrist), 0.0);  // r_grasper has no wrist coupling
  }
}

TEST(CableCoupling, JointsSurviveTheRoundTrip) {
  Random random(7);
  for (const Arm arm : kArms) {
    const CableCoupling coupling(arm, trainerConfig().virtual_raven);
    for (int n = 0; n < 200; ++n) {
      JointArray q;
      for (double& value : q)
        value = random.uniform(-2.0, 2.0);
      const JointArray back = coupling.toJoint(coupling.toMotor(q));
      for (std::size_t j = 0; j < kJointCount; ++j)
        EXPECT_NEAR(back[j], q[j], 1e-11);
    }
  }
}

TEST(CableCoupling, ToolRowsFollowTheMeasuredInsertionMotor) {
  const CableCoupling coupling(Arm::kGold, trainerConfig().virtual_raven);
  const JointArray q = trainerConfig().arms.geometry.home;
  const JointArray wanted = coupling.toMotor(q);
  const JointArray measured = coupling.toMotorMeasured(q, wanted[kInsertion] + 2.90870044);
  EXPECT_EQ(measured[kInsertion], wanted[kInsertion]);
  EXPECT_NEAR(measured[kWrist] - wanted[kWrist], 1.0, 1e-9);  // one tool radian per GB of insertion
  EXPECT_NEAR(measured[kGrasp1] - wanted[kGrasp1], -1.0, 1e-9);
}

TEST(CableCoupling, ToolRowsOfGreenFollowItTheOtherWay) {
  const CableCoupling coupling(Arm::kGreen, trainerConfig().virtual_raven);
  const JointArray q = trainerConfig().arms.geometry.home;
  const JointArray wanted = coupling.toMotor(q);
  const JointArray measured = coupling.toMotorMeasured(q, wanted[kInsertion] + 2.90870044);
  for (const Joint joint : {kToolRotation, kWrist, kGrasp1, kGrasp2})
    EXPECT_NEAR(measured[joint] - wanted[joint], joint == kGrasp1 ? 1.0 : -1.0, 1e-9) << kJointNames[joint];
}

TEST(CableCoupling, RefusesARatioOfZero) {
  VirtualRavenConfig config = trainerConfig().virtual_raven;
  config.axes[kElbow].transmission = 0.0;
  EXPECT_THROW(CableCoupling(Arm::kGold, config), ConfigException);
}

}  // namespace
}  // namespace raven2_trainer::raven
