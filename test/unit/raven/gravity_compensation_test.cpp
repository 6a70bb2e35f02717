#include "raven/gravity_compensation.h"

#include <gtest/gtest.h>

#include <cmath>

#include "raven/motor_controller.h"
#include "unit/raven/raven_fixture.h"

namespace raven2_trainer::raven {
namespace {

using test::trainerConfig;

TEST(GravityCompensation, GivesTheObservedCountsAtHome) {
  // Observed on the robot's program at its home pose (raven2.md 3.8).
  const std::array<int, 3> expected{45, 159, -44};
  const VirtualRavenConfig& config = trainerConfig().virtual_raven;
  const auto tau = GravityCompensation(Arm::kGold, config).torque(trainerConfig().arms.geometry.home);
  const DacArray dac = MotorController(Arm::kGold, config).toDac({tau[0], tau[1], tau[2]});
  for (std::size_t j = 0; j < 3; ++j)
    EXPECT_EQ(dac[j], expected[j]);
}

TEST(GravityCompensation, MirroredArmsCarryTheSameWeight) {
  const VirtualRavenConfig& config = trainerConfig().virtual_raven;
  const JointArray q{0.7, 1.3, 0.35, 0, 0, 0, 0};
  const auto gold = GravityCompensation(Arm::kGold, config).torque(q);
  const auto green = GravityCompensation(Arm::kGreen, config).torque(q);
  for (std::size_t j = 0; j < 3; ++j)
    EXPECT_NEAR(gold[j], green[j], 1e-12);
  EXPECT_GT(std::abs(gold[0]), 1e-3);
}

}  // namespace
}  // namespace raven2_trainer::raven
