#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "console_support.h"
#include "raven2_trainer/core/random.h"
#include "raven2_trainer/kinematics/eigen.h"

// Orientation of the hands in the packets, and the images and forces that the surgeon receives.

namespace raven2_trainer::console {
namespace {

constexpr double kLargestTurn = 0.1;  // [rad] network.yaml, max_rotation

Quaternion turnOf(const wire::ItpPacket& packet, Arm arm) {
  return {at(packet.Qw, arm), at(packet.Qx, arm), at(packet.Qy, arm), at(packet.Qz, arm)};
}

double angleOf(const Quaternion& turn) {
  return 2.0 * std::atan2(turn.vec().norm(), std::abs(turn.w()));
}

Vector3 randomAxis(Random* random) {
  return Vector3(random->normal(), random->normal(), random->normal()).normalized();
}

Quat about(const Vector3& axis, double angle) {
  return toArray(Quaternion(Eigen::AngleAxisd(angle, axis)));
}

Intent pressed() {
  Intent intent;
  intent.pedal = true;
  return intent;
}

TEST(ConsoleTurn, ProductOfAllIncrementsIsTheWholeTurn) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    // GIVEN a simulated surgeon that rotates both hands at random, up to 50 rad/s
    Random random(seed);
    PerArm<Quaternion> wanted{Quaternion::Identity(), Quaternion::Identity()};
    Console console = readyConsole(testConfig(), [&](Tick) {
      Intent intent = pressed();
      for (const Arm arm : kArms) {
        const Quaternion step(Eigen::AngleAxisd(random.uniform(0.0, 0.05), randomAxis(&random)));
        at(wanted, arm) = (step * at(wanted, arm)).normalized();
        // a rotation has two quaternions
        const double sign = random.uniform(0.0, 1.0) < 0.5 ? -1.0 : 1.0;
        at(intent.turn_I, arm) = toArray(Quaternion(sign * at(wanted, arm).coeffs()));
      }
      return intent;
    });
    console.setReady(true);
    console.tick();
    const PerArm<Quaternion> start = wanted;
    PerArm<Quaternion> product{Quaternion::Identity(), Quaternion::Identity()};
    for (int i = 0; i < 20000; ++i) {
      const wire::ItpPacket packet = console.tick();
      ASSERT_EQ(wire::checkItp(packet, {1, kLargestTurn}), Reject::kNone) << i;
      for (const Arm arm : kArms) {
        at(product, arm) = (turnOf(packet, arm) * at(product, arm)).normalized();
        const Quaternion whole = at(wanted, arm) * at(start, arm).conjugate();
        ASSERT_NEAR(angleOf(at(product, arm).conjugate() * whole), 0.0, 1e-9) << i;
      }
    }
  }
}

TEST(ConsoleTurn, WhatOnePacketMayNotHoldFollowsInTheNext) {
  Random random(7);
  for (int round = 0; round < 50; ++round) {
    const Quat far = about(randomAxis(&random), random.uniform(0.2, 3.1));
    Console console = readyConsole(testConfig(), [&](Tick now) {
      Intent intent = pressed();
      if (now > 0) intent.turn_I = {far, far};
      return intent;
    });
    console.setReady(true);
    console.tick();
    Quaternion product = Quaternion::Identity();
    const int needed = static_cast<int>(std::ceil(angleOf(toEigen(far)) / 0.099));
    for (int i = 0; i < needed; ++i) {
      ASSERT_GT(angleOf(product.conjugate() * toEigen(far)), 1e-6) << "done too early";
      const Quaternion step = turnOf(console.tick(), Arm::kGreen);
      ASSERT_LT(angleOf(step), kLargestTurn);
      product = step * product;
    }
    EXPECT_NEAR(angleOf(product.conjugate() * toEigen(far)), 0.0, 1e-9);
    EXPECT_EQ(console.tick().Qw[1], 1.0) << "no rotation after it";
  }
}

