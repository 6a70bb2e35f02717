#pragma once

#include <functional>
#include <vector>

#include "raven2_trainer/model/camera.h"
#include "render/gpu_mesh.h"
#include "render/picture_target.h"
#include "render/shade_tiles.h"
#include "render/shader_program.h"
#include "render/shadow_target.h"

namespace raven2_trainer::render {

struct DrawItem;

/** Whether all that a picture shows of two items is the same. */
bool isSameLook(const DrawItem& a, const DrawItem& b) noexcept;

/**
 * The fixed things before a fixed camera, drawn once, with their own shadows. Their colours
 * and depth are copied into each picture. They are drawn again only where a moving thing may shade them. No pixel
 * differs from a picture in which all of it is drawn.
 */
class FixedLayer {
 public:
  FixedLayer(int width, int height);
  ~FixedLayer();
  FixedLayer(const FixedLayer&) = delete;
  FixedLayer& operator=(const FixedLayer&) = delete;

  /**
   * Before each picture. A view is kept when it is seen for the second time.
   * @param[in] opaque those of them that are fixed count.
   */
  void look(const std::vector<DrawItem>& opaque,
            const model::Camera& camera,
            const Eigen::Matrix4f& shadow_clip_from_world);
  bool isKept() const noexcept { return is_kept_; }
  bool isWorthKeeping() const noexcept { return !is_kept_ && is_seen_again_; }

  /** Draws it. @param[in] fixed_map of what is fixed alone. @param[in] margin as ShadeTiles::setPicture's. */
  void keep(const std::function<void()>& draw, const ShadowTarget& fixed_map, float margin);

  /**
   * All of it; the picture is bound then, and its stencil is 1 where the layer has to be drawn again, else 0.
   * @return whether that is anywhere.
   */
  bool copyTo(const PictureTarget& picture, const ShadowTarget& map);

  /** The smallest rectangle that holds all that has to be drawn again in the picture that was copied last. */
  const PixelRun& touched() const noexcept { return touched_; }

  /** To be called before a mesh goes. */
  void forget(const GpuMesh* mesh) noexcept;

 private:
  bool mark(const std::vector<PixelRun>& runs);

  const int width_, height_;
  PictureTarget target_;
  GLuint arrays_{0}, corners_{0};
  ShadeTiles tiles_;
  ShaderProgram marker_;
  std::vector<DrawItem> items_;  // that were looked at
  model::Camera camera_;
  Eigen::Matrix4f shadow_clip_from_world_{Eigen::Matrix4f::Zero()};
  bool is_kept_{false}, is_seen_again_{false};
  PixelRun touched_{};
  std::vector<float> depth_, shadow_;
  std::vector<Eigen::Vector2f> triangles_;
};

}  // namespace raven2_trainer::render
