#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "raven2_trainer/haptics/haptics_config.h"
#include "raven2_trainer/model/camera.h"
#include "raven2_trainer/model/mesh.h"
#include "raven2_trainer/render/picture_config.h"
#include "raven2_trainer/render/render_config.h"
#include "raven2_trainer/render/scene.h"

namespace raven2_trainer::render {

/** Loads OpenGL if it is not loaded yet. Starts no thread, so the program may fork afterwards. The environment variable
 *  RAVEN2_TRAINER_GL chooses: osmesa, egl, or auto (default: OSMesa if installed, else EGL).
 *  @return "OSMesa" or "EGL". @throw RenderException if the library is missing or the variable invalid. */
const char* loadOpenGl();

/** Depth and part in each pixel of a camera's view; top row first. */
struct Geometry {
  std::vector<float> depth;         ///< [m] along the view direction; infinity: nothing
  std::vector<std::uint16_t> part;  ///< Drawable::part; 0: nothing
};

/** Offscreen OpenGL renderer (core profile 3.3; llvmpipe, or with EGL a GPU). Owns its context: create, use and destroy
 * it on one thread. @throw RenderException if OpenGL gives no context or a shader does not compile. */
class Renderer {
 public:
  Renderer(int width, int height);
  ~Renderer();
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;

  /** Uploads a mesh. @return its handle, for Drawable::mesh. */
  int addMesh(const model::Mesh& mesh);

  /** Uploads a mesh in place of another. @throw RenderException if no mesh has this handle. */
  void replaceMesh(int handle, const model::Mesh& mesh);

  /**
   * Draws opaque drawables, then marks, then translucent ones. Leaves out drawables with an unknown mesh, or with NaN
   * or infinity in pose or colour. With an invalid camera, draws only the background. The same scene and camera give
   * the same pixels.
   * @param[in] inset A second view of inset->width x inset->height pixels in the lower right corner; may be null. Left
   *            out if it does not fit.
   * @return RGB pixels, 8 bit, top row first, width x height x 3 bytes, valid until the next call.
   */
  const std::vector<std::uint8_t>& draw(const Scene& scene,
                                        const model::Camera& camera,
                                        const model::Camera* inset = nullptr);

  /** Depth and parts of a scene's drawables, without marks and overlays. */
  Geometry measure(const Scene& scene, const model::Camera& camera);

  int width() const noexcept;
  int height() const noexcept;

  /** Called when a stage of draw() ends: "shadow", "meshes", "read back", "smoothing", "overlay". */
  using StageDone = std::function<void(const char* stage)>;

  /** Calls `done` after each stage. draw() then waits for each stage, which costs time. Empty: no calls. */
  void watchStages(StageDone done);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/** Link names, indexed by Drawable::part: the robot's, then the scene's. The first is "", for no part. */
std::vector<std::string> partNames(const model::RavenModel& raven, const model::SceneModel& scene);

/** Settings of SceneBuilder. */
struct SceneOptions {
  SceneOptions(const HapticGains& haptic_gains, OverlaySet wanted = OverlaySet::all())
      : haptics(haptic_gains), overlays(wanted) {}
  SceneOptions(const PictureConfig& config, OverlaySet wanted);

  HapticGains haptics;
  OverlaySet overlays;
  TrailConfig trails{4.0, 0.05};
  double stale_after{0.020};        ///< [s] an older robot state is marked STALE
  std::uint32_t exercise_steps{0};  ///< of all tracks together; 0: unknown
};

/** Builds the Scene of a Snapshot: both arms, the training scene, the RCM spheres and SceneOptions::overlays
 *  (doc/pictures.md). Leaves out items with NaN or infinity. Uploads its meshes to the renderer, which must outlive
 * this builder: once, and those of paths and trails whenever they change. */
class SceneBuilder {
 public:
  SceneBuilder(const model::RavenModel& raven,
               const model::SceneModel& scene,
               const SceneOptions& options,
               Renderer* renderer);
  ~SceneBuilder();

  /**
   * Adds a state to the trails without building a scene. Only trails show earlier states. So to draw frame k alone,
   * call follow() for the frames of TrailConfig::duration before it: the pixels are the same as if all frames were
   * drawn.
   */
  void follow(const Snapshot& snapshot);

  /** Calls follow(). @return the scene, valid until the next call. */
  const Scene& build(const Snapshot& snapshot);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace raven2_trainer::render
