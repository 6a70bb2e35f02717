#pragma once

#include <functional>
#include <vector>

#include "raven2_trainer/model/camera.h"
#include "render/fixed_layer.h"
#include "render/gpu_mesh.h"
#include "render/shader_program.h"
#include "render/shadow_target.h"

namespace raven2_trainer::render {

/** A drawable that passed the checks: its mesh exists, its pose and colour are finite. */
struct DrawItem {
  const GpuMesh* mesh;
  Eigen::Matrix4f world_from_mesh;
  Vector3 centre_W;  ///< [m] of the sphere that holds the mesh
  float scale;       ///< [-] of the mesh in the pose, above zero
  double radius;     ///< [m] of that sphere
  Eigen::Vector4f colour;
  std::uint32_t first, count;  ///< triangles of the mesh
  bool is_fixed;               ///< Drawable::is_fixed
  std::uint16_t part;          ///< Drawable::part
};

/** Contents of a picture, sorted by how they are drawn. */
struct DrawLists {
  std::vector<DrawItem> opaque, marks, translucent;
};

/** Depth map from the key light. While the light's space does not change, the depth of fixed things is kept and
 *  copied; the map is the same as without this. */
class ShadowPass {
 public:
  explicit ShadowPass(int picture_height);

  /** @param[in] cameras nothing is drawn whose shadow none of them can see. */
  void draw(const std::vector<DrawItem>& opaque,
            const Eigen::Matrix4f& shadow_clip_from_world,
            const std::vector<model::Camera>& cameras);

  /** To be called before a mesh goes. */
  void forget(const GpuMesh* mesh) noexcept;

  GLuint texture() const noexcept { return target_.texture(); }
  const ShadowTarget& map() const noexcept { return target_; }
  /** Of what is fixed alone; null if that is not kept. */
  const ShadowTarget* fixedMap() const noexcept { return is_kept_ ? &fixed_ : nullptr; }

 private:
  using Filter = std::function<bool(const DrawItem&)>;
  void drawItems(const std::vector<DrawItem>& items, const Filter& isWanted) const;
  void keepFixed(const std::vector<DrawItem>& opaque);
  bool areKept(const std::vector<DrawItem>& opaque) const;

  ShadowTarget target_, fixed_;
  Eigen::Matrix4f clip_from_world_{Eigen::Matrix4f::Zero()};
  std::vector<DrawItem> kept_;  // whose depth `fixed_` has
  bool is_kept_{false};         // so it has
  ShaderProgram program_;
  GLint clip_from_mesh_;
};

/**
 * Background, lit meshes and marks, into whatever framebuffer and viewport is set. A moving and a fixed thing may be
 * equally deep: then the moving one is seen. Of two fixed things the first is seen, of two moving ones the last. So the
 * order of drawing does not matter, nor whether a layer was kept.
 */
class MeshPass {
 public:
  /** The light's map of what is in it, and where that lies. */
  struct Light {
    const ShadowTarget& shadow_map;
    const Eigen::Matrix4f& shadow_clip_from_world;
  };

  MeshPass();
  void draw(const DrawLists& lists, const model::Camera& camera, const Light& light);
  /** The same picture, from a layer that is kept: all of `picture`, which is bound then. */
  void drawOver(FixedLayer* layer,
                const PictureTarget& picture,
                const DrawLists& lists,
                const model::Camera& camera,
                const Light& light);
  /** Fills the layer, which is bound then. @param[in] light of what is fixed alone. */
  void keep(FixedLayer* layer, const DrawLists& lists, const model::Camera& camera, const Light& light);

 private:
  using Filter = bool (*)(const DrawItem&);
  void shine(const model::Camera& camera, const Light& light);
  void drawRest(const DrawLists& lists, const model::Camera& camera) const;
  void drawBackground() const;
  void drawItems(const std::vector<DrawItem>& items, const model::Camera& camera, Filter isWanted = nullptr) const;
  void drawMarks(const std::vector<DrawItem>& items, const model::Camera& camera) const;
  void drawTranslucent(const std::vector<DrawItem>& items, const model::Camera& camera) const;

  ShaderProgram background_, program_;
  GLuint no_arrays_{0};
  Eigen::Matrix4f shadow_from_world_{Eigen::Matrix4f::Identity()};
  float shadow_lift_W_{0.0F};  // [m] along the normal, see draw()
  GLint clip_from_mesh_, world_from_mesh_, shadow_from_mesh_, shadow_lift_, colour_, eye_W_;
};

/** Numbers of parts as colours, red the lower byte and green the upper one, into whatever framebuffer and viewport is
 * set. */
class PartPass {
 public:
  PartPass();
  void draw(const DrawLists& lists, const model::Camera& camera) const;

 private:
  ShaderProgram program_;
  GLint clip_from_mesh_, colour_;
};

}  // namespace raven2_trainer::render
