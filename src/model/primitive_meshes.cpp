#include "model/primitive_meshes.h"

#include <cmath>

#include "raven2_trainer/core/types.h"

namespace raven2_trainer::model {
namespace {

constexpr unsigned kSegments = 24;
constexpr unsigned kStacks = 12;

std::array<float, 3> toFloat(const Vector3& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

std::uint32_t addVertex(const Vector3& p, const Vector3& normal, Mesh* mesh) {
  mesh->vertices.push_back(toFloat(p));
  mesh->normals.push_back(toFloat(normal));
  return static_cast<std::uint32_t>(mesh->vertices.size() - 1);
}

Vector3 onCircle(unsigned segment) {
  const double angle = 2.0 * kPi * segment / kSegments;
  return {std::cos(angle), std::sin(angle), 0.0};
}

void addFace(const Vector3& centre, const Vector3& u, const Vector3& v, Mesh* mesh) {
  const Vector3 normal = u.cross(v).normalized();
  const std::uint32_t a = addVertex(centre - u - v, normal, mesh);
  addVertex(centre + u - v, normal, mesh);
  addVertex(centre + u + v, normal, mesh);
  addVertex(centre - u + v, normal, mesh);
  mesh->triangles.push_back({a, a + 1, a + 2});
  mesh->triangles.push_back({a, a + 2, a + 3});
}

/** Disc at height z, facing along sign * z. */
void addCap(double radius, double z, double sign, Mesh* mesh) {
  const Vector3 normal(0.0, 0.0, sign);
  const std::uint32_t centre = addVertex({0.0, 0.0, z}, normal, mesh);
  for (unsigned i = 0; i <= kSegments; ++i)
    addVertex(radius * onCircle(i) + Vector3(0.0, 0.0, z), normal, mesh);
  for (unsigned i = 1; i <= kSegments; ++i) {
    mesh->triangles.push_back({centre, centre + (sign > 0 ? i : i + 1), centre + (sign > 0 ? i + 1 : i)});
  }
}

/** Triangles between two consecutive rows of kSegments + 1 vertices, the lower row starting at `low`. */
void addBand(std::uint32_t low, Mesh* mesh) {
  const std::uint32_t high = low + kSegments + 1;
  for (unsigned i = 0; i < kSegments; ++i) {
    mesh->triangles.push_back({low + i, low + i + 1, high + i + 1});
    mesh->triangles.push_back({low + i, high + i + 1, high + i});
  }
}

}  // namespace

Mesh boxMesh(const Vector3& edges) {
  Mesh mesh;
  const Vector3 x(edges.x() / 2, 0, 0), y(0, edges.y() / 2, 0), z(0, 0, edges.z() / 2);
  for (const double s : {1.0, -1.0}) {
    addFace(s * x, s * y, z, &mesh);
    addFace(s * y, s * z, x, &mesh);
    addFace(s * z, s * x, y, &mesh);
  }
  return mesh;
}

Mesh sphereMesh(double radius) {
  Mesh mesh;
  for (unsigned stack = 0; stack <= kStacks; ++stack) {
    const double latitude = kPi * (static_cast<double>(stack) / kStacks - 0.5);
    for (unsigned i = 0; i <= kSegments; ++i) {
      const Vector3 n = std::cos(latitude) * onCircle(i) + Vector3(0.0, 0.0, std::sin(latitude));
      addVertex(radius * n, n, &mesh);
    }
  }
  for (unsigned stack = 0; stack < kStacks; ++stack)
    addBand(stack * (kSegments + 1), &mesh);
  return mesh;
}

Mesh cylinderMesh(double radius, double length) {
  Mesh mesh;
  for (const double z : {-length / 2, length / 2}) {
    for (unsigned i = 0; i <= kSegments; ++i) {
      addVertex(radius * onCircle(i) + Vector3(0.0, 0.0, z), onCircle(i), &mesh);
    }
  }
  addBand(0, &mesh);
  addCap(radius, length / 2, 1.0, &mesh);
  addCap(radius, -length / 2, -1.0, &mesh);
  return mesh;
}

}  // namespace raven2_trainer::model
