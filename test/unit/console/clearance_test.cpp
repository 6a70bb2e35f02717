#include "console/clearance.h"

#include <gtest/gtest.h>

#include <random>

#include "console/grip_search.h"
#include "fake_world.h"

namespace raven2_trainer::console {
namespace {

/** Gap of two capsules, by comparing many points of both. */
double gapByPoints(const Capsule& one, const Capsule& other) {
  constexpr int kPoints = 200;
  double least = 1e9;
  for (int i = 0; i <= kPoints; ++i) {
    for (int j = 0; j <= kPoints; ++j) {
      const Vector3 p = one.a + (one.b - one.a) * i / kPoints, q = other.a + (other.b - other.a) * j / kPoints;
      least = std::min(least, (p - q).norm());
    }
  }
  return least - one.radius - other.radius;
}

TEST(GapBetween, IsTheLeastDistanceOfPointsOfBoth) {
  std::mt19937 random(1);  // NOLINT: the same every time
  std::uniform_real_distribution<double> metre(-0.05, 0.05);
  const auto point = [&] { return Vector3(metre(random), metre(random), metre(random)); };
  for (int i = 0; i < 50; ++i) {
    const Capsule one{point(), point(), 0.004}, other{point(), point(), 0.002};
    EXPECT_NEAR(gapBetween(one, other), gapByPoints(one, other), 4e-4);
    EXPECT_LE(gapBetween(one, other), gapByPoints(one, other) + 1e-12);
    const Capsule ball{one.a, one.a, 0.001}, parallel{one.a + Vector3(0, 0.01, 0), one.b + Vector3(0, 0.01, 0), 0.0};
    EXPECT_NEAR(gapBetween(ball, other), gapByPoints(ball, other), 4e-4);
    EXPECT_NEAR(gapBetween(one, parallel), gapByPoints(one, parallel), 4e-4);
  }
}

/** Jaws straight down. */
Pose upright(const Vector3& p_W) {
  Pose X_WT;
  X_WT.R << 0, 1, 0, 0, 0, -1, -1, 0, 0;
  X_WT.p = p_W;
  return X_WT;
}

class ClearanceTest : public ::testing::Test {
 protected:
  Surroundings around() const {
    Surroundings around;
    around.solids = standingIn(fakeScene());
    around.floor = 0.0;
    return around;
  }
  bool clear(const Vector3& p_W) const { return isClear(arms_, Arm::kGold, upright(p_W), around()); }

