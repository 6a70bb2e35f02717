#include "render/primitives.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "raven2_trainer/core/types.h"

namespace raven2_trainer::render {

namespace {

/** A point of an outline that is turned about z, and the outward normal there. */
struct ProfilePoint {
  float r, z;
  float normal_r, normal_z;
};

void addRing(const ProfilePoint& point, int segments, model::Mesh* mesh) {
  for (int i = 0; i <= segments; ++i) {
    const double angle = 2.0 * kPi * i / segments;
    const float c = static_cast<float>(std::cos(angle)), s = static_cast<float>(std::sin(angle));
    mesh->vertices.push_back({point.r * c, point.r * s, point.z});
    mesh->normals.push_back({point.normal_r * c, point.normal_r * s, point.normal_z});
  }
}

/** Surface of revolution; consecutive points are joined, two points at one place make a sharp edge. The outline runs
 *  from low to high z with the inside on its left, so that triangles are counter-clockwise seen from outside. */
model::Mesh revolve(const std::vector<ProfilePoint>& outline, int segments) {
  model::Mesh mesh;
  for (const ProfilePoint& point : outline)
    addRing(point, segments, &mesh);
  const auto ring = static_cast<std::uint32_t>(segments + 1);
  for (std::uint32_t row = 0; row + 1 < outline.size(); ++row) {
    for (std::uint32_t i = 0; i + 1 < ring; ++i) {
      const std::uint32_t a = row * ring + i, b = a + ring;
      mesh.triangles.push_back({a, a + 1, b + 1});
      mesh.triangles.push_back({a, b + 1, b});
    }
  }
  return mesh;
}

/** Direction of a line at a point: from the point before to the point after it. If the line turns back there, the
 * direction before it.
 */
Vector3 directionAt(const std::vector<Vector3>& line, std::size_t i) {
  const Vector3& before = line[i > 0 ? i - 1 : 0];
  const Vector3 across = line[std::min(i + 1, line.size() - 1)] - before;
  if (across.norm() > 1e-9) return across.normalized();
  const Vector3 piece = line[i] - before;
  return piece.norm() > 1e-9 ? piece.normalized() : Vector3::UnitZ();
}

std::array<float, 3> toFloat(const Vector3& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

/** The part of `side` square to a direction, as a unit vector: carried along a line it does not twist. */
Vector3 squareTo(const Vector3& direction, const Vector3& side) {
  const Vector3 square = side - side.dot(direction) * direction;
  return square.norm() > 1e-6 ? square.normalized() : direction.unitOrthogonal();
}

void addCircle(const Vector3& centre, const Vector3& x, const Vector3& y, float radius, int sides, model::Mesh* mesh) {
  for (int i = 0; i < sides; ++i) {
    const double angle = 2.0 * kPi * i / sides;
    const Vector3 out = std::cos(angle) * x + std::sin(angle) * y;
    mesh->vertices.push_back(toFloat(centre + static_cast<double>(radius) * out));
    mesh->normals.push_back(toFloat(out));
  }
}

/** Between the last two circles. */
void joinCircles(std::uint32_t sides, model::Mesh* mesh) {
  const auto second = static_cast<std::uint32_t>(mesh->vertices.size()) - sides, first = second - sides;
  for (std::uint32_t i = 0; i < sides; ++i) {
    const std::uint32_t next = (i + 1) % sides;
    mesh->triangles.push_back({first + i, first + next, second + next});
    mesh->triangles.push_back({first + i, second + next, second + i});
  }
}

}  // namespace

model::Mesh makeTube(const std::vector<Vector3>& line, float radius, int sides) {
  model::Mesh mesh;
  if (line.size() < 2) return mesh;
  Vector3 side = directionAt(line, 0).unitOrthogonal();
  for (std::size_t i = 0; i < line.size(); ++i) {
    const Vector3 direction = directionAt(line, i);
    side = squareTo(direction, side);
    addCircle(line[i], side, direction.cross(side), radius, sides, &mesh);
    if (i > 0) joinCircles(static_cast<std::uint32_t>(sides), &mesh);
  }
  return mesh;
}

model::Mesh makeSphere(float radius, int segments) {
  const int rows = segments / 2 + 1;
  std::vector<ProfilePoint> outline;
  for (int i = 0; i <= rows; ++i) {
    const double angle = kPi * i / rows;  // from the south pole
    const float s = static_cast<float>(std::sin(angle)), c = static_cast<float>(-std::cos(angle));
    outline.push_back({radius * s, radius * c, s, c});
  }
  return revolve(outline, segments);
}

model::Mesh makeDisc(int segments) {
  // Two sides, each from the rim to the middle or back: a line without thickness turned about z.
  model::Mesh mesh = revolve({{0.0F, 0.0F, 0.0F, -1.0F}, {1.0F, 0.0F, 0.0F, -1.0F}}, segments);
  const model::Mesh top = revolve({{1.0F, 0.0F, 0.0F, 1.0F}, {0.0F, 0.0F, 0.0F, 1.0F}}, segments);
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), top.vertices.begin(), top.vertices.end());
  mesh.normals.insert(mesh.normals.end(), top.normals.begin(), top.normals.end());
  for (const auto& t : top.triangles)
    mesh.triangles.push_back({first + t[0], first + t[1], first + t[2]});
  return mesh;
}

model::Mesh makeMarks(const std::vector<Vector3>& points, float radius) {
  static const std::array<Vector3, 6> kCorners{Vector3::UnitX(),  Vector3::UnitY(),  Vector3::UnitZ(),
                                               -Vector3::UnitX(), -Vector3::UnitY(), -Vector3::UnitZ()};
  static constexpr std::array<std::array<std::uint32_t, 3>, 8> kFaces{
      {{0, 1, 2}, {1, 3, 2}, {3, 4, 2}, {4, 0, 2}, {1, 0, 5}, {3, 1, 5}, {4, 3, 5}, {0, 4, 5}}};
  model::Mesh mesh;
  for (const Vector3& point : points) {
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    for (const Vector3& corner : kCorners) {
      mesh.vertices.push_back(toFloat(point + static_cast<double>(radius) * corner));
      mesh.normals.push_back(toFloat(corner));
    }
    for (const auto& face : kFaces)
      mesh.triangles.push_back({first + face[0], first + face[1], first + face[2]});
  }
  return mesh;
}

model::Mesh makeArrow(int segments) {
  constexpr float kShaft = 0.055F, kHead = 0.13F, kNeck = 0.66F;  // [m] of an arrow of 1 m
  const float slope = std::hypot(1.0F - kNeck, kHead);
  const float head_r = (1.0F - kNeck) / slope, head_z = kHead / slope;
  return revolve({{0.0F, 0.0F, 0.0F, -1.0F},
                  {kShaft, 0.0F, 0.0F, -1.0F},
                  {kShaft, 0.0F, 1.0F, 0.0F},
                  {kShaft, kNeck, 1.0F, 0.0F},
                  {kShaft, kNeck, 0.0F, -1.0F},
                  {kHead, kNeck, 0.0F, -1.0F},
                  {kHead, kNeck, head_r, head_z},
                  {0.0F, 1.0F, head_r, head_z}},
                 segments);
}

}  // namespace raven2_trainer::render
