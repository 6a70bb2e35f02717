// Amplifiers, elastic cables and encoders of an arm.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "plant/arm_plant.h"
#include "raven2_trainer/core/random.h"
#include "raven2_trainer/raven/board_channels.h"
#include "support/allocation_counter.h"
#include "unit/plant/closed_loop.h"

namespace raven2_trainer::plant {
namespace {

using test::dhRaven;
using test::trainerConfig;
using Dac = std::array<std::int16_t, raven::kChannels>;

/** The identified plant with elastic cables, starting at home. */
VirtualRavenConfig elastic(double stiffer = 1.0) {
  VirtualRavenConfig config = trainerConfig().virtual_raven;
  config.start_offset = JointArray{};
  config.plant.elastic_cables = true;
  for (PlantAxis& axis : config.plant.axes) {
    axis.cable_stiffness *= stiffer;
    axis.torque_offset = 0.0;
  }
  return config;
}

VirtualRavenConfig withoutFriction(VirtualRavenConfig config) {
  for (PlantAxis& axis : config.plant.axes)
    axis.coulomb = axis.viscous = axis.link_coulomb = axis.link_viscous = 0.0;
  return config;
}

ArmPlant goldArm(const VirtualRavenConfig& config) {
  return ArmPlant(dhRaven(trainerConfig().arms), Arm::kGold, config);
}

Dac dacOn(Joint joint, int counts) {
  Dac dac{};
  dac[raven::channelOf(joint)] = static_cast<std::int16_t>(counts);
  return dac;
}

TEST(Cables, OfTheToolRunOverItsOwnCapstans) {
  const auto stiffness = goldArm(elastic()).cableStiffness();
  for (Eigen::Index j = kToolRotation; j < 7; ++j)  // raven2_sim: 16 kN/m, capstans of 5.005 mm and 26 to 7 teeth
    EXPECT_NEAR(stiffness[j], 1.6e4 * std::pow(5.005e-3 * 7.0 / 26.0, 2), 1e-6) << j;
}

/** Commands that move all axes back and forth, from a seed. */
class RandomCommands {
 public:
  Dac next() {
    if (cycle_++ % 50 == 0) {
      for (std::int16_t& counts : dac_)
        counts = static_cast<std::int16_t>(random_.uniform(-600, 600));
    }
    return dac_;
  }

