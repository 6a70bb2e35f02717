#include "render/primitives.h"

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

}  // namespace

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
