#include "plant/arm_plant.h"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "raven2_trainer/raven/board_channels.h"
#include "unit/plant/closed_loop.h"

namespace raven2_trainer::plant {
namespace {

using test::dhRaven;
using test::trainerConfig;

constexpr double kDegree = kPi / 180.0;
constexpr std::array<std::int16_t, raven::kChannels> kNoDac{};

VirtualRavenConfig frictionless() {
  VirtualRavenConfig config = trainerConfig().virtual_raven;
  config.start_offset = JointArray{};
  for (PlantAxis& axis : config.plant.axes)
    axis.coulomb = axis.viscous = axis.link_coulomb = axis.torque_offset = 0.0;
  return config;
}

std::array<std::int16_t, raven::kChannels> dacOn(Joint joint, std::int16_t counts) {
  std::array<std::int16_t, raven::kChannels> dac{};
  dac[raven::channelOf(joint)] = counts;
  return dac;
}

TEST(ArmPlant, StartsAtHomePlusOffset) {
  VirtualRavenConfig config = trainerConfig().virtual_raven;
  config.start_offset = {0.1, -0.2, 0.01, 0.3, 0.0, 0.0, 0.0};
  const ArmPlant arm(dhRaven(trainerConfig().arms), Arm::kGold, config);
  EXPECT_NEAR(arm.jointPositions()[kElbow], 90 * kDegree - 0.2, 1e-12);
  EXPECT_NEAR(arm.jointPositions()[kInsertion], 0.41, 1e-12);
}

TEST(ArmPlant, BrakesHoldExactlyAgainstGravity) {
  ArmPlant arm(dhRaven(trainerConfig().arms), Arm::kGold, trainerConfig().virtual_raven);
  const Vector7 start = arm.jointPositions();
  for (int k = 0; k < 1000; ++k)
    arm.step(kNoDac, true);
  EXPECT_EQ(arm.jointPositions().head<3>(), start.head<3>());
}

TEST(ArmPlant, FallsWithoutBrakes) {
  ArmPlant arm(dhRaven(trainerConfig().arms), Arm::kGold, frictionless());
  const double start = arm.dynamics().potentialEnergy();
  for (int k = 0; k < 300; ++k)
    arm.step(kNoDac, false);
  EXPECT_LT(arm.dynamics().potentialEnergy(), start - 1e-3);
}

TEST(ArmPlant, FirstMotionUnderADacIsThatOfTheEquationsOfMotion) {
  // Independent route: joint coordinates, M + A^T diag(I / N) A, torque = A^T tau_capstan / N (raven2.md 3.1, 3.4).
  const VirtualRavenConfig config = frictionless();
  const model::RavenModel raven = dhRaven(trainerConfig().arms);
  const Matrix7 A = raven::CableCoupling(Arm::kGreen, config).matrix();
  ArmDynamics dynamics(raven, Arm::kGreen);
  ArmPlant arm(raven, Arm::kGreen, config);
  dynamics.update(arm.jointPositions(), Vector7::Zero());
  Matrix7 M = dynamics.massMatrix();
  for (Eigen::Index j = 0; j < 7; ++j) {
    const double gear = j < 3 ? 12.25 : 26.0 / 7.0;
    M += A.row(j).transpose() * config.plant.axes[static_cast<std::size_t>(j)].inertia / gear * A.row(j);
  }
  Vector7 capstan = Vector7::Zero();
  capstan[kShoulder] = 2000.0 / 3695.807;  // green: positive
  const Vector7 expected = M.inverse() * (A.transpose() * (capstan / 12.25) - dynamics.bias());

  arm.step(dacOn(kShoulder, 2000), false);
  // The damping of the tool's cables and the change of posture within 1 ms are small against the acceleration.
  EXPECT_NEAR(arm.jointVelocities()[kShoulder] / kTickSeconds, expected[kShoulder],
              0.01 * std::abs(expected[kShoulder]));
  EXPECT_GT(expected[kShoulder], 5.0);
}

TEST(ArmPlant, DacSignsOfTheArmsAreOpposite) {
  for (const Arm which : kArms) {
    VirtualRavenConfig config = frictionless();
    ArmPlant arm(dhRaven(trainerConfig().arms), which, config);
    for (int k = 0; k < 50; ++k)
      arm.step(dacOn(kShoulder, 2400), false);
    const double moved = arm.jointPositions()[kShoulder] - trainerConfig().arms.geometry.home[kShoulder];
    EXPECT_GT(which == Arm::kGold ? -moved : moved, 0.005);
  }
}

TEST(ArmPlant, SticksBelowCoulombFrictionAndSlidesAbove) {
  VirtualRavenConfig config = trainerConfig().virtual_raven;
  config.start_offset = JointArray{};
  // Tool rotation: 0.002 Nm at the capstan are 54.7 counts.
  ArmPlant held(dhRaven(trainerConfig().arms), Arm::kGold, config);
  ArmPlant moved(dhRaven(trainerConfig().arms), Arm::kGold, config);
  const double threshold = config.plant.axes[kToolRotation].coulomb * 27328.42;
  for (int k = 0; k < 500; ++k) {
    held.step(dacOn(kToolRotation, static_cast<std::int16_t>(0.8 * threshold)), true);
    moved.step(dacOn(kToolRotation, static_cast<std::int16_t>(1.5 * threshold + 10)), true);
  }
  EXPECT_EQ(held.jointVelocities()[kToolRotation], 0.0);
  EXPECT_NE(moved.jointVelocities()[kToolRotation], 0.0);
}

TEST(ArmPlant, StopsAtTheShouldersHardStop) {
  ArmPlant arm(dhRaven(trainerConfig().arms), Arm::kGold, trainerConfig().virtual_raven);
  double lowest = 1.0;
  for (int k = 0; k < 3000; ++k) {
    arm.step(dacOn(kShoulder, 2500), false);
    lowest = std::min(lowest, arm.jointPositions()[kShoulder]);
  }
  EXPECT_GT(lowest, -1e-6);
  EXPECT_LT(lowest, 1e-4);
}

TEST(ArmPlant, EncodersShowTheMotorInWholeCounts) {
  for (const Arm which : kArms) {
    const VirtualRavenConfig& config = trainerConfig().virtual_raven;
    const ArmPlant arm(dhRaven(trainerConfig().arms), which, config);
    JointArray q;
    for (std::size_t j = 0; j < kJointCount; ++j)
      q[j] = arm.jointPositions()[static_cast<Eigen::Index>(j)];
    const JointArray motor = raven::CableCoupling(which, config).toMotor(q);
    for (std::size_t j = 0; j < kJointCount; ++j) {
      const double read = raven::encoderSign(which, j) * arm.encoders()[raven::channelOf(j)] * 2 * kPi / 4000;
      EXPECT_NEAR(read, motor[j], kPi / 4000 + 1e-9);
    }
  }
}

/** One joint of one arm, driven by its motor alone against either of its hard stops; rigid or elastic cables. */
struct StopRow {
  Joint joint;
  bool elastic;
};

class HardStops : public ::testing::TestWithParam<StopRow> {
 protected:
  /** raven2.md 2.3 where homing searches; on the other side as doc/virtual_raven.md says: 5 degrees or 5 mm beyond the
   * software's limit, tool joints symmetric. */
  static double stopOf(Joint joint, bool upper) {
    constexpr JointArray kHigh{95 * kDegree,  137.5 * kDegree, 0.562,        330 * kDegree,
                               100 * kDegree, 120 * kDegree,   120 * kDegree};
    constexpr JointArray kLow{0.0, 40 * kDegree, 0.225, -330 * kDegree, -100 * kDegree, -120 * kDegree, -120 * kDegree};
    return upper ? kHigh[joint] : kLow[joint];
  }

