#include "model/primitive_meshes.h"

#include <gtest/gtest.h>

#include <cmath>

#include "raven2_trainer/core/types.h"

// Boxes, spheres and cylinders as they are drawn: closed, outward, and as large as they are said to be.

namespace raven2_trainer::model {
namespace {

Vector3 toVector(const std::array<float, 3>& a) {
  return {a[0], a[1], a[2]};
}

/** [m3] By the divergence theorem: that of a closed surface whose triangles all face outward. */
double volumeOf(const Mesh& mesh) {
  double sum = 0.0;
  for (const auto& t : mesh.triangles)
    sum += toVector(mesh.vertices[t[0]]).dot(toVector(mesh.vertices[t[1]]).cross(toVector(mesh.vertices[t[2]]))) / 6.0;
  return sum;
}

/** About its own middle, every triangle faces outward, and its corners' normals are near its own. */
void expectOutward(const Mesh& mesh, double least_alignment) {
  for (const auto& t : mesh.triangles) {
    const Vector3 a = toVector(mesh.vertices[t[0]]), b = toVector(mesh.vertices[t[1]]),
                  c = toVector(mesh.vertices[t[2]]);
    const Vector3 n = (b - a).cross(c - a);
    if (n.norm() < 1e-12) continue;  // at a pole
    EXPECT_GT(n.dot(a + b + c), 0.0);
    for (const auto i : t)
      EXPECT_GT(toVector(mesh.normals[i]).dot(n.normalized()), least_alignment);
  }
}

void expectExtent(const Mesh& mesh, const Vector3& half) {
  Vector3 low = Vector3::Constant(1e9), high = -low;
  for (const auto& vertex : mesh.vertices) {
    low = low.cwiseMin(toVector(vertex));
    high = high.cwiseMax(toVector(vertex));
  }
  EXPECT_LT((high - half).norm(), 1e-6);
  EXPECT_LT((low + half).norm(), 1e-6);
}

TEST(PrimitiveMesh, BoxHasItsEdges) {
  const Mesh box = boxMesh({0.02, 0.05, 0.11});
  expectOutward(box, 0.9999);
  expectExtent(box, {0.01, 0.025, 0.055});
  EXPECT_NEAR(volumeOf(box), 0.02 * 0.05 * 0.11, 1e-9);
}

TEST(PrimitiveMesh, SphereHasItsRadius) {
  const Mesh sphere = sphereMesh(0.03);
  expectOutward(sphere, 0.9);
  expectExtent(sphere, Vector3::Constant(0.03));
  const double exact = 4.0 / 3.0 * kPi * std::pow(0.03, 3);
  EXPECT_LT(volumeOf(sphere), exact);
  EXPECT_GT(volumeOf(sphere), 0.95 * exact) << "flat triangles cut some off";
}

TEST(PrimitiveMesh, CylinderHasItsRadiusAndLengthAndBothCaps) {
  const Mesh cylinder = cylinderMesh(0.01, 0.08);
  expectOutward(cylinder, 0.9);
  expectExtent(cylinder, {0.01, 0.01, 0.04});
  // A prism whose base is a polygon of n corners on the circle: n/2 sin(2 pi / n) r^2.
  std::size_t corners = 0;
  for (const auto& vertex : cylinder.vertices)
    corners += vertex[2] > 0.0F ? 1 : 0;
  corners = (corners - 3) / 2;  // of the wall and of the cap, each circle closed by its first corner again; a centre
  const double n = static_cast<double>(corners);
  EXPECT_NEAR(volumeOf(cylinder), 0.5 * n * std::sin(2 * kPi / n) * 1e-4 * 0.08, 1e-10);
}

}  // namespace
}  // namespace raven2_trainer::model
