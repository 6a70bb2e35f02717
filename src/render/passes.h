#pragma once

#include <vector>

#include "raven2_trainer/model/camera.h"
#include "render/gpu_mesh.h"
#include "render/shader_program.h"
#include "render/shadow_target.h"

namespace raven2_trainer::render {

/** A drawable that passed the checks: its mesh exists, its pose and colour are finite. */
struct DrawItem {
  const GpuMesh* mesh;
  Eigen::Matrix4f world_from_mesh;
  Vector3 centre_W;  ///< [m] origin of the mesh
  float scale;       ///< [-] of the mesh in the pose, above zero
  double radius;     ///< [m] of the sphere about it that holds the mesh
  Eigen::Vector4f colour;
  std::uint32_t first, count;  ///< triangles of the mesh
};

/** What a picture shows, by how it is drawn. */
struct DrawLists {
  std::vector<DrawItem> opaque, marks, translucent;
};

/** Depth map from the key light. */
class ShadowPass {
 public:
  ShadowPass();
  void draw(const std::vector<DrawItem>& opaque, const Eigen::Matrix4f& shadow_clip_from_world);
  GLuint texture() const noexcept { return target_.texture(); }

 private:
  ShadowTarget target_;
  ShaderProgram program_;
  GLint clip_from_mesh_;
};

/** Background, lit meshes and marks, into whatever framebuffer and viewport is set. */
class MeshPass {
 public:
  MeshPass();
  void draw(const DrawLists& lists,
            const model::Camera& camera,
            GLuint shadow_map,
            const Eigen::Matrix4f& shadow_clip_from_world);

 private:
  void drawBackground() const;
  void drawItems(const std::vector<DrawItem>& items, const model::Camera& camera) const;
  void drawMarks(const std::vector<DrawItem>& items, const model::Camera& camera) const;
  void drawTranslucent(const std::vector<DrawItem>& items, const model::Camera& camera) const;

  ShaderProgram background_, program_;
  GLuint no_arrays_{0};
  Eigen::Matrix4f shadow_from_world_{Eigen::Matrix4f::Identity()};
  float shadow_lift_W_{0.0F};  // [m] along the normal, see draw()
  GLint clip_from_mesh_, world_from_mesh_, shadow_from_mesh_, shadow_lift_, colour_, eye_W_;
};

}  // namespace raven2_trainer::render