  /** The arm a little before the stop, at rest. */
  static ArmPlant before(Arm which, const StopRow& row, bool upper) {
    VirtualRavenConfig config = frictionless();
    config.plant.elastic_cables = row.elastic;
    for (std::size_t j = 0; j < kJointCount; ++j)
      config.plant.axes[j].coulomb = j == row.joint ? 0.0 : 10.0;  // the others do not move
    ArmPlant arm(dhRaven(trainerConfig().arms), which, config);
    const double room = row.joint == kInsertion ? 0.002 : 0.02;
    Vector7 q = arm.jointPositions();
    q[row.joint] = stopOf(row.joint, upper) + (upper ? -room : room);
    arm.setMotors(raven::CableCoupling(which, config).matrix() * q, Vector7::Zero());
    return arm;
  }
};

TEST_P(HardStops, HoldEitherArmOnEitherSide) {
  for (const Arm which : kArms) {
    for (const bool upper : {false, true}) {
      ArmPlant arm = before(which, GetParam(), upper);
      const auto j = static_cast<Eigen::Index>(GetParam().joint);
      const double stop = stopOf(GetParam().joint, upper), side = upper ? 1.0 : -1.0;
      const auto counts = static_cast<std::int16_t>(side * 3000 * raven::torqueSign(which, GetParam().joint));
      double farthest = -1.0;
      for (int k = 0; k < 150; ++k) {
        arm.step(dacOn(GetParam().joint, counts), false);
        farthest = std::max(farthest, side * (arm.jointPositions()[j] - stop));
      }
      EXPECT_LT(farthest, 1e-6) << name(which) << (upper ? " above" : " below");
      EXPECT_GT(farthest, -1e-4) << name(which) << (upper ? " above" : " below") << ": it was driven there";
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Joints,
                         HardStops,
                         ::testing::Values(StopRow{kShoulder, false},
                                           StopRow{kElbow, false},
                                           StopRow{kInsertion, false},
                                           StopRow{kToolRotation, false},
                                           StopRow{kWrist, false},
                                           StopRow{kGrasp1, false},
                                           StopRow{kGrasp2, false},
                                           StopRow{kShoulder, true},
                                           StopRow{kElbow, true},
                                           StopRow{kInsertion, true}));

TEST(ArmPlant, SetMotorsForgetsWhichAxesStuck) {
  for (const Arm which : kArms) {
    const VirtualRavenConfig& config = trainerConfig().virtual_raven;
    ArmPlant used(dhRaven(trainerConfig().arms), which, config), fresh(dhRaven(trainerConfig().arms), which, config);
    const Vector7 start = fresh.motorPositions();
    for (int k = 0; k < 100; ++k)
      used.step(dacOn(kShoulder, 1500), true);
    for (ArmPlant* arm : {&used, &fresh}) {
      arm->setMotors(start, Vector7::Constant(3.0));
      arm->step(dacOn(kElbow, -800), false);
    }
    EXPECT_EQ(used.motorRates(), fresh.motorRates()) << name(which);
    EXPECT_EQ(used.motorPositions(), fresh.motorPositions()) << name(which);
  }
}

TEST(ArmPlant, ATorqueOffsetIsThatTorqueAtTheCapstan) {
  for (const Arm which : kArms) {
    for (const Joint joint : {kShoulder, kInsertion, kWrist}) {
      const double sign = raven::torqueSign(which, joint), tau = 0.05;
      VirtualRavenConfig config = frictionless(), offset = frictionless();
      offset.plant.axes[joint].torque_offset = tau;
      ArmPlant pushed(dhRaven(trainerConfig().arms), which, offset);
      ArmPlant commanded(dhRaven(trainerConfig().arms), which, config);
      const double scale = joint <= kInsertion ? 3695.807 : 27328.42;  // [counts/Nm] raven2.md 3.1
      pushed.step(kNoDac, false);
      commanded.step(dacOn(joint, static_cast<std::int16_t>(std::lround(sign * tau * scale))), false);
      EXPECT_NEAR(pushed.motorRates()[joint], commanded.motorRates()[joint],
                  0.01 * std::abs(commanded.motorRates()[joint]))
          << name(which) << kJointNames[joint];
    }
  }
}

TEST(ArmPlant, ViscousFrictionLimitsTheMotorToTorqueOverDamping) {
  // Tool rotation alone: at its end speed all of the torque is friction, rate = tau_capstan / viscous.
  VirtualRavenConfig config = frictionless();
  const double viscous = 0.004;  // [Nms/rad] at the capstan
  config.plant.axes[kToolRotation].viscous = viscous;
  config.plant.axes[kToolRotation].link_viscous = 0.0;
  ArmPlant arm(dhRaven(trainerConfig().arms), Arm::kGold, config);
  const int counts = -400;
  double rate = 0.0;
  for (int k = 0; k < 200 && arm.jointPositions()[kToolRotation] < 4.0; ++k) {
    arm.step(dacOn(kToolRotation, static_cast<std::int16_t>(counts)), true);  // the others are braked
    rate = arm.motorRates()[kToolRotation];
  }
  EXPECT_NEAR(rate, -counts / 27328.42 / viscous, 0.02 * rate);
}

TEST(ArmPlant, TheTorqueGainIsRealOverCommandedTorque) {
  for (const Arm which : kArms) {
    for (const Joint joint : {kShoulder, kInsertion, kWrist}) {
      VirtualRavenConfig weak = frictionless();
      weak.plant.axes[joint].torque_gain = 0.5;
      ArmPlant commanded(dhRaven(trainerConfig().arms), which, frictionless());
      ArmPlant weaker(dhRaven(trainerConfig().arms), which, weak);
      commanded.step(dacOn(joint, 1000), false);
      weaker.step(dacOn(joint, 2000), false);
      EXPECT_NEAR(weaker.motorRates()[joint], commanded.motorRates()[joint], 1e-9) << name(which) << kJointNames[joint];
    }
  }
}

TEST(ArmPlant, ViscousFrictionAtTheJointLimitsItsMotorToo) {
  VirtualRavenConfig config = frictionless();
  const double viscous = 0.03, ratio = config.axes[kToolRotation].transmission;  // [Nms/rad] at the joint
  config.plant.axes[kToolRotation].link_viscous = viscous;
  ArmPlant arm(dhRaven(trainerConfig().arms), Arm::kGold, config);
  for (int k = 0; k < 200; ++k)
    arm.step(dacOn(kToolRotation, -400), true);  // the others are braked
  const double expected = 400 / 27328.42 / (26.0 / 7.0) * ratio * ratio / viscous;
  EXPECT_NEAR(arm.motorRates()[kToolRotation], expected, 0.05 * expected);
}

}  // namespace
}  // namespace raven2_trainer::plant
