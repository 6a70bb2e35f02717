#include "planning/distance_grid.h"

#include <gtest/gtest.h>

#include "planning_fixtures.h"
#include "raven2_trainer/core/exceptions.h"
#include "shipped_trainer.h"

namespace raven2_trainer::planning {
namespace {

constexpr double kRounding = 1e-12;  // [m] of the reference itself

/** Signed distance of a point in the shape's own frame. */
double distanceInFrame(const model::CollisionShape& shape, const Vector3& p) {
  if (shape.kind == model::ShapeKind::kBox) {
    const double x = std::abs(p.x()) - shape.size.x() / 2, y = std::abs(p.y()) - shape.size.y() / 2,
                 z = std::abs(p.z()) - shape.size.z() / 2;
    if (std::max({x, y, z}) <= 0.0) return std::max({x, y, z});
    return std::hypot(std::max(x, 0.0), std::max(y, 0.0), std::max(z, 0.0));
  }
  const double half = shape.kind == model::ShapeKind::kCapsule ? shape.size.y() / 2 : 0.0;
  return std::hypot(p.x(), p.y(), std::max(std::abs(p.z()) - half, 0.0)) - shape.size.x();
}

double referenceDistance(const model::Description& d,
                         const std::vector<Pose>& X_WL,
                         std::size_t link,
                         const Vector3& p) {
  double nearest = 1e9;
  for (const model::CollisionShape& shape : d.links[link].collisions)
    nearest = std::min(nearest, distanceInFrame(shape, (X_WL[link] * shape.X_LS).inverse() * p));
  return nearest;
}

/** Distance to the scene without its free bodies, and to the bases of both arms. */
double referenceDistance(const model::RavenModel& raven, const model::SceneModel& scene, const Vector3& p) {
  double nearest = 1e9;
  for (std::size_t i = 0; i < scene.description.links.size(); ++i) {
    if (std::count(scene.free_bodies.begin(), scene.free_bodies.end(), static_cast<int>(i)) > 0) continue;
    nearest = std::min(nearest, referenceDistance(scene.description, scene.X_WL, i, p));
  }
  std::vector<double> positions(raven.description.links.size());
  std::vector<Pose> poses(positions.size());
  raven.linkPosesInWorld({raven.arms.geometry.home, raven.arms.geometry.home}, &positions, &poses);
  for (const Arm arm : kArms)
    nearest = std::min(
        nearest, referenceDistance(raven.description, poses, static_cast<std::size_t>(at(raven.base_links, arm)), p));
  return nearest;
}

class ShippedGrid : public ::testing::Test {
 protected:
  static const DistanceGrid& grid() {
    static const DistanceGrid made(test::trainer().raven, test::trainer().scene);
    return made;
  }
  static double reference(const Vector3& p) {
    return referenceDistance(test::trainer().raven, test::trainer().scene, p);
  }
  static Vector3 draw(const Vector3& middle, const Vector3& reach, Random* random) {
    return middle + Vector3(random->uniform(-1, 1), random->uniform(-1, 1), random->uniform(-1, 1)).cwiseProduct(reach);
  }
};

TEST_F(ShippedGrid, BoundsTheDistanceEverywhereAndByNoMoreThanItSays) {
  Random random(1);
  int fine = 0, coarse = 0, beyond = 0;
  for (int i = 0; i < 60000; ++i) {
    const Vector3 p = i % 2 == 0 ? draw({0, 0, 0.04}, {0.1, 0.1, 0.06}, &random)  // in and about the dome
                                 : draw({0, 0, 0.2}, {0.8, 1.0, 0.6}, &random);
    const double truth = reference(p), cell = grid().cellAt(p), half_diagonal = std::sqrt(3.0) / 2 * cell;
    const DistanceBounds quick = grid().quick(p), tight = grid().tight(p);
    ASSERT_LE(tight.lower, truth + kRounding) << p.transpose();
    ASSERT_LE(quick.lower, truth + kRounding) << p.transpose();
    ASSERT_GE(tight.upper, truth) << p.transpose();
    ASSERT_GE(quick.upper, truth) << p.transpose();
    (cell == 0.0 ? beyond : cell < 0.004 ? fine : coarse)++;
    if (cell == 0.0) continue;
    ASSERT_GT(tight.lower, truth - 2 * half_diagonal - 1e-6) << p.transpose();
    ASSERT_GT(quick.lower, truth - 2 * half_diagonal - 1e-6) << p.transpose();
  }
  EXPECT_GT(fine, 10000);
  EXPECT_GT(coarse, 3000);
  EXPECT_GT(beyond, 5000);
}

TEST_F(ShippedGrid, IsTightWhereToolsPassByAtTheirRadius) {
  // The shaft's radius and clearance: 6 mm. By the header's formula the bound loses sigma^2 / 2d there. With
  // sigma^2 = h^2 / 2 on average that is 0.38 mm.
  Random random(2);
  double lost = 0.0;
  int count = 0;
  while (count < 1500) {
    const Vector3 p = draw({0, 0, 0.04}, {0.09, 0.09, 0.05}, &random);
    const double truth = reference(p);
    if (truth < 0.005 || truth > 0.007) continue;
    lost += truth - grid().lowerBound(p);
    ++count;
  }
  EXPECT_LT(lost / count, 4.5e-4);
}

TEST_F(ShippedGrid, KeepsToItsMemory) {
  EXPECT_LT(grid().nodeCount(), 500000u);  // 2 MB, in a processor's cache
  EXPECT_DOUBLE_EQ(grid().cellAt({0, 0, 0.03}), 0.003);
}

TEST_F(ShippedGrid, IsGivenUpWhereverItsMakingIsToldTo) {
  struct Enough {};
  std::size_t polls = 0;
  const DistanceGrid polled(test::trainer().raven, test::trainer().scene, [&polls] { ++polls; });
  EXPECT_EQ(polls, polled.nodeCount() / EverySoOften::kPieces) << "the construction polls all the time";
  for (const std::size_t last : {std::size_t{1}, polls / 2, polls}) {
    std::size_t asked = 0;
    const auto enough = [&] {
      if (++asked == last) throw Enough{};
    };
    EXPECT_THROW(DistanceGrid(test::trainer().raven, test::trainer().scene, enough), Enough);
    EXPECT_EQ(asked, last);
  }
}

TEST(DistanceGridTest, LeavesFreeBodiesOut) {
  const model::RavenModel raven = test::raven();
  model::SceneModel scene = test::scene({test::sphere(0.01), test::sphere(0.01, {Matrix3::Identity(), {0.1, 0, 0}})});
  EXPECT_NEAR(DistanceGrid(raven, scene).lowerBound({0.03, 0, 0}), 0.02, 2e-4);
  scene.free_bodies = {0};
  EXPECT_NEAR(DistanceGrid(raven, scene).lowerBound({0.03, 0, 0}), 0.06, 2e-4);
}

TEST(DistanceGridTest, BoundsTheDistanceOfOneTurnedShapeFromEverySide) {
  // GIVEN one shape alone: beyond the lattices only its bounding box is known
  const model::RavenModel raven = test::raven();
  Random random(3);
  int beyond = 0;
  for (int trial = 0; trial < 40; ++trial) {
    const Quaternion turn(random.normal(), random.normal(), random.normal(), random.normal());
    const Pose X{turn.normalized().toRotationMatrix(), {random.uniform(-0.1, 0.1), 0.05, random.uniform(-0.1, 0.1)}};
    const auto size = [&random] { return random.uniform(0.01, 0.08); };
    const model::CollisionShape shape =
        trial % 2 == 0 ? test::box({size(), size(), size()}, X) : test::capsule(size() / 2, size(), X);
    const DistanceGrid grid(raven, test::scene({shape}));
    for (int i = 0; i < 400; ++i) {
      const Vector3 way = Vector3(random.normal(), random.normal(), random.normal()).normalized();
      const Vector3 p = X.p + random.uniform(0.0, 0.4) * way;
      const double truth = distanceInFrame(shape, X.inverse() * p);
      ASSERT_LE(grid.tight(p).lower, truth + kRounding) << trial;
      ASSERT_LE(grid.quick(p).lower, truth + kRounding) << trial;
      if (grid.cellAt(p) > 0.0) continue;
      ++beyond;
      // A rotated box loses no more than that to its bounding box: no edge is longer than the shape's diagonal.
      ASSERT_GE(grid.tight(p).lower, truth - 0.5 * std::sqrt(3.0) * (shape.size.norm() + 2 * shape.size.x())) << trial;
    }
  }
  EXPECT_GT(beyond, 5000);
}

TEST(DistanceGridTest, BeyondItsLatticesTheDistanceIsThatToTheBoxOnEverySide) {
  // GIVEN a box along the axes, so that the bounding box is the box itself
  const model::CollisionShape shape = test::box({0.04, 0.06, 0.08}, {Matrix3::Identity(), {0.1, 0.2, 0.3}});
  const DistanceGrid grid(test::raven(), test::scene({shape}));
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      Vector3 p(0.1, 0.2, 0.3);
      p[axis] += side * (shape.size[axis] / 2 + 0.25);
      EXPECT_EQ(grid.cellAt(p), 0.0);
      EXPECT_NEAR(grid.lowerBound(p), 0.25, 1e-12) << axis << " " << side;
    }
  }
}

