#include "raven2_trainer/render/renderer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "raven2_trainer/core/exceptions.h"
#include "render/edge_smoother.h"
#include "render/gl_context.h"
#include "render/overlay_painter.h"
#include "render/passes.h"
#include "render/projection.h"

namespace raven2_trainer::render {

struct Renderer::Impl {
  Impl(int width, int height)
      : context(width, height),
        shadow(height),
        picture(width, height),
        layer(width, height),
        smoother(width, height),
        overlay(width, height),
        rgba(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 4),
        rgb(rgba.size() / 4 * 3) {
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_LEQUAL);
    glEnable(GL_CULL_FACE);
  }

  void sortItems(const Scene& scene, const Vector3& eye_W);
  void drawPicture(const model::Camera& camera);
  void drawView(const model::Camera& camera, int x, int y, int view_width, int view_height);
  void drawInset(const model::Camera& inset);
  void finishStage(const char* stage) const;

  GlContext context;
  ShadowPass shadow;
  PictureTarget picture;
  MeshPass meshes;
  PartPass parts;
  FixedLayer layer;
  EdgeSmoother smoother;
  OverlayPainter overlay;
  std::vector<std::unique_ptr<GpuMesh>> gpu_meshes;
  DrawLists lists;
  Eigen::Matrix4f shadow_clip_from_world;
  std::vector<std::uint8_t> rgba, rgb;
  StageDone stage_done;
};

namespace {

bool isFinite(const std::array<float, 4>& colour) noexcept {
  return std::all_of(colour.begin(), colour.end(), [](float c) { return std::isfinite(c); });
}

bool isUsable(const model::Camera& c) noexcept {
  return isDrawable(c.X_WC) && c.width > 0 && c.height > 0 && std::isfinite(c.fx) && std::isfinite(c.fy) &&
         c.fx > 0.0 && c.fy > 0.0 && std::isfinite(c.cx) && std::isfinite(c.cy);
}

constexpr int kInsetMargin = 12;  // [px]
constexpr int kInsetFrame = 2;    // [px]

}  // namespace

/** Sorts what can be drawn into things, marks and translucent items. Near things come first: what they hide costs no
 * shading.
 */
void Renderer::Impl::sortItems(const Scene& scene, const Vector3& eye_W) {
  lists.opaque.clear();
  lists.marks.clear();
  lists.translucent.clear();
  for (const Drawable& drawable : scene.drawables) {
    if (drawable.mesh < 0 || static_cast<std::size_t>(drawable.mesh) >= gpu_meshes.size()) continue;
    if (!isDrawable(drawable.X_WM) || !isFinite(drawable.colour)) continue;
    const GpuMesh* mesh = gpu_meshes[static_cast<std::size_t>(drawable.mesh)].get();
    const double scale = drawable.X_WM.R.colwise().norm().maxCoeff();
    if (scale < 1e-9) continue;
    const auto& c = drawable.colour;
    auto& items = drawable.is_mark ? lists.marks : c[3] < 1.0F ? lists.translucent : lists.opaque;
    items.push_back({mesh,
                     matrixOf(drawable.X_WM),
                     drawable.X_WM * mesh->centre_M(),
                     static_cast<float>(scale),
                     scale * mesh->radius(),
                     {c[0], c[1], c[2], c[3]},
                     drawable.first,
                     drawable.count,
                     drawable.is_fixed,
                     drawable.part});
  }
  const auto nearness = [&eye_W](const DrawItem& item) { return (item.centre_W - eye_W).norm() + item.radius; };
  std::stable_sort(lists.opaque.begin(), lists.opaque.end(),
                   [&](const DrawItem& a, const DrawItem& b) { return nearness(a) < nearness(b); });
}

/** From the layer of fixed things, if that was made before. */
void Renderer::Impl::drawPicture(const model::Camera& camera) {
  if (!isUsable(camera) || camera.width != context.width() || camera.height != context.height())
    return drawView(camera, 0, 0, context.width(), context.height());
  glViewport(0, 0, context.width(), context.height());
  layer.look(lists.opaque, camera, shadow_clip_from_world);
  if (layer.isWorthKeeping() && shadow.fixedMap() != nullptr)
    meshes.keep(&layer, lists, camera, {*shadow.fixedMap(), shadow_clip_from_world});
  const MeshPass::Light light{shadow.map(), shadow_clip_from_world};
  if (layer.isKept()) return meshes.drawOver(&layer, picture, lists, camera, light);
  meshes.draw(lists, camera, light);
}

void Renderer::Impl::drawView(const model::Camera& camera, int x, int y, int view_width, int view_height) {
  static const DrawLists kNothing;
  glViewport(x, y, view_width, view_height);
  glScissor(x, y, view_width, view_height);
  glEnable(GL_SCISSOR_TEST);
  meshes.draw(isUsable(camera) ? lists : kNothing, camera, {shadow.map(), shadow_clip_from_world});
  glDisable(GL_SCISSOR_TEST);
}

