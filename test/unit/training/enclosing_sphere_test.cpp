#include "raven2_trainer/training/enclosing_sphere.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "gtest/gtest.h"
#include "raven2_trainer/core/random.h"

namespace raven2_trainer::training {
namespace {

double distance(const Vec3& a, const Vec3& b) {
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

void expectSphere(const Sphere& sphere, const Vec3& centre, double radius) {
  EXPECT_NEAR(distance(sphere.centre, centre), 0.0, 1e-9);
  EXPECT_NEAR(sphere.radius, radius, 1e-9);
}

TEST(EnclosingSphere, OfFewPointsIsTheObviousOne) {
  expectSphere(enclosingSphere({}), {}, 0.0);
  expectSphere(enclosingSphere({{1.0, 2.0, 3.0}}), {1.0, 2.0, 3.0}, 0.0);
  expectSphere(enclosingSphere({{1.0, 0.0, 0.0}, {3.0, 0.0, 0.0}}), {2.0, 0.0, 0.0}, 1.0);
  expectSphere(enclosingSphere({{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, {0.5, 0.1, 0.0}}), {0.5, 0.0, 0.0}, 0.5);  // blunt
}

TEST(EnclosingSphere, OfAnEvenTriangleAndTetrahedronIsTheirCircumsphere) {
  const double height = std::sqrt(3.0) / 2.0;
  expectSphere(enclosingSphere({{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, {0.5, height, 0.0}}), {0.5, height / 3.0, 0.0},
               1.0 / std::sqrt(3.0));
  expectSphere(enclosingSphere({{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}}), {}, std::sqrt(3.0));
}

TEST(EnclosingSphere, OfPointsOnOneLineIsThatOfItsEnds) {
  std::vector<Vec3> line;
  for (int i = 0; i < 1000; ++i)
    line.push_back({0.001 * i, 0.002 * i, -0.002 * i});
  expectSphere(enclosingSphere(line), {0.4995, 0.999, -0.999}, 0.5 * 0.999 * 3.0);
}

TEST(EnclosingSphere, OfManyPointsOfASphereIsThatSphere) {
  Random random(5);
  std::vector<Vec3> points{{0.12, 0.2, 0.3}, {0.08, 0.2, 0.3}};  // ends of a diameter
  while (points.size() < 20000) {
    const Vec3 v{random.normal(), random.normal(), random.normal()};
    const double part = 0.02 / distance(v, {}) * std::cbrt(random.uniform(0.0, 1.0));
    points.push_back({0.1 + part * v[0], 0.2 + part * v[1], 0.3 + part * v[2]});
  }
  expectSphere(enclosingSphere(points), {0.1, 0.2, 0.3}, 0.02);
}

TEST(EnclosingSphere, HoldsAllAndNoneSmallerOfThreeThousandTriesDoes) {
  Random random(9);
  std::vector<Vec3> points;
  for (int i = 0; i < 60; ++i)
    points.push_back({random.normal(), 0.3 * random.normal(), random.uniform(-1.0, 1.0)});
  const Sphere sphere = enclosingSphere(points);
  const auto farthest = [&](const Vec3& centre) {
    double most = 0.0;
    for (const Vec3& point : points)
      most = std::max(most, distance(point, centre));
    return most;
  };
  EXPECT_NEAR(farthest(sphere.centre), sphere.radius, 1e-6);
  for (int i = 0; i < 3000; ++i) {
    Vec3 other = sphere.centre;
    for (double& coordinate : other)
      coordinate += random.uniform(-0.05, 0.05);
    EXPECT_GE(farthest(other), sphere.radius - 1e-6);
  }
}

TEST(EnclosingSphere, LeavesOutWhatIsNotFinite) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  expectSphere(enclosingSphere({{0.0, 0.0, 1.0}, {nan, 0.0, 0.0}, {0.0, 0.0, 3.0}}), {0.0, 0.0, 2.0}, 1.0);
}

}  // namespace
}  // namespace raven2_trainer::training
