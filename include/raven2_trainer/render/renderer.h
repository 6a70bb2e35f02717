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

/** Loads what pictures are drawn with, if it is not loaded yet, and starts nothing: a program may fork afterwards.
 * OSMesa where it is installed, else EGL; the environment variable RAVEN2_TRAINER_GL chooses (auto, osmesa, egl).
 *  @return "OSMesa" or "EGL". @throw RenderException if neither is there. */
const char* loadOpenGl();

/** View of a camera in each pixel; top row first. */
struct Geometry {
  std::vector<float> depth;         ///< [m] along the view direction; infinity: nothing
  std::vector<std::uint16_t> part;  ///< Drawable::part; 0: nothing
};

/** Offscreen OpenGL renderer (core profile 3.3; llvmpipe, or with EGL a GPU). Owns its context: create, use and destroy
 * it on one thread. @throw RenderException if no context can be had or a shader does not compile. */
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

  /** Depth and parts of the things in a scene, without marks and overlays. */
  Geometry measure(const Scene& scene, const model::Camera& camera);

  int width() const noexcept;
  int height() const noexcept;

  /** Called when a stage of draw() is over: "shadow", "meshes", "read back", "smoothing", "overlay". */
  using StageDone = std::function<void(const char* stage)>;

  /** For measuring: each stage is waited for before the next one begins, which costs time. Empty: no more. */
  void watchStages(StageDone done);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/** Names of the parts by Drawable::part: the robot's links, then the scene's; the first is "", for nothing. */
std::vector<std::string> partNames(const model::RavenModel& raven, const model::SceneModel& scene);

/** Overlays of SceneBuilder. */
struct SceneOptions {
  SceneOptions(const HapticGains& haptic_gains, OverlaySet wanted = OverlaySet::all())
      : haptics(haptic_gains), overlays(wanted) {}
  SceneOptions(const PictureConfig& config, OverlaySet wanted);

  HapticGains haptics;
  OverlaySet overlays;
  TrailConfig trails{4.0, 0.05};
  double stale_after{0.020};        ///< [s] age from which the robot's state is marked
  std::uint32_t exercise_steps{0};  ///< of all tracks together; 0: not known
};

/** Builds the Scene of a Snapshot: both arms, the FRS scene, the RCM spheres, and what SceneOptions::overlays asks for
 *  (doc/pictures.md); what is not finite is left out. Uploads its meshes to the renderer, which must outlive it: once,
 *  and those of paths and trails whenever they change. */
class SceneBuilder {
 public:
  SceneBuilder(const model::RavenModel& raven,
               const model::SceneModel& scene,
               const SceneOptions& options,
               Renderer* renderer);
  ~SceneBuilder();

  /**
   * Takes note of a state without drawing it. Of earlier states a picture shows only trails. So a caller that draws
   * frame k alone, after follow() for the frames of TrailConfig::duration before it, gets the same pixels as one that
   * draws all.
   */
  void follow(const Snapshot& snapshot);

  /** follow(), and the scene, valid until the next call. */
  const Scene& build(const Snapshot& snapshot);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace raven2_trainer::render
