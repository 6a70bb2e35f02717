#include "console/grip_search.h"

#include <gtest/gtest.h>

#include "fake_world.h"

namespace raven2_trainer::console {
namespace {

constexpr double kBarReach = 0.0075;  // [m] pivot to the bar: the jaws are 10 mm long (meshes/dimensions.yaml)

SceneObject roundRing() {
  return {"ring", "ring", /*square=*/0, /*inner_radius=*/0.00775, /*bar_radius=*/0.00175};
}

/** Carries the ring from `ring_stand` to the middle. */
GripTask onTheStand(const ArmsConfig& arms, Arm arm, const SceneObject& ring) {
  GripTask task;
  task.arm = arm;
  task.q = arms.geometry.home;
  task.X_WR = level({0.012, 0.0, 0.016}, 0.0);
  task.ring = ring;
  task.lifted_W = Vector3(0.012, 0.0, 0.026);
  task.stations_W = {level({0.010, 0.0, 0.045}, 0.0)};
  return task;
}

GripPlan search(const ArmsConfig& arms, const GripTask& task, int at_once = 1000000) {
  GripSearch search(arms, task);
  while (!search.proceed(at_once)) {
  }
  return search.best();
}

/** Least distance of a joint from its limits, in the best joint solution of this pose; [rad], insertion x 8.7. */
double roomAt(const ArmsConfig& arms, Arm arm, const Pose& X_WT) {
  kinematics::IkSolutions solutions;
  kinematics::inverseAll(arms.geometry, arm, baseOf(arms, arm).inverse() * X_WT, kOpenJaws, &solutions);
  double best = -1.0;
  for (const auto& solution : solutions) {
    if (!solution.valid) continue;
    double least = 1e9;
    for (std::size_t j = 0; j < kJointCount; ++j) {
      const double scale = j == kInsertion ? 8.7 : 1.0;
      least = std::min(
          {least, scale * (solution.q[j] - arms.geometry.q_min[j]), scale * (arms.geometry.q_max[j] - solution.q[j])});
    }
    best = std::max(best, least);
  }
  return best;
}

TEST(ToolInRing, PutsTheBarBetweenTheJaws) {
  for (const SceneObject& ring : {fakeScene().objects[0], roundRing()}) {
    for (int i = 0; i < 16; ++i) {
      for (const bool turned : {false, true}) {
        for (const double lean : {-0.3, 0.0, 0.17, 1.0}) {
          const double a = 2.0 * kPi * i / 16;
          const Grip grip{{std::cos(a), std::sin(a), 0.0}, turned, 0.0, lean, kBarReach};
          const Pose X_RT = toolInRing(grip, ring);
          EXPECT_NEAR((X_RT.R.transpose() * X_RT.R - Matrix3::Identity()).norm(), 0.0, 1e-12);
          EXPECT_NEAR(X_RT.R.determinant(), 1.0, 1e-12);
          const Vector3 bar = X_RT * Vector3(kBarReach, 0.0, 0.0);
          const Vector3 middle_line = (ring.inner_radius + ring.bar_radius) * grip.outward;
          EXPECT_NEAR((bar - middle_line).norm(), 0.0, 1e-12);
          EXPECT_NEAR(X_RT.R.col(2).dot(grip.outward), 0.0, 1e-12) << "the hinge along the bar";
          EXPECT_NEAR(X_RT.R.col(2).z(), 0.0, 1e-12);
          EXPECT_GT(X_RT.p.z(), 0.0) << "from the upper side";
          EXPECT_GT(X_RT.p.dot(grip.outward) - middle_line.norm(), lean > 0.0 ? 0.0 : -0.01) << "leaning outward";
        }
      }
    }
  }
}

TEST(GripSearch, FindsForEachArmAGripWellInsideItsJoints) {
  const ArmsConfig arms = shippedConfig().arms;
  for (const SceneObject& ring : {fakeScene().objects[0], roundRing()}) {
    for (const Arm arm : kArms) {
      const GripTask task = onTheStand(arms, arm, ring);
      const GripPlan plan = search(arms, task);
      EXPECT_GE(plan.score, kEnoughMargin) << name(arm);
      // all solutions of the pose give the same margin, without the search's joint trail
      const Pose X_RT = toolInRing(plan.grip, ring);
      EXPECT_GE(roomAt(arms, arm, task.X_WR * X_RT), plan.score - 1e-9);
      for (const Pose& station : task.stations_W)
        EXPECT_GE(roomAt(arms, arm, spun(station, plan.spin) * X_RT), plan.score - 1e-9);
    }
  }
}

TEST(GripSearch, FindsTheSameInManySmallParts) {
  const ArmsConfig arms = shippedConfig().arms;
  const GripTask task = onTheStand(arms, Arm::kGreen, fakeScene().objects[0]);
  const GripPlan at_once = search(arms, task), bit_by_bit = search(arms, task, 3);
  EXPECT_EQ(at_once.score, bit_by_bit.score);
  EXPECT_EQ(at_once.spin, bit_by_bit.spin);
  EXPECT_EQ(at_once.grip.outward, bit_by_bit.grip.outward);
  EXPECT_EQ(at_once.grip.along, bit_by_bit.grip.along);
}

TEST(GripSearch, KeepsOutOfTheWayOfTheOtherTool) {
  const ArmsConfig arms = shippedConfig().arms;
  for (const SceneObject& ring : {fakeScene().objects[0], roundRing()}) {
    GripTask gold = onTheStand(arms, Arm::kGold, ring);
    const GripPlan first = search(arms, gold);
    ASSERT_GT(first.score, 0.0);
    GripTask green = gold;
    green.arm = Arm::kGreen;
    green.X_WR = level({0.010, 0.0, 0.045}, first.spin);
    green.lifted_W.reset();
    green.stations_W.clear();
    green.X_WT_other = green.X_WR * toolInRing(first.grip, ring);
    const GripPlan second = search(arms, green);
    ASSERT_GE(second.score, 0.07);
    const Pose X_WT = green.X_WR * toolInRing(second.grip, ring);
    EXPECT_GT((X_WT.p - green.X_WT_other->p).norm(), 0.009);
    EXPECT_LT(second.grip.outward.dot(first.grip.outward), 0.1) << "not on the same side of the ring";
  }
}

/** From one side of the near left tower to the other. */
struct PastATower {
  Surroundings around;
  Pose from, to;
};

PastATower pastATower() {
  PastATower task;
  task.around.solids = standingIn(fakeScene());
  Pose X_WT;
  X_WT.R << 0, 1, 0, 0, 0, -1, -1, 0, 0;  // jaws straight down
  task.from = task.to = X_WT;
  task.from.p = {-0.004, 0.020, 0.022};
  task.to.p = {-0.030, 0.034, 0.022};
  return task;
}

TEST(FindWay, LeadsOverATowerThatIsInTheWay) {
  const ArmsConfig arms = shippedConfig().arms;
  const PastATower task = pastATower();
  JointTrail trail(arms, Arm::kGold, arms.geometry.home);
  ASSERT_TRUE(trail.go(task.from));
  ASSERT_GT(blockedBetween(arms, Arm::kGold, task.from, task.to, task.around), 0) << "the straight line is blocked";
  std::vector<Pose> via;
  EXPECT_EQ(findWay(arms, Arm::kGold, task.around, {}, task.to, &trail, &via), 0);
  ASSERT_FALSE(via.empty());
  EXPECT_LT((trail.pose().p - task.to.p).norm(), 1e-6);
  Pose here = task.from;
  via.push_back(task.to);
  for (const Pose& next : via) {
    EXPECT_EQ(blockedBetween(arms, Arm::kGold, here, next, task.around), 0);
    here = next;
  }
}

TEST(FindWay, GoesStraightWhereNothingIs) {
  const ArmsConfig arms = shippedConfig().arms;
  const PastATower task = pastATower();
  JointTrail trail(arms, Arm::kGold, arms.geometry.home);
  ASSERT_TRUE(trail.go(task.from));
  std::vector<Pose> via;
  EXPECT_EQ(findWay(arms, Arm::kGold, Surroundings{}, {}, task.to, &trail, &via), 0);
  EXPECT_TRUE(via.empty());
}

TEST(FindWay, SaysSoWhenTheArmCannotFollow) {
  const ArmsConfig arms = shippedConfig().arms;
  JointTrail trail(arms, Arm::kGold, arms.geometry.home);
  Pose far = trail.pose();
  far.p.x() += 0.6;
  std::vector<Pose> via;
  EXPECT_LT(findWay(arms, Arm::kGold, Surroundings{}, {}, far, &trail, &via), 0);
}

TEST(GripSearch, KeepsTheJawsOffWhatALowRingLiesOn) {
  // GIVEN a ring of 1.5 mm bars on a board of 2 mm
  const ArmsConfig arms = shippedConfig().arms;
  GripTask task = onTheStand(arms, Arm::kGold, {"ring", "ring", /*square=*/0, 0.005261, 0.0015});
  task.X_WR = level({0.006, 0.014, 0.0035}, 0.0);
  task.lifted_W = Vector3(0.006, 0.014, 0.030);
  task.around.floor = 0.002;
  task.around.opening = openFor(0.0015);
  // WHEN a grip is searched, THEN neither open nor closed jaws, 10 mm long, touch the board
  const GripPlan plan = search(arms, task);
  ASSERT_GE(plan.score, kEnoughMargin);
  const Pose X_WT = task.X_WR * toolInRing(plan.grip, task.ring);
  for (const double angle : {-0.5 * task.around.opening, 0.0, 0.5 * task.around.opening}) {
    const Vector3 tip = X_WT * Vector3(0.010 * std::cos(angle), 0.010 * std::sin(angle), 0.0);
    EXPECT_GT(tip.z(), 0.0023);
  }
}

TEST(GripSearch, SaysSoWhenThereIsNone) {
  const ArmsConfig arms = shippedConfig().arms;
  GripTask task = onTheStand(arms, Arm::kGold, roundRing());
  task.stations_W.push_back(level({0.5, 0.0, 0.0}, 0.0));
  EXPECT_LT(search(arms, task).score, 0.0);
}

TEST(AlongWire, LeadsARingThroughThePointsLeaningTowardsUpright) {
  // GIVEN a wire that rises, bends over in a quarter circle of 10 mm and goes on level
  std::vector<Vec3> line;
  for (int i = 0; i < 5; ++i)
    line.push_back({0.03, 0.02, 0.003 * i});
  for (int i = 1; i <= 6; ++i) {
    const double a = kPi / 2 * i / 6;
    line.push_back({0.02 + 0.01 * std::cos(a), 0.02, 0.012 + 0.01 * std::sin(a)});
  }
  for (int i = 1; i <= 5; ++i)
    line.push_back({0.02 - 0.004 * i, 0.02, 0.022});
  const std::vector<Pose> way = alongWire(line, 0.3, 0.010);
  // THEN it passes all points, in steps of a millimetre or so, and goes on straight
  for (const Vec3& p : line)
    EXPECT_LT((way[nearestTo(toEigen(p), way)].p - toEigen(p)).norm(), 1e-9);
  for (std::size_t i = 1; i < way.size(); ++i) {
    EXPECT_LT((way[i].p - way[i - 1].p).norm(), 0.0021);
    const Vector3 along = way[i].p - way[i - 1].p;
    EXPECT_GT(way[i].R.col(2).dot(along.normalized()), std::cos(kWireLean + 0.1));
    EXPECT_GE(way[i].R(2, 2), along.normalized().z() - 1e-6);
    EXPECT_NEAR(way[i].R.determinant(), 1.0, 1e-9);
  }
  EXPECT_NEAR((way.back().p - Vector3(-0.010, 0.02, 0.022)).norm(), 0.0, 1e-3);
  EXPECT_NEAR(headingOf(way.front()), 0.3, 1e-9);
  // a rotation about y alone leaves points along y in place
  const Vector3 y_R = way.front().R.transpose() * Vector3::UnitY();
  EXPECT_NEAR((way.back().R * y_R - Vector3::UnitY()).norm(), 0.0, 1e-6);
}

TEST(Spin, IsSeenAgainAndLeftAloneByTheShortestTurnToLevel) {
  // GIVEN a ring that leans by 1 rad to the left, spun about its own axis
  const Pose leaning{Eigen::AngleAxisd(-1.0, Vector3::UnitX()).toRotationMatrix(), {0.1, 0.2, 0.3}};
  for (const double angle : {-3.0, -1.2, 0.0, 0.4, 3.0}) {
    const Pose X_WR = spun(leaning, angle);
    EXPECT_NEAR(spinOf(X_WR, leaning), angle, 1e-12);
    EXPECT_NEAR(headingOf(levelled(X_WR)), angle, 1e-12);
    EXPECT_NEAR(levelled(X_WR).R(2, 2), 1.0, 1e-12);
  }
  // THEN an axis that is off by a few degrees does not matter
  const Pose tilted{Eigen::AngleAxisd(0.1, Vector3::UnitY()).toRotationMatrix() * leaning.R, leaning.p};
  EXPECT_NEAR(spinOf(spun(tilted, 0.4), leaning), 0.4, 0.1);
}

TEST(Facing, ARingUpsideDownIsTheSameRing) {
  const Pose X_WR{Eigen::AngleAxisd(3.0, Vector3::UnitY()).toRotationMatrix(), {0.1, 0.2, 0.3}};
  const Pose seen = facing(X_WR, Vector3::UnitZ());
  EXPECT_GT(seen.R(2, 2), 0.9);
  EXPECT_NEAR(seen.R.determinant(), 1.0, 1e-12);
  EXPECT_EQ(seen.p, X_WR.p);
  EXPECT_NEAR(std::abs(seen.R.col(2).dot(X_WR.R.col(2))), 1.0, 1e-12);
}

}  // namespace
}  // namespace raven2_trainer::console
