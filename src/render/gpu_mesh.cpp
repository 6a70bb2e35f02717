#include "render/gpu_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

namespace raven2_trainer::render {

namespace {

using Interleaved = std::array<float, 6>;  // position, normal

std::vector<Interleaved> interleave(const model::Mesh& mesh) {
  std::vector<Interleaved> out(mesh.vertices.size());
  for (std::size_t i = 0; i < out.size(); ++i) {
    const auto& p = mesh.vertices[i];
    const std::array<float, 3> n = i < mesh.normals.size() ? mesh.normals[i] : std::array<float, 3>{0, 0, 1};
    out[i] = {p[0], p[1], p[2], n[0], n[1], n[2]};
  }
  return out;
}

std::vector<std::uint32_t> validIndices(const model::Mesh& mesh) {
  std::vector<std::uint32_t> out;
  out.reserve(mesh.triangles.size() * 3);
  for (const auto& t : mesh.triangles) {
    if (*std::max_element(t.begin(), t.end()) < mesh.vertices.size()) out.insert(out.end(), t.begin(), t.end());
  }
  return out;
}

Vector3 position(const std::array<float, 3>& p) {
  return {static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])};
}

/** Of the box about all vertices. */
Vector3 middle(const model::Mesh& mesh) {
  if (mesh.vertices.empty()) return Vector3::Zero();
  Vector3 low = position(mesh.vertices.front()), high = low;
  for (const auto& p : mesh.vertices) {
    low = low.cwiseMin(position(p));
    high = high.cwiseMax(position(p));
  }
  return 0.5 * (low + high);
}

double farthest(const model::Mesh& mesh, const Vector3& from) {
  double squared = 0.0;
  for (const auto& p : mesh.vertices)
    squared = std::max(squared, (position(p) - from).squaredNorm());
  return std::sqrt(squared);
}

void describeAttribute(GLuint location, std::size_t offset) {
  glVertexAttribPointer(location, 3, GL_FLOAT, GL_FALSE, sizeof(Interleaved), reinterpret_cast<const void*>(offset));
  glEnableVertexAttribArray(location);
}

template <typename T>
GLuint upload(GLenum target, const std::vector<T>& data) {
  GLuint buffer = 0;
  glGenBuffers(1, &buffer);
  glBindBuffer(target, buffer);
  glBufferData(target, static_cast<GLsizeiptr>(data.size() * sizeof(T)), data.data(), GL_STATIC_DRAW);
  return buffer;
}

}  // namespace

GpuMesh::GpuMesh(const model::Mesh& mesh) : centre_M_(middle(mesh)), radius_(farthest(mesh, centre_M_)) {
  const std::vector<std::uint32_t> indices = validIndices(mesh);
  triangle_count_ = static_cast<std::uint32_t>(indices.size() / 3);
  glGenVertexArrays(1, &arrays_);
  glBindVertexArray(arrays_);
  vertices_ = upload(GL_ARRAY_BUFFER, interleave(mesh));
  indices_ = upload(GL_ELEMENT_ARRAY_BUFFER, indices);
  describeAttribute(0, 0);
  describeAttribute(1, 3 * sizeof(float));
  glBindVertexArray(0);
}

GpuMesh::~GpuMesh() {
  glDeleteBuffers(1, &vertices_);
  glDeleteBuffers(1, &indices_);
  glDeleteVertexArrays(1, &arrays_);
}

void GpuMesh::draw(std::uint32_t first, std::uint32_t count) const noexcept {
  if (first >= triangle_count_) return;
  const std::uint32_t drawn = std::min(count, triangle_count_ - first);
  if (drawn == 0) return;
  glBindVertexArray(arrays_);
  glDrawElements(GL_TRIANGLES, static_cast<GLsizei>(3 * drawn), GL_UNSIGNED_INT,
                 reinterpret_cast<const void*>(std::size_t{3} * first * sizeof(std::uint32_t)));
}

}  // namespace raven2_trainer::render
