#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "raven2_trainer/model/camera.h"
#include "raven2_trainer/model/mesh.h"
#include "raven2_trainer/render/scene.h"

namespace raven2_trainer::render {

/** Offscreen OpenGL renderer (OSMesa, core profile, llvmpipe). Owns its context: create, use and destroy it on one
 *  thread. @throw RenderException if no context can be had or a shader does not compile. */
class Renderer {
 public:
  Renderer(int width, int height);
  ~Renderer();
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;

  /** Uploads a mesh; the handle goes into Drawable::mesh. */
  int addMesh(const model::Mesh& mesh);

  /** Uploads a mesh in place of another. @throw RenderException if no mesh has this handle. */
  void replaceMesh(int handle, const model::Mesh& mesh);

  /**
   * Draws things, then marks, then what is translucent. Drawables with an unknown mesh, or with NaN or infinity in pose
   * or colour, are left out; so is everything but the background if the camera is not finite. The same scene and camera
   * give the same pixels.
   * @param[in] inset a second view of inset->width x inset->height pixels in the lower right corner; may be null; left
   *            out where it does not fit.
   * @return pixels: RGB, 8 bit, top row first, width x height x 3 bytes, valid until the next call.
   */
  const std::vector<std::uint8_t>& draw(const Scene& scene,
                                        const model::Camera& camera,
                                        const model::Camera* inset = nullptr);

  int width() const noexcept;
  int height() const noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/** Builds the Scene of a Snapshot: both arms, the FRS scene, the RCM spheres, a ghost of the robot where it parts
 *  from the model, the path of the plan at hand and a ghost of its arm at the goal, the overlay. Uploads its meshes to
 *  the renderer, which must outlive it: once, and that of a path whenever there is a new one. */
class SceneBuilder {
 public:
  SceneBuilder(const model::RavenModel& raven,
               const model::SceneModel& scene,
               const HapticGains& haptics,
               Renderer* renderer);
  ~SceneBuilder();
  const Scene& build(const Snapshot& snapshot);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace raven2_trainer::render
