#include <gtest/gtest.h>

#include "conformance/robot.h"
#include "raven2_trainer/core/random.h"
#include "support/effort.h"

// The study mode of the virtual Raven: the daemon's own checks in place of a real Raven's rules.

namespace raven2_trainer::conformance {
namespace {

constexpr int kSettle = 150;  // [cycles] the clipped motors need some 70 for a step of 2 mm on each axis

VirtualRavenConfig hardened() {
  VirtualRavenConfig config = atHome();
  config.behaviour = "hardened";
  return config;
}

/** Brings the robot to PEDAL_DN. A hardened robot needs packets with the pedal up first. */
void introduceAndEngage(Robot* robot) {
  for (int k = 0; k < 5; ++k) {
    robot->send(robot->packet(0));
    robot->cycle();
  }
  robot->engage();
}

/** Moves the robot away from home, slow enough for the motors to follow, and lets it come to rest. */
void wander(Robot* robot, Random* random) {
  wire::ItpPacket p;
  p.surgeon_mode = 1;
  for (auto* pair : {&p.delx_um, &p.dely_um, &p.delz_um}) {
    for (std::int32_t& um : *pair)
      um = static_cast<std::int32_t>(std::lround(random->uniform(-30.0, 30.0)));
  }
  for (int k = 0; k < 700; ++k) {
    if (k == 400) p.delx_um = p.dely_um = p.delz_um = {};
    p.sequence = ++robot->sequence;
    robot->send(p);
    robot->cycle();
  }
}

std::int32_t within(Random* random, std::int32_t limit) {
  return static_cast<std::int32_t>(std::lround(random->uniform(-limit, limit)));
}

/** Half of these packets have arbitrary values, the other half values up to the limits. */
wire::ItpPacket randomPacket(Robot* robot, Random* random) {
  const ItpRules& limits = packaged().network.itp;
  wire::ItpPacket p = robot->packet();
  const bool anything = random->next() % 2 == 0;
  const auto um = [&] {
    if (anything && random->next() % 4 == 0) return static_cast<std::int32_t>(random->next());
    return random->next() % 2 == 0 ? within(random, limits.max_increment_um)
                                   : (random->next() % 2 == 0 ? 1 : -1) * limits.max_increment_um;
  };
  for (std::size_t arm = 0; arm < kArmCount; ++arm) {
    p.delx_um[arm] = um();
    p.dely_um[arm] = um();
    p.delz_um[arm] = um();
    p.grasp_mrad[arm] = anything ? static_cast<std::int32_t>(random->next()) : within(random, 1745);
    const double half = 0.5 * random->uniform(0.0, (anything ? 2.0 : 1.0) * limits.max_rotation);
    const Vector3 axis = Vector3(random->normal(), random->normal(), random->normal()).normalized() * std::sin(half);
    p.Qx[arm] = axis.x();
    p.Qy[arm] = axis.y();
    p.Qz[arm] = axis.z();
    p.Qw[arm] = anything && random->next() % 8 == 0 ? random->normal() : std::cos(half);
  }
  p.surgeon_mode = anything ? static_cast<std::int32_t>(random->next() % 4) - 1 : 1;
  if (anything && random->next() % 4 == 0) p.sequence = random->next();
  return p;
}

TEST(Hardened, NoSinglePacketStopsTheRobot) {
  Random random(6);
  const std::int64_t packets = testing::effort(250, 100000);
  std::int64_t used = 0;
  std::unique_ptr<Robot> robot;
  for (std::int64_t n = 0; n < packets; ++n) {
    if (n % 10 == 0) {  // from home again, so that packets do not add up to the edge
      robot = std::make_unique<Robot>(hardened());
      introduceAndEngage(robot.get());
      wander(robot.get(), &random);
    }
    const std::uint32_t number = robot->sequence;
    used += robot->send(randomPacket(robot.get(), &random)) ? 1 : 0;
    robot->sequence = number + 2;  // the surgeon's next packet is in order, whether this one was used or not
    for (int k = 0; k < kSettle; ++k) {
      robot->send(robot->packet());
      robot->cycle();
      ASSERT_EQ(robot->software.state().soft_estopped, 0) << "packet " << n;
      ASSERT_NE(robot->level(), RunLevel::kEStop) << "packet " << n;
    }
  }
  EXPECT_GT(used, packets / 4) << "the limits refused so many packets that the test shows nothing";
}

/** Whether one packet of this many micrometres on each axis of both arms, with these signs, stops a robot at home. */
bool stops(const VirtualRavenConfig& config, int um, unsigned signs) {
  Robot robot(config);
  introduceAndEngage(&robot);
  wire::ItpPacket p = robot.packet();
  std::size_t axis = 0;
  for (auto* pair : {&p.delx_um, &p.dely_um, &p.delz_um}) {
    pair->fill((signs >> axis & 1U) != 0 ? um : -um);
    ++axis;
  }
  const wire::ItpBytes bytes = wire::encodeItp(p);
  robot.software.receive(bytes.data(), bytes.size());
  for (int k = 0; k < 100; ++k) {
    robot.cycle();
    robot.send(robot.packet());
    if (robot.software.state().soft_estopped != 0) return true;
  }
  return false;
}

TEST(Hardened, APacketThatStopsARavenIsRefused) {
  int raven = 0;
  for (unsigned signs = 0; signs < 8; ++signs) {
    raven += stops(atHome(), 10000, signs) ? 1 : 0;
    EXPECT_FALSE(stops(hardened(), 10000, signs)) << signs;
    EXPECT_FALSE(stops(hardened(), packaged().network.itp.max_increment_um, signs)) << signs;
  }
  EXPECT_GE(raven, 4) << "a centimetre in a packet does not stop a real Raven";
}

TEST(Hardened, NoPacketClearsAnEStop) {
  for (const VirtualRavenConfig& config : {atHome(), hardened()}) {
    Robot robot(config);
    introduceAndEngage(&robot);
    for (int k = 0; k < 250; ++k)
      robot.plant.step(robot.out);  // no edge of the watchdog for more than 200 cycles
    robot.cycles(50);
    ASSERT_EQ(robot.level(), RunLevel::kEStop);
    Random random(8);
    for (int n = 0; n < 3000; ++n) {
      robot.send(n % 3 == 0 ? randomPacket(&robot, &random) : robot.packet(n / 100 % 2));
      robot.cycle();
      ASSERT_EQ(robot.level(), RunLevel::kEStop) << n;
    }
  }
}

TEST(Hardened, ThePedalComesUpAfterTheTimeOutOfTheIngest) {
  Robot robot(hardened());
  introduceAndEngage(&robot);
  int cycles = 0;
  while (robot.level() == RunLevel::kPedalDown && cycles < 1000) {
    robot.cycle();
    ++cycles;
  }
  EXPECT_GE(cycles, 200);
  EXPECT_LE(cycles, 220);  // and the PLC's answer
}

/** Outside PEDAL_DN nobody else counts its silence. */
TEST(Hardened, ThePedalOfADeadMasterDoesNotEngageARobotThatStartsAgain) {
  Robot robot(hardened());
  introduceAndEngage(&robot);
  for (int k = 0; k < 250; ++k)
    robot.plant.step(robot.out);  // no edge of the watchdog for more than 200 cycles
  robot.cycles(300);
  ASSERT_EQ(robot.level(), RunLevel::kEStop);
  robot.plant.pressStart();
  for (int k = 0; k < 200; ++k) {
    robot.cycle();
    ASSERT_NE(robot.level(), RunLevel::kPedalDown) << k;
  }
  EXPECT_EQ(robot.level(), RunLevel::kPedalUp);
}

TEST(Hardened, AutomovesDoNotKeepThePedalOfADeadMasterDown) {
  Robot robot(hardened());
  introduceAndEngage(&robot);
  int cycles = 0;
  while (robot.level() == RunLevel::kPedalDown && cycles < 1000) {
    robot.software.automove({}, {kIdentityQuat, kIdentityQuat});
    robot.cycle();
    ++cycles;
  }
  EXPECT_GE(cycles, 200);
  EXPECT_LE(cycles, 220);
}

TEST(Hardened, ASignedPacketIsUsedByAnUnmodifiedRaven) {
  const wire::ItpKey key(std::array<std::uint8_t, wire::ItpKey::kSize>{});
  const wire::ItpSession session(key, wire::Audience::kRobot, wire::Nonce{}, wire::Nonce{});
  Robot robot;  // compat
  for (std::uint64_t n = 1; n <= 100; ++n) {
    const wire::SignedItpBytes bytes = session.sign(wire::encodeItp(robot.packet()), n);
    robot.software.receive(bytes.data(), bytes.size());
    robot.cycle();
  }
  EXPECT_EQ(robot.software.state().itp.applied, 100U);
  EXPECT_EQ(robot.level(), RunLevel::kPedalDown);
  const wire::HandshakeBytes hello = wire::encodeHello(key, wire::Audience::kRobot, wire::Nonce{});
  robot.software.receive(hello.data(), hello.size());
  EXPECT_EQ(robot.software.state().itp.rejected[static_cast<std::size_t>(Reject::kWrongSize)], 1U);
  EXPECT_EQ(robot.level(), RunLevel::kPedalDown);
}

TEST(Hardened, AHelloOfAnotherKeyIsCountedAndNotAnswered) {
  std::array<std::uint8_t, wire::ItpKey::kSize> other{};
  other[0] = 1;
  const wire::ItpKey key(std::array<std::uint8_t, wire::ItpKey::kSize>{});
  VirtualRavenConfig config = hardened();
  config.itp.auth = ItpAuth::kRequired;
  raven::ControlSoftware software(packaged().arms, config, &key);
  wire::HandshakeBytes reply;
  const auto hello = [&](const wire::ItpKey& of) {
    const wire::HandshakeBytes bytes = wire::encodeHello(of, wire::Audience::kRobot, wire::Nonce{});
    return software.receive(bytes.data(), bytes.size(), 0, wire::Nonce{}, &reply);
  };
  EXPECT_FALSE(hello(wire::ItpKey(other)));
  EXPECT_EQ(software.state().itp.rejected[static_cast<std::size_t>(Reject::kBadSignature)], 1U);
  EXPECT_EQ(software.state().itp.received, 1U);
  EXPECT_TRUE(hello(key));
}

TEST(Hardened, APacketBehindLostOnesIsUsedAndItsNumberReported) {
  Robot robot(hardened());
  introduceAndEngage(&robot);
  for (const std::uint32_t lost : {1U, 2U, 20U}) {  // a Raven drops the packet behind a gap
    robot.sequence += lost;
    EXPECT_TRUE(robot.send(robot.packet())) << lost;
    robot.cycle();
    EXPECT_EQ(robot.software.state().last_sequence, robot.sequence) << lost;
    EXPECT_TRUE(robot.send(robot.packet())) << lost;
    robot.cycle();
  }
}

TEST(Hardened, ASecondMasterIsHeardOnceTheFirstIsSilentWhateverTheDaemonTakes) {
  for (const bool daemon_is_hardened : {true, false}) {
    VirtualRavenConfig config = hardened();
    config.itp.hardened = daemon_is_hardened;  // `ingest` of network.yaml is the daemon's
    Robot robot(config);
    introduceAndEngage(&robot);  // from source 0
    const auto isUsedFrom = [&](std::uint64_t source) {
      const std::uint64_t before = robot.software.state().itp.applied;
      const wire::ItpBytes bytes = wire::encodeItp(robot.packet(0));
      robot.software.receive(bytes.data(), bytes.size(), source);
      robot.cycle();
      return robot.software.state().itp.applied > before;
    };
    EXPECT_FALSE(isUsedFrom(99)) << "two masters at once";
    robot.cycles(600);
    EXPECT_TRUE(isUsedFrom(99)) << "half a second later the first one may be replaced";
    EXPECT_FALSE(isUsedFrom(0)) << "the first one came back too late";
  }
}

}  // namespace
}  // namespace raven2_trainer::conformance