/** 2 rad need 21 packets; the pedal goes up after three, and the hand is 0.02 rad further when it is down again. */
TEST(ConsoleTurn, WhatIsLeftOfATurnEndsWithThePedal) {
  const Vector3 axis = Vector3(1.0, -2.0, 2.0) / 3.0;
  Console console = readyConsole(testConfig(), [&](Tick now) {
    Intent intent;
    intent.pedal = now < 4 || now >= 10;
    if (now > 0) intent.turn_I = {about(axis, now < 20 ? 2.0 : 2.02), about(axis, now < 20 ? -2.0 : -2.02)};
    return intent;
  });
  console.setReady(true);
  PerArm<Quaternion> product{Quaternion::Identity(), Quaternion::Identity()};
  for (Tick now = 0; now < 60; ++now) {
    const wire::ItpPacket packet = console.tick();
    for (const Arm arm : kArms)
      at(product, arm) = now < 10 ? Quaternion::Identity() : turnOf(packet, arm) * at(product, arm);
  }
  for (const Arm arm : kArms) {
    const Quaternion expected = toEigen(about(axis, arm == Arm::kGold ? 0.02 : -0.02));
    EXPECT_NEAR(angleOf(at(product, arm).conjugate() * expected), 0.0, 1e-6) << name(arm);
  }
}

TEST(ConsoleTurn, AHandThatDoesNotTurnSendsTheIdentityToTheBit) {
  const Quat still = about({0.6, 0.0, 0.8}, 1.0);
  Console console = readyConsole(testConfig(), [&](Tick) {
    Intent intent = pressed();
    intent.turn_I = {still, still};
    return intent;
  });
  console.setReady(true);
  const wire::ItpBytes never_turned = wire::encodeItp(wire::ItpPacket{});
  for (int i = 0; i < 100; ++i) {
    wire::ItpPacket packet = console.tick();
    packet.sequence = 0;
    packet.surgeon_mode = packet.checksum = 0;
    ASSERT_EQ(wire::encodeItp(packet), never_turned) << i;
  }
}

TEST(ConsoleTurn, WithThePedalUpHandsTurnAndTheRobotDoesNot) {
  const Vector3 axis = Vector3(1.0, -2.0, 0.5).normalized();
  Console console = readyConsole(testConfig(), [&](Tick now) {
    Intent intent;
    intent.pedal = now < 100 || now >= 200;
    intent.turn_I[0] = about(axis, 0.01 * static_cast<double>(now));
    return intent;
  });
  console.setReady(true);
  Quaternion product = Quaternion::Identity();
  for (Tick now = 0; now < 300; ++now) {
    const Quaternion step = turnOf(console.tick(), Arm::kGold);
    const bool moves = (now > 0 && now < 100) || now >= 200;
    ASSERT_NEAR(angleOf(step), moves ? 0.01 : 0.0, 1e-12) << now;
    product = step * product;
  }
  EXPECT_NEAR(angleOf(product.conjugate() * toEigen(about(axis, 0.01 * 199))), 0.0, 1e-12);
}

/** Keeps the senses that it receives. */
class SensingSource : public MotionSource {
 public:
  explicit SensingSource(Senses* senses) : senses_(senses) {}
  Intent tick(const Senses& senses) override {
    *senses_ = senses;
    Intent intent = pressed();
    intent.pedals = bit(Pedal::kTrial) | bit(Pedal::kStop);
    return intent;
  }

 private:
  Senses* senses_;
};

class ConsoleSenses : public ::testing::Test {
 protected:
  ConsoleSenses() : console_(atOnce(), std::make_unique<SensingSource>(&senses_)) { console_.setReady(true); }

  static ConsoleConfig atOnce() {
    ConsoleConfig config = testConfig();
    config.start_delay = 0.0;
    return config;
  }
  static Sight picture(std::uint32_t sequence, double opening) {
    Sight sight;
    sight.sequence = sequence;
    sight.opening[0] = opening;
    return sight;
  }

  Senses senses_;
  Console console_;
};

TEST_F(ConsoleSenses, ShowsTheNewestPictureAndNoneBeforeTheFirst) {
  console_.tick();
  EXPECT_FALSE(senses_.sight.has_value());
  EXPECT_EQ(console_.applySight(picture(5, 0.5)), Reject::kNone);
  EXPECT_EQ(console_.applySight(picture(4, 0.4)), Reject::kOutOfOrder);
  EXPECT_EQ(console_.applySight(picture(5, 0.4)), Reject::kDuplicate);
  console_.tick();
  ASSERT_TRUE(senses_.sight.has_value());
  EXPECT_EQ(senses_.sight->opening[0], 0.5);
  EXPECT_EQ(console_.applySight(picture(6, 0.6)), Reject::kNone);
  console_.tick();
  EXPECT_EQ(senses_.sight->opening[0], 0.6);
}