 private:
  Random random_{7};
  Dac dac_{};
  int cycle_{0};
};

TEST(Cables, StretchAtRestIsTheLoadOverTheStiffness) {
  // Brakes hold the motors; each cable carries gravity through the coupling: A^-T dV/dq, V by differences.
  const VirtualRavenConfig config = elastic();
  ArmPlant arm = goldArm(config);
  for (int k = 0; k < 5000; ++k)
    arm.step({}, /*brakes_on=*/true);
  const Vector7 q = arm.jointPositions();
  Vector7 gravity;
  for (Eigen::Index j = 0; j < 7; ++j) {
    constexpr double kDelta = 1e-5;
    Vector7 moved = q;
    moved[j] += kDelta;
    arm.dynamics().update(moved, Vector7::Zero());
    const double above = arm.dynamics().potentialEnergy();
    moved[j] -= 2 * kDelta;
    arm.dynamics().update(moved, Vector7::Zero());
    gravity[j] = (above - arm.dynamics().potentialEnergy()) / (2 * kDelta);
  }
  const Vector7 load = raven::CableCoupling(Arm::kGold, config).inverse().transpose() * gravity;
  const Vector7 stretch = arm.cableStretch();
  for (Eigen::Index j = 0; j < 3; ++j) {
    const double capstan_by_shaft = 5.675e-3 / 12.25;
    const double stiffness =
        config.plant.axes[static_cast<std::size_t>(j)].cable_stiffness * capstan_by_shaft * capstan_by_shaft;
    EXPECT_NEAR(stretch[j], load[j] / stiffness, 0.01 * std::abs(load[j] / stiffness) + 1e-7) << kJointNames[j];
    EXPECT_GT(std::abs(stretch[j]), 1e-5);
  }
}

TEST(Cables, PublishedStiffnessAtTheJoint) {
  // raven2.md 6.2: 2 ke r_link^2 at the joint = stiffness at the shaft x transmission^2; r_link 63.095 mm, 56.298
  // mm, 1.
  const VirtualRavenConfig config = elastic();
  const ArmPlant arm = goldArm(config);
  const std::array<double, 3> expected{2 * 720e3 * std::pow(63.095e-3, 2), 2 * 176e3 * std::pow(56.298e-3, 2),
                                       2 * 9.25e3};
  for (std::size_t j = 0; j < 3; ++j) {
    const double at_joint =
        arm.cableStiffness()[static_cast<Eigen::Index>(j)] * std::pow(config.axes[j].transmission, 2);
    EXPECT_NEAR(at_joint, expected[j], 1e-4 * expected[j]);
  }
}

TEST(Cables, EnergyNeverGrowsWithoutAMotor) {
  ArmPlant arm = goldArm(withoutFriction(elastic(0.02)));
  const double start = arm.energy();
  double before = start;
  for (int k = 0; k < 300; ++k) {
    arm.step({}, /*brakes_on=*/false);
    const double now = arm.energy();
    EXPECT_LT(now, before + 2e-4);  // [J] of some 0.5 J of motion: the links' own integration is first order
    before = now;
  }
  EXPECT_LT(before, start + 1e-3);
}

TEST(Cables, AnyStiffnessIsStable) {
  for (const double factor : {1e-2, 1.0, 1e2, 1e4, 1e6}) {
    VirtualRavenConfig config = elastic(factor);
    for (PlantAxis& axis : config.plant.axes)
      axis.cable_damping = 0.0;
    ArmPlant arm = goldArm(config);
    RandomCommands commands;
    for (int k = 0; k < 1000; ++k)
      arm.step(commands.next(), false);
    EXPECT_TRUE(arm.jointPositions().allFinite());
    EXPECT_LT(arm.jointVelocities().cwiseAbs().maxCoeff(), 300.0) << "stiffness x " << factor;
  }
}

double distanceToRigid(double stiffer) {
  VirtualRavenConfig tight = elastic();
  tight.plant.elastic_cables = false;
  ArmPlant rigid = goldArm(tight), arm = goldArm(elastic(stiffer));
  RandomCommands first, second;
  double farthest = 0.0;
  for (int k = 0; k < 400; ++k) {
    rigid.step(first.next(), false);
    arm.step(second.next(), false);
    farthest = std::max(farthest, (rigid.jointPositions() - arm.jointPositions()).head<3>().cwiseAbs().maxCoeff());
  }
  return farthest;
}

TEST(Cables, TheStifferTheCloserToRigidOnes) {
  const double published = distanceToRigid(1.0), hundred = distanceToRigid(100.0), million = distanceToRigid(1e6);
  EXPECT_LT(hundred, 0.2 * published);
  EXPECT_LT(million, 1e-5);
  EXPECT_GT(published, 1e-4);
}

TEST(Cables, ALinkThatSticksLetsTheMotorStretchTheCable) {
  // 30 N of dry friction where the shaft slides, 10 N from the motor, 4 N of weight: the link does not move. The cable
  // of 18500 N/m (raven2.md 6.2) gives 10 / 18500 m, which are 1.167 rad of the motor at 2158.59 rad/m.
  VirtualRavenConfig config = withoutFriction(elastic());
  config.plant.axes[kInsertion].link_coulomb = 30.0;
  for (const Joint joint : {kShoulder, kElbow, kToolRotation, kWrist, kGrasp1, kGrasp2})
    config.plant.axes[joint].coulomb = 10.0;  // these do not move
  ArmPlant arm = goldArm(config);
  const double start = arm.jointPositions()[kInsertion];
  const int counts = -static_cast<int>(10.0 / 2158.59030837 * 12.25 * 3695.807);  // gold: negative drives forward
  for (int k = 0; k < 8000; ++k)  // the motor swings at 1.4 Hz on the cable and decays by exp(-1.6) a second
    arm.step(dacOn(kInsertion, counts), false);
  EXPECT_NEAR(arm.jointPositions()[kInsertion], start, 1e-9);
  const double count = 2158.59030837 / 12.25 / 3695.807;  // [N]
  EXPECT_NEAR(arm.cableStretch()[kInsertion], 10.0 * 2158.59030837 / 18500.0, count * 2158.59030837 / 18500.0);
}

TEST(Amplifier, TorquePerCountIsThePublishedOne) {
  // raven2.md 3.1: 3695.807 counts per Nm at the capstan, 27328.42 of the tool. First millisecond, acceleration = W
  // tau.
  for (const Joint joint : {kShoulder, kElbow, kInsertion, kToolRotation, kWrist, kGrasp1, kGrasp2}) {
    VirtualRavenConfig config = withoutFriction(elastic());
    config.plant.elastic_cables = false;
    ArmPlant without = goldArm(config), with = goldArm(config);
    const int counts = 1000;
    without.step({}, false);
    with.step(dacOn(joint, counts), false);
    ArmDynamics dynamics(dhRaven(trainerConfig().arms), Arm::kGold);
    dynamics.update(goldArm(config).jointPositions(), Vector7::Zero());
    const Matrix7 inverse = raven::CableCoupling(Arm::kGold, config).inverse();
    Matrix7 inertia = inverse.transpose() * dynamics.massMatrix() * inverse;
    const auto k = static_cast<Eigen::Index>(joint);
    for (std::size_t j = 0; j < kJointCount; ++j)
      inertia(static_cast<Eigen::Index>(j), static_cast<Eigen::Index>(j)) +=
          config.plant.axes[j].inertia / (j < 3 ? 12.25 : 26.0 / 7.0);
    const Vector7 impulse = inertia * (with.motorRates() - without.motorRates());
    const double capstan = impulse[k] / 1e-3 * (joint <= kInsertion ? 12.25 : 26.0 / 7.0);
    const double expected = counts / (joint <= kInsertion ? 3695.807 : 27328.42) * (joint == kGrasp1 ? 1.0 : -1.0);
    EXPECT_NEAR(capstan, expected, 0.01 * std::abs(expected)) << kJointNames[joint];
  }
}

TEST(Amplifier, SaturatesAtItsVoltage) {
  VirtualRavenConfig config = elastic();
  config.plant.amplifier_limit = 1.0;  // 3276.8 counts
  ArmPlant at_limit = goldArm(config), beyond = goldArm(config), below = goldArm(config);
  at_limit.step(dacOn(kShoulder, -3277), false);
  beyond.step(dacOn(kShoulder, -32000), false);
  below.step(dacOn(kShoulder, -3000), false);
  EXPECT_EQ(at_limit.motorRates(), beyond.motorRates());
  EXPECT_LT(below.motorRates()[kShoulder], beyond.motorRates()[kShoulder]);
}

TEST(Amplifier, SaturatesAlikeOnBothSides) {
  VirtualRavenConfig config = elastic();
  config.plant.amplifier_limit = 1.0;  // 3276.8 counts
  for (const int sign : {-1, 1}) {
    ArmPlant at_limit = goldArm(config), beyond = goldArm(config);
    at_limit.step(dacOn(kShoulder, sign * 3277), false);
    beyond.step(dacOn(kShoulder, sign * 32000), false);
    EXPECT_EQ(at_limit.motorRates(), beyond.motorRates()) << sign;
  }
}

TEST(Amplifier, AnOffsetIsACommandThatNobodyGave) {
  VirtualRavenConfig config = elastic();
  VirtualRavenConfig with_offset = config;
  with_offset.plant.amplifier_offset = -500.0 / 2730.0;
  ArmPlant commanded = goldArm(config), offset = goldArm(with_offset);
  for (int k = 0; k < 20; ++k) {
    commanded.step(dacOn(kShoulder, -500), false);
    offset.step(dacOn(kElbow, 500), false);  // cancels the offset of that channel
  }
  EXPECT_NEAR(offset.motorRates()[kShoulder], commanded.motorRates()[kShoulder],
              0.05 * std::abs(commanded.motorRates()[kShoulder]));
  EXPECT_GT(std::abs(commanded.motorRates()[kShoulder]), 1.0);
}

TEST(Cables, TwoElasticArmsGiveTheSameCounts) {
  ArmPlant first = goldArm(elastic(0.1)), second = goldArm(elastic(0.1));
  RandomCommands one, two;
  for (int k = 0; k < 500; ++k) {
    first.step(one.next(), false);
    second.step(two.next(), false);
    ASSERT_EQ(first.encoders(), second.encoders());
  }
}

#ifdef RAVEN2_COUNTS_ALLOCATIONS
TEST(Cables, SteppingDoesNotTouchTheHeap) {
  ArmPlant arm = goldArm(elastic());
  RandomCommands commands;
  const int calls = raven2_trainer::testing::allocatorCalls([&] {
    for (int k = 0; k < 1000; ++k)
      arm.step(commands.next(), k % 100 == 0);
  });
  EXPECT_EQ(calls, 0);
}
#endif

TEST(Cables, LedMotorsStretchElasticCablesAndTakeTheLinksAlongOnRigidOnes) {
  for (const Arm which : kArms) {
    for (const bool is_elastic : {true, false}) {
      VirtualRavenConfig config = elastic();
      config.plant.elastic_cables = is_elastic;
      ArmPlant arm(dhRaven(trainerConfig().arms), which, config);
      const Vector7 before = arm.jointPositions(), motors = arm.motorPositions() + Vector7::Constant(0.5);
      arm.leadMotors(motors, Vector7::Zero());
      EXPECT_EQ(arm.motorPositions(), motors) << name(which);
      if (is_elastic) {
        EXPECT_EQ(arm.jointPositions(), before) << name(which);
        EXPECT_LT((arm.cableStretch() - Vector7::Constant(0.5)).norm(), 1e-9) << name(which);
        continue;
      }
      JointArray turned{};
      for (std::size_t j = 0; j < kJointCount; ++j)
        turned[j] = motors[static_cast<Eigen::Index>(j)];
      const JointArray q = raven::CableCoupling(which, config).toJoint(turned);
      for (std::size_t j = 0; j < kJointCount; ++j)
        EXPECT_NEAR(arm.jointPositions()[static_cast<Eigen::Index>(j)], q[j], 1e-9) << name(which) << kJointNames[j];
      EXPECT_GT((arm.jointPositions() - before).norm(), 1e-3) << name(which);
    }
  }
}

}  // namespace
}  // namespace raven2_trainer::plant
