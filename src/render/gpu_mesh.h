#pragma once

#include <cstdint>

#include "raven2_trainer/kinematics/eigen.h"
#include "raven2_trainer/model/mesh.h"
#include "render/gl.h"

namespace raven2_trainer::render {

/** A mesh in the renderer's memory. The context must be current on every call. */
class GpuMesh {
 public:
  /** Triangles that name a vertex the mesh does not have are left out; a mesh without triangles draws nothing. */
  explicit GpuMesh(const model::Mesh& mesh);
  ~GpuMesh();
  GpuMesh(const GpuMesh&) = delete;
  GpuMesh& operator=(const GpuMesh&) = delete;

  /** @param[in] first, count triangles, in the mesh's order; as far as they go. */
  void draw(std::uint32_t first, std::uint32_t count) const noexcept;

  /** [m] Of a sphere that holds the mesh: its middle in M, which need not be near the origin, and its radius. */
  const Vector3& centre_M() const noexcept { return centre_M_; }
  double radius() const noexcept { return radius_; }

 private:
  GLuint arrays_{0}, vertices_{0}, indices_{0};
  std::uint32_t triangle_count_{0};
  Vector3 centre_M_{Vector3::Zero()};
  double radius_{0.0};
};

}  // namespace raven2_trainer::render
