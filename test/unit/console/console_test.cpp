#include "raven2_trainer/console/console.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "console_support.h"
#include "raven2_trainer/core/random.h"

namespace raven2_trainer::console {
namespace {

Intent still(Tick) {
  Intent intent;
  intent.pedal = true;
  return intent;
}

ForcePacket forceX(double gold, std::uint32_t sequence = 0) {
  ForcePacket packet;
  packet.sequence = sequence;
  packet.force_I[0] = {gold, 0.0, 0.0};
  return packet;
}

Vec3 increment(const wire::ItpPacket& packet, Arm arm) {
  return {at(packet.delx_um, arm) * 1e-6, at(packet.dely_um, arm) * 1e-6, at(packet.delz_um, arm) * 1e-6};
}

TEST(Console, SendsPacketsWithThePedalUpBeforeTheRobotIsReady) {
  Console console(testConfig(), std::make_unique<FunctionSource>(still));
  for (std::uint32_t i = 1; i <= 1000; ++i) {
    const wire::ItpPacket packet = console.tick();
    ASSERT_EQ(packet.sequence, i);
    ASSERT_EQ(packet.surgeon_mode, 0);
    ASSERT_EQ(packet.checksum, wire::itpChecksum(packet));
    ASSERT_EQ(wire::checkItp(packet, {0}), Reject::kNone);  // no motion, unit quaternions
  }
  EXPECT_FALSE(console.finished());
}

TEST(Console, PressesThePedalStartDelayAfterTheRobotIsReady) {
  Console console(testConfig(), std::make_unique<FunctionSource>(still));
  for (int i = 0; i < 10; ++i)
    console.tick();
  console.setReady(true);
  for (int i = 0; i < 300; ++i)
    ASSERT_EQ(console.tick().surgeon_mode, 0) << i;
  EXPECT_EQ(console.tick().surgeon_mode, 1);
}

TEST(Console, ARobotThatIsNoLongerReadyStartsTheDelayAgain) {
  Console console(testConfig(), std::make_unique<FunctionSource>(still));
  console.setReady(true);
  for (int i = 0; i < 200; ++i)
    console.tick();
  console.setReady(false);
  for (int i = 0; i < 500; ++i)
    ASSERT_EQ(console.tick().surgeon_mode, 0);
  console.setReady(true);
  for (int i = 0; i < 300; ++i)
    ASSERT_EQ(console.tick().surgeon_mode, 0) << i;
  EXPECT_EQ(console.tick().surgeon_mode, 1);
}

TEST(Console, TakesThePedalUpRunLevelInAForcePacketAsReady) {
  Console console(testConfig(), std::make_unique<FunctionSource>(still));
  ForcePacket force;
  for (const std::uint8_t level : {0, 1}) {  // E-STOP, INIT
    force.runlevel = level;
    console.applyForce(force);
    for (int i = 0; i < 400; ++i)
      ASSERT_EQ(console.tick().surgeon_mode, 0);
  }
  force.runlevel = 2;
  console.applyForce(force);
  for (int i = 0; i < 300; ++i)
    ASSERT_EQ(console.tick().surgeon_mode, 0);
  EXPECT_EQ(console.tick().surgeon_mode, 1);
}

TEST(Console, SumOfIncrementsEqualsTheScaledMotionToHalfAMicrometreForEver) {
  Random random(4);
  for (const double scale : {0.05, 0.1, 0.15, 0.2, 1.0 / 3.0, 1.0}) {
    // GIVEN a smooth random walk of both hands and jaws, more than three minutes long
    PerArm<Vec3> hand{}, speed{};
    PerArm<double> jaws{};
    ConsoleConfig config = testConfig();
    config.scale = scale;
    Console console = readyConsole(config, [&](Tick) {
      Intent intent;
      intent.pedal = true;
      for (const Arm arm : kArms) {
        for (std::size_t k = 0; k < 3; ++k) {
          at(speed, arm)[k] = 0.99 * at(speed, arm)[k] + random.uniform(-1e-5, 1e-5);
          at(hand, arm)[k] += at(speed, arm)[k];
        }
        at(jaws, arm) += random.uniform(-1e-3, 1e-3);
      }
      intent.hand_I = hand;
      intent.grasp = jaws;
      return intent;
    });
    console.setReady(true);
    console.tick();
    const PerArm<Vec3> start = hand;
    const PerArm<double> start_jaws = jaws;
    PerArm<Vec3> sum{};
    PerArm<std::int64_t> closing{};
    for (int i = 0; i < 200000; ++i) {
      const wire::ItpPacket packet = console.tick();
      for (const Arm arm : kArms) {
        const Vec3 step = increment(packet, arm);
        at(closing, arm) += at(packet.grasp_mrad, arm);
        for (std::size_t k = 0; k < 3; ++k) {
          at(sum, arm)[k] += step[k];
          // half a micrometre and the rounding of 200,000 sums in this test
          ASSERT_NEAR(at(sum, arm)[k], scale * (at(hand, arm)[k] - at(start, arm)[k]), 0.501e-6) << i;
        }
        ASSERT_NEAR(static_cast<double>(at(closing, arm)), -1e3 * (at(jaws, arm) - at(start_jaws, arm)), 0.501) << i;
      }
    }
  }
}

TEST(Console, SendsNoMotionWhileThePedalIsUpAndLosesIt) {
  // GIVEN a hand that moves 1 mm a tick, the pedal up from tick 100 to 199
  const auto motion = [](Tick now) {
    Intent intent;
    intent.pedal = now < 100 || now >= 200;
    intent.hand_I[0] = {1e-3 * static_cast<double>(now), 0.0, 0.0};
    intent.grasp[0] = 1e-3 * static_cast<double>(now);
    return intent;
  };
  Console console = readyConsole(testConfig(), motion);
  console.setReady(true);
  int sum = 0;
  for (Tick now = 0; now < 300; ++now) {
    const wire::ItpPacket packet = console.tick();
    const bool moves = (now > 0 && now < 100) || now >= 200;  // the first packet starts the count
    ASSERT_EQ(packet.surgeon_mode != 0, now < 100 || now >= 200) << now;
    ASSERT_EQ(packet.delx_um[0], moves ? 100 : 0) << now;
    ASSERT_EQ(packet.grasp_mrad[0], moves ? -1 : 0) << now;
    ASSERT_EQ(packet.delx_um[1], 0);
    sum += packet.delx_um[0];
  }
  EXPECT_EQ(sum, 199 * 100);
}

TEST(Console, ClosingJawsArePositiveGrasp) {
  Console console = readyConsole(testConfig(), [](Tick now) {
    Intent intent;
    intent.pedal = true;
    intent.grasp = {now == 0 ? 1.0 : 0.9, now == 0 ? 0.2 : 0.25};  // gold closes, green opens
    return intent;
  });
  console.setReady(true);
  console.tick();
  const wire::ItpPacket packet = console.tick();
  EXPECT_EQ(packet.grasp_mrad[0], 100);
  EXPECT_EQ(packet.grasp_mrad[1], -50);
}

TEST(HandModel, IsDeflectedByForceOverStiffnessAtRest) {
  Console console = readyConsole(testConfig(), still);
  console.setReady(true);
  int sum_um = 0;
  for (int i = 0; i < 2000; ++i) {
    console.applyForce(forceX(1.0));
    sum_um += console.tick().delx_um[0];
  }
  EXPECT_NEAR(console.deflection()[0][0], 1.0 / 300.0, 1e-9);
  EXPECT_EQ(console.deflection()[0][1], 0.0);
  EXPECT_EQ(console.deflection()[1][0], 0.0);
  EXPECT_NEAR(sum_um, 1e6 * 0.1 / 300.0, 0.5);  // the robot's tip moves by a tenth of it
}

TEST(HandModel, FollowsTheStepResponseOfACriticallyDampedMassOnASpring) {
  ConsoleConfig config = testConfig();
  config.hand_damping = 2.0 * std::sqrt(config.hand_stiffness * config.hand_mass);
  Console console = readyConsole(config, still);
  console.setReady(true);
  const double omega = std::sqrt(config.hand_stiffness / config.hand_mass);
  for (int i = 1; i <= 300; ++i) {
    console.applyForce(forceX(1.0));
    console.tick();
    const double t = 0.001 * i;
    const double exact = (1.0 - std::exp(-omega * t) * (1.0 + omega * t)) / config.hand_stiffness;
    // first-order rule at 1 ms with omega = 32 rad/s: within 2 % of the final deflection
    ASSERT_NEAR(console.deflection()[0][0], exact, 0.02 / config.hand_stiffness) << i;
  }
}

TEST(HandModel, IsStableAtTheEndsOfTheConfigurationsRanges) {
  for (const double mass : {0.01, 5.0}) {
    for (const double stiffness : {1.0, 10000.0}) {
      for (const double damping : {0.0, 1000.0}) {
        ConsoleConfig config = testConfig();
        config.hand_mass = mass;
        config.hand_stiffness = stiffness;
        config.hand_damping = damping;
        Console console = readyConsole(config, still);
        console.setReady(true);
        for (int i = 0; i < 20000; ++i) {
          console.applyForce(forceX(1.0));
          console.tick();
          // an undamped mass swings to twice the deflection at rest, and no farther
          ASSERT_LE(std::abs(console.deflection()[0][0]), 2.1 / stiffness)
              << mass << " " << stiffness << " " << damping;
        }
      }
    }
  }
}

TEST(HandModel, FeelsNothingWhileThePedalIsUp) {
  Console console = readyConsole(testConfig(), [](Tick) { return Intent{}; });
  console.setReady(true);
  for (int i = 0; i < 100; ++i) {
    console.applyForce(forceX(3.0));
    console.tick();
  }
  EXPECT_EQ(console.deflection()[0], (Vec3{0, 0, 0}));
}

TEST(HandModel, ForgetsAForceThatIsNotRenewedFor50Ms) {
  Console console = readyConsole(testConfig(), still);
  console.setReady(true);
  console.applyForce(forceX(1.0));
  double before = 0.0;
  for (int i = 0; i < 50; ++i) {
    console.tick();
    EXPECT_GT(console.deflection()[0][0], before);
    before = console.deflection()[0][0];
  }
  for (int i = 0; i < 2000; ++i)
    console.tick();
  EXPECT_NEAR(console.deflection()[0][0], 0.0, 1e-9);
}

TEST(Console, IgnoresLateAndImpossibleForces) {
  Console console = readyConsole(testConfig(), still);
  console.setReady(true);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (std::uint32_t i = 0; i < 2000; ++i) {
    EXPECT_EQ(console.applyForce(forceX(1.0, 1000 + i)), Reject::kNone);
    EXPECT_EQ(console.applyForce(forceX(-2.0, 999 + i)), Reject::kOutOfOrder);  // arrives after a newer one
    EXPECT_EQ(console.applyForce(forceX(-2.0, 1000 + i)), Reject::kDuplicate);
    EXPECT_EQ(console.applyForce(forceX(nan, 1001 + i)), Reject::kOutOfRange);
    EXPECT_EQ(console.applyForce(forceX(1e6, 1001 + i)), Reject::kOutOfRange);
    console.tick();
  }
  EXPECT_NEAR(console.deflection()[0][0], 1.0 / 300.0, 1e-9);
}

TEST(Console, TakesForcesOfARestartedDaemon) {
  Console console = readyConsole(testConfig(), still);
  console.setReady(true);
  console.applyForce(forceX(1.0, 1000000));
  for (int i = 0; i < 60; ++i)
    console.tick();  // silence while it restarts
  for (std::uint32_t i = 1; i < 2000; ++i) {
    console.applyForce(forceX(1.0, i));
    console.tick();
  }
  EXPECT_NEAR(console.deflection()[0][0], 1.0 / 300.0, 1e-9);
}

class ConsoleHands : public ::testing::TestWithParam<Arm> {};

TEST_P(ConsoleHands, ImpossibleForcesAreRefusedOnEitherHandAxisAndSide) {
  const double inf = std::numeric_limits<double>::infinity();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const double bad : {-20.1, 20.1, -inf, inf, std::nan("")}) {
      Console console = readyConsole(testConfig(), still);
      ForcePacket force;
      force.sequence = 1;
      at(force.force_I, GetParam())[axis] = bad;
      EXPECT_EQ(console.applyForce(force), Reject::kOutOfRange) << axis << " " << bad;
      at(force.force_I, GetParam())[axis] = std::copysign(19.9, bad);
      EXPECT_EQ(console.applyForce(force), Reject::kNone);
    }
  }
}