TEST(DistanceGridTest, KnowsOfNothingInAnEmptyScene) {
  EXPECT_GT(DistanceGrid(test::raven(), test::scene({})).lowerBound({0, 0, 0}), 10.0);
}

TEST(DistanceGridTest, MakesItsCellsLargerForALargeScene) {
  const DistanceGrid grid(test::raven(), test::scene({test::box({20, 20, 20}), test::box({0.29, 0.29, 0.29})}));
  EXPECT_LT(grid.nodeCount(), 2 * DistanceGrid::kMaxNodes);
  EXPECT_LE(grid.lowerBound({11, 0, 0}), 1.0);
  EXPECT_GT(grid.lowerBound({11, 0, 0}), 0.9);
}

TEST(DistanceGridTest, RefusesMeshesNamingTheirLink) {
  const model::SceneModel scene = test::scene({test::sphere(0.005), {model::ShapeKind::kMesh, {}, {0, 0, 0}, 0}});
  try {
    const DistanceGrid grid(test::raven(), scene);
    FAIL() << "accepted";
  } catch (const ModelException& e) {
    EXPECT_NE(std::string(e.what()).find("scene_by_hand.urdf:2: link link1"), std::string::npos) << e.what();
  }
}

}  // namespace
}  // namespace raven2_trainer::planning
