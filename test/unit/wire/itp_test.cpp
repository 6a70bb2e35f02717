#include "raven2_trainer/wire/itp.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "hex.h"
#include "raven2_trainer/core/random.h"

namespace raven2_trainer::wire {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

// struct.pack('<3I6i8d6i', 0x01020304, 7, 9, 1000, -2000, 3, -4, -500000, 600000, 0, .5, 0, -.5, 0, .5, 1, .5, 1, 0,
//             100, -100, 1, checksum), checksum = 1 + 1000 - 2000 + 3 - 4 - 500000 + 600000 + 1 + 0 + 0x01020304
const char* const kItpVector =
    "040302010700000009000000e803000030f8ffff03000000fcffffffe05ef8ff"
    "c02709000000000000000000000000000000e03f000000000000000000000000"
    "0000e0bf0000000000000000000000000000e03f000000000000f03f00000000"
    "0000e03f0100000000000000640000009cffffff01000000bd850301";

ItpPacket vectorPacket() {
  ItpPacket packet;
  packet.sequence = 0x01020304;
  packet.pactyp = 7;
  packet.version = 9;
  packet.delx_um = {1000, -2000};
  packet.dely_um = {3, -4};
  packet.delz_um = {-500000, 600000};
  packet.Qx = {0.0, 0.5};
  packet.Qy = {0.0, -0.5};
  packet.Qz = {0.0, 0.5};
  packet.Qw = {1.0, 0.5};
  packet.buttonstate = {1, 0};
  packet.grasp_mrad = {100, -100};
  packet.surgeon_mode = 1;
  packet.checksum = 1 + 1000 - 2000 + 3 - 4 - 500000 + 600000 + 1 + 0 + 0x01020304;
  return packet;
}

void expectEqual(const ItpPacket& a, const ItpPacket& b) {
  EXPECT_EQ(a.sequence, b.sequence);
  EXPECT_EQ(a.pactyp, b.pactyp);
  EXPECT_EQ(a.version, b.version);
  EXPECT_EQ(a.delx_um, b.delx_um);
  EXPECT_EQ(a.dely_um, b.dely_um);
  EXPECT_EQ(a.delz_um, b.delz_um);
  EXPECT_EQ(a.Qx, b.Qx);
  EXPECT_EQ(a.Qy, b.Qy);
  EXPECT_EQ(a.Qz, b.Qz);
  EXPECT_EQ(a.Qw, b.Qw);
  EXPECT_EQ(a.buttonstate, b.buttonstate);
  EXPECT_EQ(a.grasp_mrad, b.grasp_mrad);
  EXPECT_EQ(a.surgeon_mode, b.surgeon_mode);
  EXPECT_EQ(a.checksum, b.checksum);
}

TEST(Itp, EncodesTheBytesThatPythonStructPacks) {
  const std::vector<std::uint8_t> expected = fromHex(kItpVector);
  ASSERT_EQ(expected.size(), kItpSize);
  const ItpBytes bytes = encodeItp(vectorPacket());
  EXPECT_EQ(std::vector<std::uint8_t>(bytes.begin(), bytes.end()), expected);
}

TEST(Itp, DecodesTheBytesThatPythonStructPacks) {
  const std::vector<std::uint8_t> bytes = fromHex(kItpVector);
  ItpPacket packet;
  ASSERT_EQ(decodeItp(bytes.data(), bytes.size(), &packet), Reject::kNone);
  expectEqual(packet, vectorPacket());
}

TEST(Itp, RefusesEverySizeBut124AndLeavesThePacketAlone) {
  const std::vector<std::uint8_t> bytes(300, 0x5a);
  ItpPacket packet = vectorPacket();
  for (std::size_t size = 0; size <= bytes.size(); ++size) {
    if (size == kItpSize) continue;
    ASSERT_EQ(decodeItp(bytes.data(), size, &packet), Reject::kWrongSize) << size;
  }
  expectEqual(packet, vectorPacket());
}

TEST(ItpChecksum, IsTheSumOfModeIncrementsButtonsAndSequence) {
  EXPECT_EQ(itpChecksum(vectorPacket()), 1 + 1000 - 2000 + 3 - 4 - 500000 + 600000 + 1 + 0 + 0x01020304);
  ItpPacket packet = vectorPacket();
  // quaternions, grasp, pactyp and version are not covered
  packet.Qx = {0.1, 0.2};
  packet.grasp_mrad = {5, 6};
  packet.pactyp = packet.version = 0;
  EXPECT_EQ(itpChecksum(packet), itpChecksum(vectorPacket()));
}

TEST(ItpChecksum, WrapsAsTheRobotsSignedIntDoes) {
  ItpPacket packet;
  packet.sequence = 0xFFFFFFFFU;  // (int)sequence is -1
  EXPECT_EQ(itpChecksum(packet), -1);
  packet.sequence = 0;
  packet.delx_um = {std::numeric_limits<std::int32_t>::max(), 1};
  EXPECT_EQ(itpChecksum(packet), std::numeric_limits<std::int32_t>::min());
}

TEST(ItpCheck, AcceptsIncrementsAtTheLimitAndRejectsOneMicrometreMore) {
  for (const std::int32_t sign : {-1, 1}) {
    for (auto field : {&ItpPacket::delx_um, &ItpPacket::dely_um, &ItpPacket::delz_um}) {
      for (const Arm arm : kArms) {
        ItpPacket packet;
        at(packet.*field, arm) = sign * 2000;
        EXPECT_EQ(checkItp(packet, {2000}), Reject::kNone);
        at(packet.*field, arm) = sign * 2001;
        EXPECT_EQ(checkItp(packet, {2000}), Reject::kOutOfRange);
      }
    }
  }
}

TEST(ItpCheck, RejectsTheSmallestInteger) {
  ItpPacket packet;
  packet.dely_um[1] = std::numeric_limits<std::int32_t>::min();  // its absolute value does not exist
  EXPECT_EQ(checkItp(packet, {2000}), Reject::kOutOfRange);
}

TEST(ItpCheck, RejectsAGraspIncrementBeyondTheWholeRangeOfTheJaws) {
  ItpPacket packet;
  packet.grasp_mrad = {1745, -1745};
  EXPECT_EQ(checkItp(packet, {2000}), Reject::kNone);
  packet.grasp_mrad = {0, 1746};
  EXPECT_EQ(checkItp(packet, {2000}), Reject::kOutOfRange);
}

TEST(ItpCheck, AcceptsRotationsUpToTheLimitOfBothArmsAboutAnyAxisAndOfEitherSignOfTheQuaternion) {
  for (const Arm arm : kArms) {
    for (auto axis : {&ItpPacket::Qx, &ItpPacket::Qy, &ItpPacket::Qz}) {
      for (const double angle : {-0.1001, -0.0999, 0.0999, 0.1001}) {
        for (const double sign : {-1.0, 1.0}) {
          ItpPacket packet;
          at(packet.*axis, arm) = sign * std::sin(angle / 2.0);
          at(packet.Qw, arm) = sign * std::cos(angle / 2.0);
          EXPECT_EQ(checkItp(packet, {2000, 0.1}), std::abs(angle) > 0.1 ? Reject::kOutOfRange : Reject::kNone)
              << name(arm) << " " << angle << " " << sign;
        }
      }
    }
  }
}

TEST(ItpCheck, RejectsWhatIsNotFinite) {
  for (const double bad : {kNan, kInf, -kInf}) {
    for (auto field : {&ItpPacket::Qx, &ItpPacket::Qy, &ItpPacket::Qz, &ItpPacket::Qw}) {
      for (const Arm arm : kArms) {
        ItpPacket packet;
        at(packet.*field, arm) = bad;
        EXPECT_EQ(checkItp(packet, {2000}), Reject::kNotFinite);
      }
    }
  }
}

TEST(ItpCheck, RejectsQuaternionsFarFromUnitLength) {
  for (const double norm : {0.0, 0.979, 1.021, 2.0}) {
    ItpPacket packet;
    packet.Qw[1] = norm;
    EXPECT_EQ(checkItp(packet, {2000}), Reject::kBadQuaternion) << norm;
  }
  for (const double norm : {0.981, 1.0, 1.019}) {
    ItpPacket packet;
    packet.Qw[1] = -norm;
    EXPECT_EQ(checkItp(packet, {2000}), Reject::kNone) << norm;
  }
}

TEST(ItpCommand, TurnsMicrometresAndMilliradiansIntoSiUnits) {
  const MasterCommand command = toCommand(vectorPacket());
  EXPECT_EQ(command.sequence, 0x01020304U);
  EXPECT_EQ(command.pedal, 1);
  EXPECT_DOUBLE_EQ(command.dp_I[0][0], 1e-3);
  EXPECT_DOUBLE_EQ(command.dp_I[1][0], -2e-3);
  EXPECT_DOUBLE_EQ(command.dp_I[0][1], 3e-6);
  EXPECT_DOUBLE_EQ(command.dp_I[1][2], 0.6);
  EXPECT_DOUBLE_EQ(command.dgrasp[0], 0.1);  // positive closes
  EXPECT_DOUBLE_EQ(command.dgrasp[1], -0.1);
  EXPECT_EQ(command.dq_I[1], (Quat{0.5, -0.5, 0.5, 0.5}));
}

TEST(ItpCommand, RenormalisesQuaternions) {
  ItpPacket packet;
  packet.Qx[0] = 0.6 * 1.015;
  packet.Qw[0] = 0.8 * 1.015;
  const MasterCommand command = toCommand(packet);
  EXPECT_NEAR(command.dq_I[0][0], 0.6, 1e-15);
  EXPECT_NEAR(command.dq_I[0][3], 0.8, 1e-15);
}

TEST(ItpCommand, AnySurgeonModeButZeroIsPedalDown) {
  ItpPacket packet;
  EXPECT_EQ(toCommand(packet).pedal, 0);
  for (const std::int32_t mode : {1, 2, -1}) {
    packet.surgeon_mode = mode;
    EXPECT_EQ(toCommand(packet).pedal, 1);
  }
}

TEST(ItpCommand, SurvivesTheWireAtOneMicrometre) {
  Random random(3);
  for (int i = 0; i < 1000; ++i) {
    MasterCommand command;
    command.sequence = random.next();
    command.pedal = static_cast<std::uint8_t>(random.next() & 1U);
    for (const Arm arm : kArms) {
      for (double& x : at(command.dp_I, arm))
        x = random.uniform(-2e-3, 2e-3);
      at(command.dgrasp, arm) = random.uniform(-0.1, 0.1);
    }
    const ItpPacket packet = fromCommand(command);
    EXPECT_EQ(packet.checksum, itpChecksum(packet));
    const MasterCommand back = toCommand(packet);
    EXPECT_EQ(back.sequence, command.sequence);
    EXPECT_EQ(back.pedal, command.pedal);
    for (const Arm arm : kArms) {
      for (std::size_t k = 0; k < 3; ++k)
        ASSERT_NEAR(at(back.dp_I, arm)[k], at(command.dp_I, arm)[k], 0.5001e-6);
      ASSERT_NEAR(at(back.dgrasp, arm), at(command.dgrasp, arm), 0.5001e-3);
    }
  }
}

TEST(ItpCommand, CarriesTheRotationOfBothArmsAndWhoeversPedal) {
  Random random(4);
  for (const std::uint8_t pedal : {std::uint8_t{0}, kSurgeonsPedal, kClientsPedal}) {
    MasterCommand command;
    command.pedal = pedal;
    for (const Arm arm : kArms) {
      double squares = 0.0;
      for (double& x : at(command.dq_I, arm)) {
        x = random.uniform(-1.0, 1.0);
        squares += x * x;
      }
      for (double& x : at(command.dq_I, arm))
        x /= std::sqrt(squares);
    }
    const ItpPacket packet = fromCommand(command);
    EXPECT_EQ(packet.surgeon_mode, pedal != 0 ? 1 : 0) << "a hardened receiver takes no other";
    const MasterCommand back = toCommand(packet);
    for (const Arm arm : kArms) {
      for (std::size_t k = 0; k < 4; ++k)
        EXPECT_NEAR(at(back.dq_I, arm)[k], at(command.dq_I, arm)[k], 1e-15) << name(arm) << " " << k;
    }
  }
}

TEST(ItpCommand, MakesNoRotationOfAQuaternionWithoutLength) {
  for (const Arm arm : kArms) {
    ItpPacket packet;
    at(packet.Qw, arm) = 0.0;
    EXPECT_EQ(at(toCommand(packet).dq_I, arm), kIdentityQuat);
  }
}

TEST(ItpCommand, SaturatesWhatNoPacketCanCarry) {
  MasterCommand command;
  command.dp_I[0] = {1e9, -1e9, kNan};
  const ItpPacket packet = fromCommand(command);
  EXPECT_EQ(packet.delx_um[0], 2147483647);
  EXPECT_EQ(packet.dely_um[0], -2147483647);
  EXPECT_EQ(packet.delz_um[0], 0);
}

// struct.pack('<4I6iiIi', 16909060, 99, 0, 0, 1500, -250, 1, -1, 3300, 0, 2, 0, checksum), checksum = their sum
const char* const kForceVector =
    "04030201630000000000000000000000dc05000006ffffff01000000ffffffff"
    "e40c00000000000002000000000000002f150201";

ForcePacket vectorForce() {
  ForcePacket force;
  force.sequence = 16909060;
  force.last_sequence = 99;
  force.runlevel = 2;
  force.force_I = {Vec3{1.5, 0.001, 3.3}, Vec3{-0.25, -0.001, 0.0}};
  return force;
}

TEST(Force, EncodesTheBytesThatPythonStructPacks) {
  const std::vector<std::uint8_t> expected = fromHex(kForceVector);
  ASSERT_EQ(expected.size(), kForceSize);
  const ForceBytes bytes = encodeForce(vectorForce());
  EXPECT_EQ(std::vector<std::uint8_t>(bytes.begin(), bytes.end()), expected);
}

TEST(Force, DecodesTheBytesThatPythonStructPacks) {
  const std::vector<std::uint8_t> bytes = fromHex(kForceVector);
  ForcePacket force;
  ASSERT_EQ(decodeForce(bytes.data(), bytes.size(), &force), Reject::kNone);
  EXPECT_EQ(force.sequence, 16909060U);
  EXPECT_EQ(force.last_sequence, 99U);
  EXPECT_EQ(force.runlevel, 2);
  EXPECT_EQ(force.force_I, vectorForce().force_I);
}

TEST(Force, IsRoundedToTheNearestMillinewton) {
  ForcePacket force;
  force.force_I[0] = {0.00149, 0.00151, -0.00151};
  const ForceBytes bytes = encodeForce(force);
  ForcePacket back;
  ASSERT_EQ(decodeForce(bytes.data(), bytes.size(), &back), Reject::kNone);
  EXPECT_EQ(back.force_I[0], (Vec3{0.001, 0.002, -0.002}));
}

TEST(Force, RefusesARunLevelThatTheRobotDoesNotHave) {
  const ForceBytes good = encodeForce(vectorForce());
  std::int32_t runlevel = 0, sum = 0;
  std::memcpy(&runlevel, good.data() + 40, sizeof(runlevel));
  std::memcpy(&sum, good.data() + 48, sizeof(sum));
  ASSERT_EQ(runlevel, std::int32_t{vectorForce().runlevel});
  for (const std::int32_t level : {-256, -1, 0, 3, 4, 256}) {
    ForceBytes bytes = good;
    const std::int32_t mended = sum + level - runlevel;
    std::memcpy(bytes.data() + 40, &level, sizeof(level));
    std::memcpy(bytes.data() + 48, &mended, sizeof(mended));
    ForcePacket force;
    const Reject expected = level == 0 || level == 3 ? Reject::kNone : Reject::kOutOfRange;
    EXPECT_EQ(decodeForce(bytes.data(), bytes.size(), &force), expected) << level;
  }
}

TEST(Force, RefusesOtherSizes) {
  const std::vector<std::uint8_t> bytes(100, 0);
  ForcePacket force = vectorForce();
  for (std::size_t size = 0; size <= bytes.size(); ++size) {
    if (size == kForceSize) continue;
    ASSERT_EQ(decodeForce(bytes.data(), size, &force), Reject::kWrongSize);
  }
  EXPECT_EQ(force.sequence, vectorForce().sequence);
}

TEST(Force, RefusesEverySingleFlippedBit) {
  const ForceBytes good = encodeForce(vectorForce());
  for (std::size_t bit = 0; bit < 8 * kForceSize; ++bit) {
    ForceBytes bytes = good;
    bytes[bit / 8] = static_cast<std::uint8_t>(bytes[bit / 8] ^ (1U << (bit % 8)));
    ForcePacket force;
    ASSERT_EQ(decodeForce(bytes.data(), bytes.size(), &force), Reject::kBadFrame) << bit;
    ASSERT_EQ(force.sequence, 0U);
  }
}

TEST(Force, RefusesAnUnknownRunLevel) {
  ForcePacket force = vectorForce();
  force.runlevel = 4;
  const ForceBytes bytes = encodeForce(force);
  EXPECT_EQ(decodeForce(bytes.data(), bytes.size(), &force), Reject::kOutOfRange);
}

TEST(ItpCheck, RejectsAPedalThatIsNeitherUpNorDown) {
  for (const std::int32_t mode : {-1, 0, 1, 2, 256, 1 << 24}) {
    ItpPacket packet;
    packet.surgeon_mode = mode;
    EXPECT_EQ(checkItp(packet, {2000}), mode == 0 || mode == 1 ? Reject::kNone : Reject::kOutOfRange) << mode;
  }
}

}  // namespace
}  // namespace raven2_trainer::wire
