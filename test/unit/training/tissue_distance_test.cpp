#include "raven2_trainer/training/tissue_distance.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/core/random.h"

namespace raven2_trainer::training {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

model::CollisionShape shape(model::ShapeKind kind, const Vector3& size, const Pose& X_LS = {}) {
  model::CollisionShape s;
  s.kind = kind;
  s.size = size;
  s.X_LS = X_LS;
  return s;
}

/** One fixed link with these shapes. */
model::SceneModel sceneOf(std::vector<model::CollisionShape> shapes, const Pose& X_WL = {}) {
  model::SceneModel scene;
  scene.description.file = "scene.urdf";
  model::Link link;
  link.name = "tissue";
  link.line = 3;
  link.collisions = std::move(shapes);
  scene.description.links = {link};
  scene.X_WL = {X_WL};
  return scene;
}

/** Both tools with all their points at one place. */
PerArm<ToolPoints> pointAt(const Vector3& p, const Vector3& other = {9, 9, 9}) {
  return {ToolPoints{p, p, p}, ToolPoints{other, other, other}};
}

TEST(ToolPoints, AreTheHingeAndBothEndsOfTheJaws) {
  Pose X_WT;
  X_WT.R.col(0) = -Vector3::UnitZ();  // pointing down, the jaws opening along x
  X_WT.R.col(1) = Vector3::UnitX();
  X_WT.R.col(2) = -Vector3::UnitY();
  X_WT.p = {0.01, 0.02, 0.05};
  const ToolPoints closed = toolPoints(X_WT, 0.0), open = toolPoints(X_WT, kPi / 3);
  EXPECT_LT((closed[0] - X_WT.p).norm(), 1e-15);
  EXPECT_LT((closed[1] - Vector3(0.01, 0.02, 0.04)).norm(), 1e-15);
  EXPECT_LT((closed[2] - closed[1]).norm(), 1e-15);
  const double down = 0.010 * std::sqrt(3.0) / 2;  // 30 degrees to either side
  EXPECT_LT((open[1] - Vector3(0.015, 0.02, 0.05 - down)).norm(), 1e-15);
  EXPECT_LT((open[2] - Vector3(0.005, 0.02, 0.05 - down)).norm(), 1e-15);
}

TEST(TissueDistance, WithoutTissueItIsInfinite) {
  TissueDistance none(sceneOf({}), {});
  EXPECT_EQ(none.measure(pointAt({0, 0, 0})), kInfinity);
  EXPECT_EQ(none.shapeCount(), 0U);
}

TEST(TissueDistance, OfABoxByFaceEdgeAndCorner) {
  TissueDistance box(sceneOf({shape(model::ShapeKind::kBox, {0.02, 0.04, 0.06})}), {"tissue"});
  EXPECT_NEAR(box.measure(pointAt({0.013, 0.01, -0.02})), 0.003, 1e-15);
  EXPECT_NEAR(box.measure(pointAt({0.013, 0.024, 0.0})), 0.005, 1e-15);
  EXPECT_NEAR(box.measure(pointAt({-0.012, -0.023, 0.036})), 0.007, 1e-15);  // 2, 3, 6
  EXPECT_EQ(box.measure(pointAt({0.009, 0.0, 0.0})), 0.0);
}

TEST(TissueDistance, OfACapsuleBesideItAndBeyondItsEnd) {
  TissueDistance capsule(sceneOf({shape(model::ShapeKind::kCapsule, {0.003, 0.02, 0.0})}), {"tissue"});
  EXPECT_NEAR(capsule.measure(pointAt({0.003, 0.004, 0.009})), 0.002, 1e-15);
  EXPECT_NEAR(capsule.measure(pointAt({0.0, 0.003, 0.014})), 0.002, 1e-15);  // 3, 4 from the end of the straight part
  EXPECT_EQ(capsule.measure(pointAt({0.0, 0.0, 0.012})), 0.0);
}

TEST(TissueDistance, OfASphere) {
  TissueDistance sphere(sceneOf({shape(model::ShapeKind::kSphere, {0.005, 0.0, 0.0})}), {"tissue"});
  EXPECT_NEAR(sphere.measure(pointAt({0.002, 0.003, 0.006})), 0.002, 1e-15);  // 2, 3, 6 -> 7
}

TEST(TissueDistance, FollowsThePosesOfLinkAndShape) {
  Pose X_WL, X_LS;
  X_WL.R = Eigen::AngleAxisd(kPi / 2, Vector3::UnitZ()).toRotationMatrix();
  X_WL.p = {0.1, 0.0, 0.0};
  X_LS.p = {0.05, 0.0, 0.0};
  TissueDistance box(sceneOf({shape(model::ShapeKind::kBox, {0.02, 0.04, 0.02}, X_LS)}, X_WL), {"tissue"});
  EXPECT_NEAR(box.measure(pointAt({0.1, 0.064, 0.0})), 0.004,
              1e-15);  // middle at (0.1, 0.05, 0), half edge 0.01 along y
  EXPECT_NEAR(box.measure(pointAt({0.124, 0.05, 0.0})), 0.004, 1e-15);
}

TEST(TissueDistance, TakesTheNearestPointOfBothTools) {
  TissueDistance box(sceneOf({shape(model::ShapeKind::kBox, {0.02, 0.02, 0.02})}), {"tissue"});
  const Vector3 far(0.5, 0.0, 0.0), near(0.0, 0.0, 0.011);
  EXPECT_NEAR(box.measure({ToolPoints{far, far, far}, ToolPoints{far + near, near, far}}), 0.001, 1e-15);
}

/** Distance to a box by projecting the point onto each face. */
double slowBox(const Vector3& half, const Vector3& p) {
  double least = kInfinity;
  bool inside = true;
  for (int axis = 0; axis < 3; ++axis) {
    inside = inside && std::abs(p(axis)) <= half(axis);
    for (const double side : {-1.0, 1.0}) {
      Vector3 q = p;
      for (int i = 0; i < 3; ++i)
        q(i) = std::min(std::max(q(i), -half(i)), half(i));
      q(axis) = side * half(axis);
      least = std::min(least, (p - q).norm());
    }
  }
  return inside ? 0.0 : least;
}

TEST(TissueDistance, WhatItPassesOverIsNeverNearer) {
  // many boxes, tools that jump about: the result is the least over all boxes and points, each by itself
  Random random(11);
  std::vector<model::CollisionShape> shapes;
  std::vector<Pose> poses;
  std::vector<Vector3> halves;
  for (int i = 0; i < 90; ++i) {
    Pose X;
    const Vector3 axis = Vector3(random.normal(), random.normal(), random.normal()).normalized();
    X.R = Eigen::AngleAxisd(random.uniform(0, 6), axis).toRotationMatrix();
    X.p = {random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1)};
    const Vector3 half(random.uniform(0.001, 0.02), random.uniform(0.001, 0.02), random.uniform(0.001, 0.02));
    shapes.push_back(shape(model::ShapeKind::kBox, 2.0 * half, X));
    poses.push_back(X);
    halves.push_back(half);
  }
  TissueDistance tissue(sceneOf(shapes), {"tissue"});
  ASSERT_EQ(tissue.shapeCount(), 90U);
  int apart = 0;
  for (int i = 0; i < 2000; ++i) {
    PerArm<ToolPoints> tools;
    double expected = kInfinity;
    for (ToolPoints& points : tools) {
      Pose X_WT;
      const Vector3 axis = Vector3(random.normal(), random.normal(), random.normal()).normalized();
      X_WT.R = Eigen::AngleAxisd(random.uniform(0, 6), axis).toRotationMatrix();
      X_WT.p = {random.uniform(-0.15, 0.15), random.uniform(-0.15, 0.15), random.uniform(-0.15, 0.15)};
      points = toolPoints(X_WT, random.uniform(0.0, 1.5));
      for (const Vector3& p : points) {
        for (std::size_t k = 0; k < poses.size(); ++k)
          expected = std::min(expected, slowBox(halves[k], poses[k].inverse() * p));
      }
    }
    ASSERT_NEAR(tissue.measure(tools), expected, 1e-12);
    apart += expected > 0.0 ? 1 : 0;
  }
  EXPECT_GT(apart, 200);
}

TEST(TissueDistance, PlacesThatAreNoNumbersAreNowhere) {
  TissueDistance box(sceneOf({shape(model::ShapeKind::kBox, {0.02, 0.02, 0.02})}), {"tissue"});
  const Vector3 nowhere = Vector3::Constant(std::nan(""));
  EXPECT_EQ(box.measure(pointAt(nowhere, nowhere)), kInfinity);
  EXPECT_NEAR(box.measure(pointAt(nowhere, {0.0, 0.0, 0.011})), 0.001, 1e-15);
}

TEST(TissueDistance, RefusesWhatItCannotMeasure) {
  const model::SceneModel mesh = sceneOf({shape(model::ShapeKind::kMesh, {0, 0, 0})});
  model::SceneModel moving = sceneOf({shape(model::ShapeKind::kBox, {1, 1, 1})});
  moving.description.links[0].joint = model::JointKind::kFloating;
  EXPECT_THROW(TissueDistance(mesh, {"tissue"}), ConfigException);
  EXPECT_THROW(TissueDistance(moving, {"tissue"}), ConfigException);
  EXPECT_THROW(TissueDistance(mesh, {"other"}), ConfigException);
}

}  // namespace
}  // namespace raven2_trainer::training
