#include "render/primitives.h"

#include <gtest/gtest.h>

#include <cmath>

namespace raven2_trainer::render {
namespace {

constexpr float kRadius = 0.01F;  // [m]
constexpr int kSides = 6;

Vector3 toVector(const std::array<float, 3>& a) {
  return {a[0], a[1], a[2]};
}

std::vector<Vector3> bentLine() {
  std::vector<Vector3> line;
  for (int i = 0; i <= 20; ++i) {
    const double t = 0.2 * i;
    line.push_back({std::cos(t), std::sin(t), 0.3 * t});  // a helix
  }
  return line;
}

/** Volume within a closed or nearly closed surface, by the divergence theorem. */
double volume(const model::Mesh& mesh) {
  double sum = 0.0;
  for (const auto& t : mesh.triangles) {
    const Vector3 a = toVector(mesh.vertices[t[0]]), b = toVector(mesh.vertices[t[1]]),
                  c = toVector(mesh.vertices[t[2]]);
    sum += a.dot(b.cross(c)) / 6.0;
  }
  return sum;
}

TEST(Primitives, EveryPointOfATubeIsItsRadiusAwayFromTheLine) {
  const std::vector<Vector3> line = bentLine();
  const model::Mesh tube = makeTube(line, kRadius, kSides);
  ASSERT_EQ(tube.vertices.size(), line.size() * kSides);
  for (std::size_t i = 0; i < tube.vertices.size(); ++i) {
    const Vector3 out = toVector(tube.vertices[i]) - line[i / kSides];
    EXPECT_NEAR(out.norm(), kRadius, 1e-6);
    EXPECT_LT((out.normalized() - toVector(tube.normals[i])).norm(), 1e-4);
  }
}

TEST(Primitives, ATubeShowsItsOutside) {
  // A prism with a regular hexagon as its base. The tube has no end faces.
  const double length = 0.5, base = 1.5 * std::sqrt(3.0) * kRadius * kRadius;
  const Vector3 from(0.0, 0.0, -length / 2.0), to(0.0, 0.0, length / 2.0);
  // The missing ends account for a third of the prism: each is the base of a pyramid to the origin.
  EXPECT_NEAR(volume(makeTube({from, to}, kRadius, kSides)), base * length * 2.0 / 3.0, 1e-3 * base * length);
}

TEST(Primitives, TheTrianglesOfATubeStandInTheOrderOfTheLine) {
  const std::vector<Vector3> line = bentLine();
  const model::Mesh tube = makeTube(line, kRadius, kSides);
  ASSERT_EQ(tube.triangles.size(), (line.size() - 1) * 2 * kSides);
  for (std::size_t i = 0; i < tube.triangles.size(); ++i) {
    for (const std::uint32_t vertex : tube.triangles[i]) {
      const std::size_t piece = i / (2 * kSides);
      EXPECT_TRUE(vertex / kSides == piece || vertex / kSides == piece + 1) << i;
    }
  }
}

TEST(Primitives, ATubeDoesNotTwistAlongItsLine) {
  const std::vector<Vector3> line = bentLine();
  const model::Mesh tube = makeTube(line, kRadius, kSides);
  for (std::size_t i = 0; i + kSides < tube.vertices.size(); ++i) {
    const double turned = toVector(tube.normals[i]).dot(toVector(tube.normals[i + kSides]));
    EXPECT_GT(turned, std::cos(0.21)) << "the normals turn no more than the line does in a piece, 0.2 rad";
  }
}

TEST(Primitives, ALineThatTurnsBackOrStandsStillStaysFinite) {
  const Vector3 a(0.1, 0.2, 0.3), b(0.2, 0.2, 0.3);
  for (const auto& line : {std::vector<Vector3>{a, b, a}, {a, a}, {a, b, b, a, b}}) {
    const model::Mesh tube = makeTube(line, kRadius, kSides);
    ASSERT_EQ(tube.vertices.size(), line.size() * kSides);
    for (const auto& vertex : tube.vertices)
      EXPECT_TRUE(toVector(vertex).allFinite());
  }
  EXPECT_TRUE(makeTube({}, kRadius, kSides).triangles.empty());
  EXPECT_TRUE(makeTube({a}, kRadius, kSides).vertices.empty());
}

TEST(Primitives, MarksAreOctahedraAboutTheirPointsWithTheirFacesOutward) {
  EXPECT_TRUE(makeMarks({}, kRadius).triangles.empty());
  const std::vector<Vector3> points{{0.1, 0.2, 0.3}, {-0.4, 0.0, 0.1}};
  const model::Mesh marks = makeMarks(points, kRadius);
  EXPECT_EQ(marks.triangles.size(), 16U);
  EXPECT_NEAR(volume(marks), 2.0 * 4.0 / 3.0 * std::pow(double{kRadius}, 3), 1e-9);
  for (std::size_t i = 0; i < marks.vertices.size(); ++i)
    EXPECT_NEAR((toVector(marks.vertices[i]) - points[i / 6]).norm(), kRadius, 1e-6);
}

TEST(Primitives, ADiscIsSeenFromBothSides) {
  const int segments = 24;
  const model::Mesh disc = makeDisc(segments);
  PerArm<double> area{};  // of the faces that point down and up
  for (const auto& t : disc.triangles) {
    const Vector3 a = toVector(disc.vertices[t[0]]), b = toVector(disc.vertices[t[1]]),
                  c = toVector(disc.vertices[t[2]]);
    const Vector3 twice = (b - a).cross(c - a);
    EXPECT_NEAR(std::hypot(twice.x(), twice.y()), 0.0, 1e-6) << "flat";
    EXPECT_GE(twice.z() * disc.normals[t[0]][2], -1e-6F) << "the normal is on the visible side";
    area[twice.z() > 0.0 ? 1 : 0] += 0.5 * std::abs(twice.z());
  }
  const double polygon = 0.5 * segments * std::sin(2.0 * kPi / segments);
  EXPECT_NEAR(area[0], polygon, 1e-5);
  EXPECT_NEAR(area[1], polygon, 1e-5);
}

}  // namespace
}  // namespace raven2_trainer::render