TEST_P(ConsoleHands, AForcePushesItsOwnHandAlone) {
  Console console = readyConsole(testConfig(), still);
  console.setReady(true);
  ForcePacket force;
  at(force.force_I, GetParam()) = {-1.5, 0.0, 0.6};
  PerArm<Vec3> sum{};
  for (int i = 0; i < 2000; ++i) {
    ++force.sequence;
    ASSERT_EQ(console.applyForce(force), Reject::kNone);
    const wire::ItpPacket packet = console.tick();
    for (const Arm arm : kArms) {
      for (std::size_t k = 0; k < 3; ++k)
        at(sum, arm)[k] += increment(packet, arm)[k];
    }
  }
  for (std::size_t k = 0; k < 3; ++k) {
    const double pushed = at(force.force_I, GetParam())[k] / 300.0;
    EXPECT_NEAR(at(console.deflection(), GetParam())[k], pushed, 1e-9);
    EXPECT_NEAR(at(sum, GetParam())[k], 0.1 * pushed, 1.1e-6) << "the tool moves a tenth of it";
    EXPECT_EQ(at(console.deflection(), otherArm(GetParam()))[k], 0.0);
    EXPECT_EQ(at(sum, otherArm(GetParam()))[k], 0.0);
  }
}

INSTANTIATE_TEST_SUITE_P(Arms, ConsoleHands, ::testing::ValuesIn(kArms), [](const auto& tested) {
  return std::string(name(tested.param));
});

TEST(Console, NumbersOfForcesGoOnBeyondTheLargest) {
  Console console = readyConsole(testConfig(), still);
  const std::uint32_t largest = std::numeric_limits<std::uint32_t>::max();
  for (std::uint32_t i = 0; i < 6; ++i) {
    const std::uint32_t number = largest - 2 + i;
    EXPECT_EQ(console.applyForce(forceX(1.0, number)), Reject::kNone) << number;
    EXPECT_EQ(console.applyForce(forceX(1.0, number - 1)), Reject::kOutOfOrder) << number;
    EXPECT_EQ(console.applyForce(forceX(1.0, number)), Reject::kDuplicate) << number;
    console.tick();
  }
}

}  // namespace
}  // namespace raven2_trainer::console
