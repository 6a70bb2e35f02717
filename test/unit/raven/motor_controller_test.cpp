#include "raven/motor_controller.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "unit/raven/raven_fixture.h"

namespace raven2_trainer::raven {
namespace {

using test::trainerConfig;

const VirtualRavenConfig& config() {
  return trainerConfig().virtual_raven;
}

TEST(MotorController, ScalesAndSignsTorqueAsTheBoardsExpect) {
  // DAC counts per capstan Nm (raven2.md 3.1): 3695.807 positioning, 27328.42 tool.
  JointArray tau;
  tau.fill(0.1);
  const DacArray gold = MotorController(Arm::kGold, config()).toDac(tau);
  const DacArray green = MotorController(Arm::kGreen, config()).toDac(tau);
  const DacArray gold_expected{-369, -369, -369, -2732, -2732, 2732, -2732};
  const DacArray green_expected{369, 369, 369, -2732, -2732, 2732, -2732};
  EXPECT_EQ(gold, gold_expected);
  EXPECT_EQ(green, green_expected);
}

TEST(MotorController, SaturatesAtSixteenBits) {
  JointArray tau{1e9, -1e9, std::numeric_limits<double>::quiet_NaN()};
  const DacArray dac = MotorController(Arm::kGreen, config()).toDac(tau);
  EXPECT_EQ(dac[0], 32767);
  EXPECT_EQ(dac[1], -32767);  // utils.cpp:51-67
  EXPECT_EQ(dac[2], 0);
}

TEST(MotorController, DampsVelocityAndIntegratesToolErrorsOnly) {
  MotorController controller(Arm::kGold, config());
  JointArray desired{}, motor{}, velocity{};
  desired.fill(1.0);
  velocity.fill(2.0);
  JointArray tau{};
  for (int k = 0; k < 1000; ++k)
    tau = controller.torque(desired, motor, velocity);
  EXPECT_NEAR(tau[kShoulder], 0.300 - 0.008 * 2, 1e-12);
  EXPECT_NEAR(tau[kInsertion], 0.150 - 0.012 * 2, 1e-12);
  EXPECT_NEAR(tau[kToolRotation], 0.09 - 0.001 * 2 + 0.05 * 1.0, 1e-9);  // 1 rad for 1 s at ki 0.05
  EXPECT_NEAR(tau[kGrasp2], 0.05 + 0.05, 1e-9);
}

TEST(MotorController, GreenInsertionHasItsOwnDamping) {
  JointArray velocity{};
  velocity[kInsertion] = 1.0;
  EXPECT_NEAR(MotorController(Arm::kGreen, config()).torque({}, {}, velocity)[kInsertion], -0.010, 1e-12);
}

TEST(OverdriveDetect, ClipsAboveTheModerateLimits) {
  DacArray dac{2501, -2501, 2001, 3001, -3001, 3801, 0};
  EXPECT_FALSE(OverdriveCheck(config()).check(true, &dac));
  EXPECT_EQ(dac, (DacArray{2500, -2500, 2000, 3000, -3000, 3800, 0}));
}

TEST(OverdriveDetect, DoesNotClipInEStop) {
  DacArray dac{2501};
  EXPECT_FALSE(OverdriveCheck(config()).check(false, &dac));
  EXPECT_EQ(dac[0], 2501);
}

TEST(OverdriveDetect, StopsAboveTheInstantLimitAndZeroesThatCommandOnly) {
  DacArray dac{100, -20001, 300, 400, 500, 600, 700};
  EXPECT_TRUE(OverdriveCheck(config()).check(true, &dac));
  EXPECT_EQ(dac, (DacArray{100, 0, 300, 400, 500, 600, 700}));
  DacArray limit{20000};
  EXPECT_FALSE(OverdriveCheck(config()).check(true, &limit));
}

TEST(OverdriveDetect, PolicyHardStopsAfterMoreThanTenCommandsAboveTheClip) {
  VirtualRavenConfig hard = config();
  hard.overdrive_policy = OverdrivePolicy::kHard;
  OverdriveCheck check(hard);
  for (int k = 0; k < 11; ++k) {
    DacArray dac{2600};
    EXPECT_FALSE(check.check(true, &dac)) << k;
    EXPECT_EQ(dac[0], 2600) << "not clipped";
  }
  DacArray dac{2600};
  EXPECT_TRUE(check.check(true, &dac));
  EXPECT_EQ(dac[0], 0);
}

TEST(OverdriveDetect, PolicyHardCountsAfreshAfterACommandAboveTheInstantLimit) {
  VirtualRavenConfig hard = config();
  hard.overdrive_policy = OverdrivePolicy::kHard;
  OverdriveCheck check(hard);
  for (int attempt = 0; attempt < 3; ++attempt) {
    for (int k = 0; k < 11; ++k) {
      DacArray dac{};
      dac[k % kGrasp2] = k % 2 == 0 ? 4000 : -4000;  // of all joints, on either side
      EXPECT_FALSE(check.check(true, &dac)) << attempt << " " << k;
    }
    DacArray dac{0, 0, -20001};
    EXPECT_TRUE(check.check(true, &dac));
  }
}

TEST(OverdriveDetect, PolicyNoneOnlyKnowsTheInstantLimit) {
  VirtualRavenConfig none = config();
  none.overdrive_policy = OverdrivePolicy::kNone;
  OverdriveCheck check(none);
  for (int k = 0; k < 100; ++k) {
    DacArray dac{19000};
    EXPECT_FALSE(check.check(true, &dac));
    EXPECT_EQ(dac[0], 19000);
  }
  DacArray dac{20001};
  EXPECT_TRUE(check.check(true, &dac));
}

TEST(OverdriveDetect, NeverLooksAtGrasper2) {
  DacArray dac{0, 0, 0, 0, 0, 0, 32767};
  EXPECT_FALSE(OverdriveCheck(config()).check(true, &dac));
  EXPECT_EQ(dac[kGrasp2], 32767);
}

}  // namespace
}  // namespace raven2_trainer::raven