/** A second view in the lower right corner, in a dark frame. */
void Renderer::Impl::drawInset(const model::Camera& inset) {
  const int w = inset.width, h = inset.height;
  const int x = context.width() - kInsetMargin - w, y = kInsetMargin;
  if (w < 1 || h < 1 || x < kInsetFrame || y + h + kInsetFrame > context.height()) return;
  glEnable(GL_SCISSOR_TEST);
  glScissor(x - kInsetFrame, y - kInsetFrame, w + 2 * kInsetFrame, h + 2 * kInsetFrame);
  glClearColor(0.13F, 0.15F, 0.18F, 1.0F);
  glClear(GL_COLOR_BUFFER_BIT);
  drawView(inset, x, y, w, h);
}

/** Waits by a fence: glFinish would read the picture back, too. */
void Renderer::Impl::finishStage(const char* stage) const {
  if (!stage_done) return;
  const GLsync fence = glFenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
  glClientWaitSync(fence, GL_SYNC_FLUSH_COMMANDS_BIT, GL_TIMEOUT_IGNORED);
  glDeleteSync(fence);
  stage_done(stage);
}

Renderer::Renderer(int width, int height) : impl_(std::make_unique<Impl>(width, height)) {}

Renderer::~Renderer() {
  impl_->context.makeCurrent();
}

void Renderer::watchStages(StageDone done) {
  impl_->stage_done = std::move(done);
}

int Renderer::width() const noexcept {
  return impl_->context.width();
}

int Renderer::height() const noexcept {
  return impl_->context.height();
}

int Renderer::addMesh(const model::Mesh& mesh) {
  impl_->context.makeCurrent();
  impl_->gpu_meshes.push_back(std::make_unique<GpuMesh>(mesh));
  return static_cast<int>(impl_->gpu_meshes.size()) - 1;
}

void Renderer::replaceMesh(int handle, const model::Mesh& mesh) {
  if (handle < 0 || static_cast<std::size_t>(handle) >= impl_->gpu_meshes.size())
    throw RenderException("there is no mesh " + std::to_string(handle) + " to replace");
  impl_->context.makeCurrent();
  const GpuMesh* old = impl_->gpu_meshes[static_cast<std::size_t>(handle)].get();
  impl_->shadow.forget(old);
  impl_->layer.forget(old);
  impl_->gpu_meshes[static_cast<std::size_t>(handle)] = std::make_unique<GpuMesh>(mesh);
}

const std::vector<std::uint8_t>& Renderer::draw(const Scene& scene,
                                                const model::Camera& camera,
                                                const model::Camera* inset) {
  Impl& impl = *impl_;
  if (scene.is_black) {
    std::fill(impl.rgb.begin(), impl.rgb.end(), std::uint8_t{0});
    return impl.rgb;
  }
  impl.context.makeCurrent();
  const bool usable = isUsable(camera);
  impl.sortItems(scene, usable ? camera.X_WC.p : Vector3(0, 0, 0));
  impl.shadow_clip_from_world = shadowClipFromWorld(usable ? camera : model::Camera{});
  std::vector<model::Camera> views{usable ? camera : model::Camera{}};
  if (inset != nullptr) views.push_back(*inset);
  impl.shadow.draw(impl.lists.opaque, impl.shadow_clip_from_world, views);
  impl.finishStage("shadow");
  impl.picture.bind();
  impl.drawPicture(camera);
  if (inset != nullptr) impl.drawInset(*inset);
  impl.finishStage("meshes");
  impl.picture.read(impl.rgba.data());
  impl.finishStage("read back");
  impl.smoother.smooth(impl.rgba.data(), impl.rgb.data());
  impl.finishStage("smoothing");
  impl.overlay.paint(scene.overlay, &impl.rgb);
  impl.finishStage("overlay");
  return impl.rgb;
}

Geometry Renderer::measure(const Scene& scene, const model::Camera& camera) {
  Impl& impl = *impl_;
  const std::size_t pixels = impl.rgba.size() / 4;
  Geometry seen{std::vector<float>(pixels), std::vector<std::uint16_t>(pixels)};
  impl.context.makeCurrent();
  impl.sortItems(scene, Vector3(0, 0, 0));
  if (!isUsable(camera)) impl.lists = {};
  impl.picture.bind();
  glViewport(0, 0, width(), height());
  impl.parts.draw(impl.lists, isUsable(camera) ? camera : model::Camera{});
  impl.picture.read(impl.rgba.data());
  impl.picture.readDepth(seen.depth.data());
  for (std::size_t i = 0; i < pixels; ++i) {
    seen.part[i] = static_cast<std::uint16_t>(impl.rgba[4 * i] + 256 * impl.rgba[4 * i + 1]);
    seen.depth[i] = seen.part[i] == 0 ? std::numeric_limits<float>::infinity() : metresOf(seen.depth[i]);
  }
  return seen;
}

}  // namespace raven2_trainer::render
