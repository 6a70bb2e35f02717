#include "raven/master_target.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace raven2_trainer::raven {
namespace {

using Um = std::array<std::int32_t, 3>;

wire::ItpPacket increment(Arm arm, const Um& um) {
  wire::ItpPacket packet;
  at(packet.delx_um, arm) = um[0];
  at(packet.dely_um, arm) = um[1];
  at(packet.delz_um, arm) = um[2];
  return packet;
}

Um moved(Arm arm, const Um& um) {
  MasterTarget target;
  target.add(arm, increment(arm, um));
  return target.p_um;
}

TEST(MasterTarget, GoldAxesOneAtATime) {
  // base x = -itp z, y = -itp x, z = +itp y (raven2.md 1.4)
  EXPECT_EQ(moved(Arm::kGold, {1000, 0, 0}), (Um{0, -1000, 0}));
  EXPECT_EQ(moved(Arm::kGold, {0, 1000, 0}), (Um{0, 0, 1000}));
  EXPECT_EQ(moved(Arm::kGold, {0, 0, 1000}), (Um{-1000, 0, 0}));
}

TEST(MasterTarget, GreenAxesOneAtATime) {
  EXPECT_EQ(moved(Arm::kGreen, {1000, 0, 0}), (Um{0, 1000, 0}));
  EXPECT_EQ(moved(Arm::kGreen, {0, 1000, 0}), (Um{0, 0, -1000}));
  EXPECT_EQ(moved(Arm::kGreen, {0, 0, 1000}), (Um{-1000, 0, 0}));
}

TEST(MasterTarget, ArmsTakeTheirOwnFields) {
  MasterTarget gold;
  gold.add(Arm::kGold, increment(Arm::kGreen, {500, 500, 500}));
  EXPECT_EQ(gold.p_um, (Um{0, 0, 0}));
}

TEST(MasterTarget, RotationsGoThroughTheSameMap) {
  constexpr double kHalf = 0.05;
  const std::array<std::array<Vector3, 3>, kArmCount> axes{{{Vector3(0, -1, 0), Vector3(0, 0, 1), Vector3(-1, 0, 0)},
                                                            {Vector3(0, 1, 0), Vector3(0, 0, -1), Vector3(-1, 0, 0)}}};
  for (const Arm arm : kArms) {
    for (int axis = 0; axis < 3; ++axis) {
      wire::ItpPacket packet;
      std::array<PerArm<double>*, 3> parts{&packet.Qx, &packet.Qy, &packet.Qz};
      at(*parts[static_cast<std::size_t>(axis)], arm) = std::sin(kHalf);
      at(packet.Qw, arm) = std::cos(kHalf);
      MasterTarget target;
      target.add(arm, packet);
      const Quaternion expected(Eigen::AngleAxisd(2 * kHalf, at(axes, arm)[static_cast<std::size_t>(axis)]));
      EXPECT_LT(target.R_BT.angularDistance(expected), 1e-12);
    }
  }
}

TEST(MasterTarget, RotationsMultiplyFromTheLeft) {
  MasterTarget target;
  target.R_BT = Quaternion(Eigen::AngleAxisd(kPi / 2, Vector3::UnitX()));
  wire::ItpPacket packet;  // gold: itp y is base z
  packet.Qy[0] = std::sin(0.1);
  packet.Qw[0] = std::cos(0.1);
  target.add(Arm::kGold, packet);
  // About the base's z: the tool's own y axis, which now points along base z, must not have moved.
  EXPECT_LT((target.R_BT * Vector3::UnitY() - Vector3::UnitZ()).norm(), 1e-12);
}

TEST(MasterTarget, GraspIncrementsOpenDownAndAreClamped) {
  MasterTarget target;
  target.grasp_mrad = 1570;
  wire::ItpPacket packet;
  packet.grasp_mrad[0] = 100;
  target.add(Arm::kGold, packet);
  EXPECT_EQ(target.grasp_mrad, 1470);  // observed: 1.571 to 1.470 rad
  packet.grasp_mrad[0] = 5000;
  target.add(Arm::kGold, packet);
  EXPECT_EQ(target.grasp_mrad, -174);
  packet.grasp_mrad[0] = std::numeric_limits<std::int32_t>::min();
  target.add(Arm::kGold, packet);
  EXPECT_EQ(target.grasp_mrad, 1570);
}

TEST(MasterTarget, RebaseLeavesTheGraspUnlessItIsFarOff) {
  MasterTarget target;
  target.grasp_mrad = 1000;
  MasterTarget actual;
  actual.grasp_mrad = 1780;
  target.rebase(actual);
  EXPECT_EQ(target.grasp_mrad, 1000);
  actual.grasp_mrad = 1790;  // 45 degrees are 785 mrad
  target.rebase(actual);
  EXPECT_EQ(target.grasp_mrad, 1790);
}

TEST(MasterTarget, PositionIsTruncatedToTheMicrometre) {
  MasterTarget target;
  target.set({Matrix3::Identity(), Vector3(1.9e-6, -1.9e-6, 0.1)}, 0.0);
  EXPECT_EQ(target.p_um[0], 1);
  EXPECT_EQ(target.p_um[1], -1);
}

TEST(MasterTarget, ExtremeIncrementsStayDefined) {
  constexpr std::int32_t kLow = std::numeric_limits<std::int32_t>::min();
  MasterTarget target;
  for (int k = 0; k < 3; ++k)
    target.add(Arm::kGold, increment(Arm::kGold, {kLow, kLow, kLow}));
  EXPECT_TRUE(target.pose().p.allFinite());
}

TEST(MasterTarget, AQuaternionThatIsNoRotationPoisonsItsOwnArm) {
  // x86: 0 times NaN is NaN, and NaN as an int is -2^31 (raven2.md 4.5).
  for (const double w : {0.0, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    MasterTarget target;
    target.p_um = {5, 0, -7};
    wire::ItpPacket packet = increment(Arm::kGold, {1, 2, 3});
    packet.Qw[0] = w;
    target.add(Arm::kGold, packet);
    EXPECT_FALSE(target.isFinite());
    EXPECT_EQ(target.p_um[0], std::numeric_limits<std::int32_t>::min() + 5);
    EXPECT_EQ(target.p_um[1], std::numeric_limits<std::int32_t>::min());
    EXPECT_EQ(target.p_um[2], std::numeric_limits<std::int32_t>::max() - 6);  // sums wrap
    target.add(Arm::kGold, increment(Arm::kGold, {1, 2, 3}));
    EXPECT_FALSE(target.isFinite()) << "a good quaternion does not heal it";
    MasterTarget other;
    other.add(Arm::kGreen, packet);
    EXPECT_TRUE(other.isFinite());
  }
}

TEST(MasterTarget, TheLengthOfAQuaternionDoesNotMatter) {
  for (const double length : {1e-100, 0.5, 3.0, 1e100}) {
    MasterTarget target;
    wire::ItpPacket packet;
    packet.Qw[0] = packet.Qx[0] = length;
    target.add(Arm::kGold, packet);
    EXPECT_NEAR(target.R_BT.norm(), 1.0, 1e-12);
    EXPECT_NEAR(target.R_BT.angularDistance(Quaternion::Identity()), kPi / 2, 1e-9) << length;
  }
}

TEST(MasterTarget, AutomoveIsInTheBaseFrameAndTruncated) {
  MasterTarget target;
  target.addInBase({1.9, -1.9, 100.0}, {0.0, 0.0, 1.0, 0.0});
  EXPECT_EQ(target.p_um, (std::array<std::int32_t, 3>{1, -1, 100}));
  EXPECT_NEAR(target.R_BT.z(), 1.0, 1e-12);
  target.addInBase({0.0, 0.0, 0.0}, {0.0, 0.0, 0.0, 0.0});  // not the identity (raven2.md 5.3)
  EXPECT_FALSE(target.isFinite());
}

TEST(MasterTarget, EachArmTakesItsOwnGraspWithinItsLimits) {
  wire::ItpPacket packet;
  packet.grasp_mrad = {100, -50};
  const PerArm<std::int32_t> closed{900, 1050};
  for (const Arm arm : kArms) {
    MasterTarget target;
    target.grasp_mrad = 1000;
    target.add(arm, packet);
    EXPECT_EQ(target.grasp_mrad, at(closed, arm)) << name(arm);
  }
}

TEST(MasterTarget, RebaseTakesPositionRotationAndAGraspThatIsFarOffOnEitherSide) {
  for (const std::int32_t sign : {-1, 1}) {
    MasterTarget target, actual;
    target.grasp_mrad = 500;
    target.R_BT = Quaternion(Eigen::AngleAxisd(1.0, Vector3::UnitY()));
    actual.p_um = {10, -20, 30};
    actual.R_BT = Quaternion(Eigen::AngleAxisd(0.4, Vector3::UnitX()));
    actual.grasp_mrad = 500 + sign * 780;  // 45 degrees are 785 mrad
    target.rebase(actual);
    EXPECT_EQ(target.p_um, actual.p_um);
    EXPECT_EQ(target.R_BT.coeffs(), actual.R_BT.coeffs());
    EXPECT_EQ(target.grasp_mrad, 500) << sign;
    actual.grasp_mrad = 500 + sign * 790;
    target.rebase(actual);
    EXPECT_EQ(target.grasp_mrad, 500 + sign * 790) << sign;
  }
}

}  // namespace
}  // namespace raven2_trainer::raven