  const ArmsConfig arms_ = shippedConfig().arms;
};

TEST_F(ClearanceTest, KeepsJawsOffATower) {
  // a tower of 4 mm radius and 26 mm height is at (-18, 28) mm; jaws are 10 mm long and keep 4.5 mm around them
  EXPECT_FALSE(clear({-0.018, 0.028, 0.030}));
  EXPECT_TRUE(clear({-0.018, 0.028, 0.042}));
  EXPECT_FALSE(clear({-0.018, 0.020, 0.020}));
  EXPECT_TRUE(clear({-0.018, 0.019, 0.020}));
}

TEST_F(ClearanceTest, KeepsTheTipsOffTheFloor) {
  EXPECT_TRUE(clear({0.010, 0.0, 0.0105}));
  EXPECT_FALSE(clear({0.010, 0.0, 0.0103}));
}

TEST_F(ClearanceTest, KeepsOutOfTheWayOfTheOtherTool) {
  Surroundings around;
  around.X_WT_other = upright({0.010, 0.0, 0.030});
  EXPECT_FALSE(isClear(arms_, Arm::kGold, upright({0.010, 0.008, 0.030}), around));
  EXPECT_TRUE(isClear(arms_, Arm::kGold, upright({0.010, 0.020, 0.030}), around));
}

TEST_F(ClearanceTest, FindsNoFreeWayThroughATowerButOneOverIt) {
  const Pose from = upright({-0.035, 0.028, 0.020}), to = upright({0.000, 0.028, 0.020});
  EXPECT_GT(blockedBetween(arms_, Arm::kGold, from, to, around()), 0);
  const Pose over_from = upright({-0.035, 0.028, 0.042}), over_to = upright({0.000, 0.028, 0.042});
  EXPECT_EQ(blockedBetween(arms_, Arm::kGold, from, over_from, around()), 0);
  EXPECT_EQ(blockedBetween(arms_, Arm::kGold, over_from, over_to, around()), 0);
  EXPECT_EQ(blockedBetween(arms_, Arm::kGold, over_to, to, around()), 0);
}

/** Clearance by many points of the jaws' boxes, as raven2.urdf has them, and of the solids' middle lines. */
double roomByPoints(const Pose& X_WT, double opening, const Surroundings& around) {
  double least = 1.0;
  const auto look = [&](const Vector3& p) {
    least = std::min(least, p.z() - around.floor);
    for (const Capsule& solid : around.solids) {
      for (double s = 0.0; s <= 1.0; s += 0.005)
        least = std::min(least, (p - solid.a - s * (solid.b - solid.a)).norm() - solid.radius);
    }
  };
  for (const double side : {-1.0, 1.0}) {
    const Matrix3 turn = Eigen::AngleAxisd(0.5 * side * opening, Vector3::UnitZ()).toRotationMatrix();
    for (int i = 0; i <= 20; ++i) {
      for (const double y : {0.0, 0.00075, 0.0015}) {
        for (const double z : {-0.0018, -0.0009, 0.0, 0.0009, 0.0018})
          look(X_WT * (turn * Vector3(0.0005 * i, side * y, z)));
      }
    }
  }
  return least;
}

TEST(RoomOfJaws, IsThatOfTheirBoxesOpenAndClosed) {
  // rods with round ends miss 0.31 mm of a box at its edges, 0.55 mm at its corners; kStep: the points' distance
  constexpr double kEdges = 0.00056, kStep = 0.0002;
  std::mt19937 random(2);  // NOLINT: the same every time
  std::uniform_real_distribution<double> share(-1.0, 1.0);
  Surroundings around;
  around.solids = {{{0, 0, 0}, {0, 0, 0.008}, 0.00125}};
  around.floor = 0.0;
  around.opening = openFor(0.0015);
  for (int i = 0; i < 200; ++i) {
    Pose X_WT = upright({0.008 * share(random), 0.008 * share(random), 0.012 + 0.002 * share(random)});
    const Vector3 axis = Vector3(share(random), share(random), share(random)).normalized();
    X_WT.R = Eigen::AngleAxisd(0.6 * share(random), axis).toRotationMatrix() * X_WT.R;
    double room = 1.0;
    for (const double opening : {around.opening, 0.5 * around.opening, 0.0})
      room = std::min(room, roomByPoints(X_WT, opening, around));
    if (room < 0.0002) continue;  // inside a solid, the points' distances are meaningless
    EXPECT_LT(roomOfJaws(X_WT, around), room + kEdges) << X_WT.p.transpose();
    EXPECT_GT(roomOfJaws(X_WT, around), room - kStep) << X_WT.p.transpose();
  }
}

TEST(StandingIn, AWireIsWhatItsPointsAre) {
  SceneRoles roles;
  roles.wires.push_back({"wire", "wire", 0.001, {{0, 0, 0}, {0, 0, 0.02}, {0.02, 0, 0.02}}});
  const std::vector<Capsule> solids = standingIn(roles);
  ASSERT_EQ(solids.size(), 2u);
  EXPECT_EQ(solids[1].a, Vector3(0, 0, 0.02));
  EXPECT_EQ(solids[1].b, Vector3(0.02, 0, 0.02));
  EXPECT_EQ(solids[1].radius, 0.001);
}

TEST(OpenFor, LeavesRoomOnBothSidesOfABar) {
  for (const double bar : {0.0015, 0.00175, 0.002}) {
    const double half_gap = 0.0085 * std::sin(0.5 * openFor(bar));
    EXPECT_NEAR(half_gap - bar, 0.0013, 1e-12) << "where the bar is, 8.5 mm from the hinge";
  }
  EXPECT_NEAR(openFor(0.002), kOpenJaws, 0.01);
}

TEST(Surroundings, LieOnTheFootOfTheLowestPegWhicheverItIs) {
  for (std::size_t lowest = 0; lowest < 3; ++lowest) {
    SceneRoles roles;
    for (std::size_t i = 0; i < 3; ++i)
      roles.pegs.push_back({"peg", "peg", {0.0, 0.0, i == lowest ? -0.03 : 0.01}, 0.02, 0.004});
    EXPECT_EQ(floorOf(roles), -0.03) << lowest;
  }
  EXPECT_EQ(floorOf(SceneRoles{}), 0.0);
}

TEST(Surroundings, AnObjectThatLiesThereReachesToTheOutsideOfItsBars) {
  const SceneObject ring{"ring", "ring", 0, /*inner_radius=*/0.007, /*bar_radius=*/0.002};
  const Capsule ball = lyingAt(ring, {0.01, 0.02, 0.03});
  EXPECT_EQ(ball.a, Vector3(0.01, 0.02, 0.03));
  EXPECT_EQ(ball.b, ball.a);
  EXPECT_NEAR(ball.radius, 0.011, 1e-15);
}

TEST_F(ClearanceTest, OfOpenJawsTheLowerTipCountsWhicheverItIs) {
  // jaws level, opening in the vertical plane: the lower tip is 10 mm sin(0.4) below the pivot, whichever way up
  for (const double side : {-1.0, 1.0}) {
    Pose X_WT;
    X_WT.R << 1, 0, 0, 0, 0, -side, 0, side, 0;
    Surroundings around;
    around.floor = 0.0;
    around.opening = 0.8;
    const double lowest = 0.010 * std::sin(0.4) + 0.0004;
    X_WT.p = {-0.03, 0.0, lowest + 1e-5};
    const bool is_clear = isClear(arms_, Arm::kGold, X_WT, around);
    X_WT.p.z() = lowest - 1e-5;
    EXPECT_TRUE(is_clear) << side;
    EXPECT_FALSE(isClear(arms_, Arm::kGold, X_WT, around)) << side;
  }
}

}  // namespace
}  // namespace raven2_trainer::console