TEST_F(ConsoleSenses, DoesNotShowWhatCannotBe) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(console_.applySight(picture(1, nan)), Reject::kNotFinite);
  Sight sight = picture(1, 0.1);
  sight.bodies_W[3].p[1] = nan;
  EXPECT_EQ(console_.applySight(sight), Reject::kNotFinite);
  sight = picture(1, 0.1);
  sight.tool_W[1].q = {0.0, 0.0, 0.0, 0.0};
  EXPECT_EQ(console_.applySight(sight), Reject::kNotFinite);
  console_.tick();
  EXPECT_FALSE(senses_.sight.has_value());
}

TEST_F(ConsoleSenses, TakesPicturesOfARestartedDaemon) {
  EXPECT_EQ(console_.applySight(picture(1000000, 0.5)), Reject::kNone);
  for (int i = 0; i < 500; ++i)
    console_.tick();
  EXPECT_EQ(console_.applySight(picture(1, 0.1)), Reject::kNone);
}

TEST_F(ConsoleSenses, FeelsForceAndDeflectionAndForgetsThem) {
  ForcePacket force;
  force.runlevel = 3;
  force.force_I[1] = {0.0, 1.5, 0.0};
  console_.applyForce(force);
  console_.tick();
  EXPECT_EQ(senses_.force.force_I[1][1], 1.5);
  EXPECT_EQ(senses_.deflection[1][1], 0.0) << "as it was before this force";
  console_.tick();
  EXPECT_GT(senses_.deflection[1][1], 0.0);
  for (int i = 0; i < 60; ++i)
    console_.tick();
  EXPECT_EQ(senses_.force.force_I[1][1], 0.0);
  EXPECT_EQ(senses_.force.runlevel, 3);
}

TEST_F(ConsoleSenses, TellsThePedalsBesideTheOneOfItp) {
  EXPECT_EQ(console_.pedals(), 0u);
  console_.tick();
  EXPECT_EQ(console_.pedals(), bit(Pedal::kTrial) | bit(Pedal::kStop));
}

TEST_F(ConsoleSenses, EveryNumberOfAPictureIsLookedAt) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  std::uint32_t sequence = 0;
  for (const Arm arm : kArms) {
    Sight sight = picture(++sequence, 0.1);
    at(sight.opening, arm) = nan;
    EXPECT_EQ(console_.applySight(sight), Reject::kNotFinite) << name(arm);
    for (std::size_t k = 0; k < 4; ++k) {
      sight = picture(++sequence, 0.1);
      (k < 3 ? at(sight.tool_W, arm).p[k] : at(sight.tool_W, arm).q[0]) = nan;
      EXPECT_EQ(console_.applySight(sight), Reject::kNotFinite) << name(arm) << k;
    }
  }
  EXPECT_EQ(console_.applySight(picture(1, 0.1)), Reject::kNone) << "a rejected picture does not count as seen";
}

TEST_F(ConsoleSenses, APictureKeepsOlderOnesOutForHalfASecond) {
  for (int round = 0; round < 3; ++round) {
    const std::uint32_t newest = 1000U - 100U * static_cast<std::uint32_t>(round);
    ASSERT_EQ(console_.applySight(picture(newest, 0.5)), Reject::kNone) << round;
    for (int i = 0; i < 499; ++i)
      console_.tick();
    EXPECT_EQ(console_.applySight(picture(newest - 100, 0.1)), Reject::kOutOfOrder) << round;
    console_.tick();
  }
}

TEST(ConsoleTurn, ThePedalUpDiscardsTheRestOfATurn) {
  const Quat far = about({0.0, 0.0, 1.0}, 2.0);
  Console console = readyConsole(testConfig(), [&](Tick now) {
    Intent intent;
    intent.pedal = now < 5 || now >= 10;
    if (now > 0) intent.turn_I = {far, far};
    return intent;
  });
  console.setReady(true);
  for (Tick now = 0; now < 30; ++now) {
    const wire::ItpPacket packet = console.tick();
    for (const Arm arm : kArms)
      EXPECT_NEAR(angleOf(turnOf(packet, arm)), now > 0 && now < 5 ? 0.099 : 0.0, 1e-9) << now;
  }
}

}  // namespace
}  // namespace raven2_trainer::console
