#include "render/passes.h"

#include <algorithm>
#include <iterator>

#include "render/projection.h"
#include "render/shaders.h"

namespace raven2_trainer::render {

namespace {

constexpr float kBackgroundTop[] = {0.93F, 0.94F, 0.955F};
constexpr float kBackgroundBottom[] = {0.72F, 0.74F, 0.77F};
constexpr float kHiddenMark = 0.35F;  // opacity of a mark behind things: plain on metal, and not taken for one in front

/** A vertex array without attributes, which core profile demands even where the shader makes its own vertices. */
GLuint makeEmptyArrays() {
  GLuint arrays = 0;
  glGenVertexArrays(1, &arrays);
  return arrays;
}

bool isSameShape(const DrawItem& a, const DrawItem& b) noexcept {
  return a.mesh == b.mesh && a.first == b.first && a.count == b.count && a.world_from_mesh == b.world_from_mesh;
}

bool isFixed(const DrawItem& item) {
  return item.is_fixed;
}

bool isMoving(const DrawItem& item) {
  return !item.is_fixed;
}

/** [-] Of a step of the shadow map, in the light's clip space. */
float texelOf(const ShadowTarget& map) noexcept {
  return 2.0F / static_cast<float>(map.size());
}

// A lit point is looked up 1.5 texels off its surface, or the map's steps would shade it. (A constant of MeshPass.)
constexpr float kLift = 1.5F;
// Lookups look at the four texels about their point, half of one beyond it each way, which may be 1.5 off what is lit.
constexpr float kMargin = kLift + 1.5F;  // [texels]

}  // namespace

ShadowPass::ShadowPass(int picture_height)
    : target_(ShadowTarget::sizeFor(picture_height)),
      fixed_(target_.size()),
      program_(kShadowVertex, kNoFragment),
      clip_from_mesh_(program_.uniform("clip_from_mesh")) {}

void ShadowPass::drawItems(const std::vector<DrawItem>& items, const Filter& isWanted) const {
  for (const DrawItem& item : items) {
    if (!isInShadowMap(clip_from_world_, item.centre_W, item.radius) || !isWanted(item)) continue;
    setUniform(clip_from_mesh_, Eigen::Matrix4f(clip_from_world_ * item.world_from_mesh));
    item.mesh->draw(item.first, item.count);
  }
}

bool ShadowPass::areKept(const std::vector<DrawItem>& opaque) const {
  if (!is_kept_) return false;
  auto kept = kept_.begin();
  for (const DrawItem& item : opaque) {
    if (!item.is_fixed) continue;
    if (kept == kept_.end() || !isSameShape(item, *kept)) return false;
    ++kept;
  }
  return kept == kept_.end();
}

void ShadowPass::keepFixed(const std::vector<DrawItem>& opaque) {
  if (areKept(opaque)) return;
  kept_.clear();
  std::copy_if(opaque.begin(), opaque.end(), std::back_inserter(kept_), [](const DrawItem& i) { return i.is_fixed; });
  is_kept_ = true;
  fixed_.begin();
  drawItems(kept_, [](const DrawItem&) { return true; });
}

void ShadowPass::forget(const GpuMesh* mesh) noexcept {
  const bool has = std::any_of(kept_.begin(), kept_.end(), [&](const DrawItem& item) { return item.mesh == mesh; });
  if (has) is_kept_ = false;
}

void ShadowPass::draw(const std::vector<DrawItem>& opaque,
                      const Eigen::Matrix4f& shadow_clip_from_world,
                      const std::vector<model::Camera>& cameras) {
  const auto isSeen = [&](const DrawItem& item) {
    return std::any_of(cameras.begin(), cameras.end(),
                       [&](const model::Camera& c) { return isShadowInView(c, item.centre_W, item.radius); });
  };
  const bool is_still = shadow_clip_from_world == clip_from_world_;
  clip_from_world_ = shadow_clip_from_world;
  program_.use();
  glEnable(GL_POLYGON_OFFSET_FILL);
  glPolygonOffset(0.5F, 2.0F);  // against self-shadowing, together with the lift of MeshPass
  if (is_still) {
    keepFixed(opaque);
    target_.beginAs(fixed_);
    drawItems(opaque, [&](const DrawItem& item) { return !item.is_fixed && isSeen(item); });
  } else {
    is_kept_ = false;
    target_.begin();
    drawItems(opaque, isSeen);
  }
  glDisable(GL_POLYGON_OFFSET_FILL);
  glDisable(GL_SCISSOR_TEST);
}

MeshPass::MeshPass()
    : background_(kScreenVertex, kBackgroundFragment),
      program_(kMeshVertex, kMeshFragment),
      no_arrays_(makeEmptyArrays()),
      clip_from_mesh_(program_.uniform("clip_from_mesh")),
      world_from_mesh_(program_.uniform("world_from_mesh")),
      shadow_from_mesh_(program_.uniform("shadow_from_mesh")),
      shadow_lift_(program_.uniform("shadow_lift")),
      colour_(program_.uniform("colour")),
      eye_W_(program_.uniform("eye_W")) {
  background_.use();
  glUniform3fv(background_.uniform("top"), 1, kBackgroundTop);
  glUniform3fv(background_.uniform("bottom"), 1, kBackgroundBottom);
  program_.use();
  setUniform(program_.uniform("key_W"), keyLight());
  setUniform(program_.uniform("fill_W"), fillLight());
  glUniform1i(program_.uniform("shadow_map"), 0);
}

void MeshPass::shine(const model::Camera& camera, const Light& light) {
  shadow_from_world_ = textureFromClip() * light.shadow_clip_from_world;
  glBindTexture(GL_TEXTURE_2D, light.shadow_map.texture());
  program_.use();
  setUniform(eye_W_, Eigen::Vector3f(camera.X_WC.p.cast<float>()));
  shadow_lift_W_ = kLift * texelOf(light.shadow_map) / light.shadow_clip_from_world.block<1, 3>(0, 0).norm();
}

void MeshPass::draw(const DrawLists& lists, const model::Camera& camera, const Light& light) {
  shine(camera, light);
  glClear(GL_DEPTH_BUFFER_BIT);
  drawItems(lists.opaque, camera, isMoving);  // first: it is near, mostly, and what it hides costs no shading
  glDepthFunc(GL_LESS);
  drawItems(lists.opaque, camera, isFixed);
  glDepthFunc(GL_LEQUAL);
  drawBackground();  // at the far plane: only where nothing is
  drawRest(lists, camera);
}

void MeshPass::keep(FixedLayer* layer, const DrawLists& lists, const model::Camera& camera, const Light& light) {
  layer->keep(
      [&] {
        shine(camera, light);
        glDepthFunc(GL_LESS);
        drawItems(lists.opaque, camera, isFixed);
        glDepthFunc(GL_LEQUAL);
        drawBackground();
      },
      light.shadow_map, kMargin * texelOf(light.shadow_map));
}

void MeshPass::drawOver(FixedLayer* layer,
                        const PictureTarget& picture,
                        const DrawLists& lists,
                        const model::Camera& camera,
                        const Light& light) {
  const bool is_shaded = layer->copyTo(picture, light.shadow_map);
  shine(camera, light);
  glEnable(GL_STENCIL_TEST);
  glStencilFunc(GL_ALWAYS, 0, 0xFF);
  glStencilOp(GL_KEEP, GL_KEEP, GL_ZERO);  // what moves hides the layer
  drawItems(lists.opaque, camera, isMoving);
  glStencilFunc(GL_EQUAL, 1, 0xFF);  // the first as deep as the layer is the one that the layer has
  const PixelRun& touched = layer->touched();
  if (is_shaded) glScissor(touched.left, touched.bottom, touched.right - touched.left, touched.top - touched.bottom);
  glEnable(GL_SCISSOR_TEST);  // the stencil would do, but it is looked at pixel by pixel
  if (is_shaded) drawItems(lists.opaque, camera, isFixed);
  glDisable(GL_SCISSOR_TEST);
  glDisable(GL_STENCIL_TEST);
  drawRest(lists, camera);
}

void MeshPass::drawRest(const DrawLists& lists, const model::Camera& camera) const {
  program_.use();
  drawMarks(lists.marks, camera);
  drawTranslucent(lists.translucent, camera);
}

void MeshPass::drawBackground() const {
  background_.use();
  glBindVertexArray(no_arrays_);
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

void MeshPass::drawItems(const std::vector<DrawItem>& items, const model::Camera& camera, Filter isWanted) const {
  const Eigen::Matrix4f clip_from_world = clipFromWorld(camera);
  for (const DrawItem& item : items) {
    if (isWanted != nullptr && !isWanted(item)) continue;
    if (!isInView(camera, item.centre_W, item.radius)) continue;
    setUniform(clip_from_mesh_, Eigen::Matrix4f(clip_from_world * item.world_from_mesh));
    setUniform(world_from_mesh_, item.world_from_mesh);
    setUniform(shadow_from_mesh_, Eigen::Matrix4f(shadow_from_world_ * item.world_from_mesh));
    glUniform1f(shadow_lift_, shadow_lift_W_ / item.scale);
    setUniform(colour_, item.colour);
    item.mesh->draw(item.first, item.count);
  }
}

void MeshPass::drawMarks(const std::vector<DrawItem>& items, const model::Camera& camera) const {
  if (items.empty()) return;
  // First what things hide, faintly; before the marks themselves have a depth that could hide it.
  glDepthFunc(GL_GREATER);
  glDepthMask(GL_FALSE);
  glEnable(GL_BLEND);
  glBlendColor(0.0F, 0.0F, 0.0F, kHiddenMark);
  glBlendFunc(GL_CONSTANT_ALPHA, GL_ONE_MINUS_CONSTANT_ALPHA);
  drawItems(items, camera);
  glDisable(GL_BLEND);
  glDepthMask(GL_TRUE);
  glDepthFunc(GL_LEQUAL);
  drawItems(items, camera);
}

void MeshPass::drawTranslucent(const std::vector<DrawItem>& items, const model::Camera& camera) const {
  if (items.empty()) return;
  // Pushed back a little, so that where a ghost coincides with its arm the arm wins cleanly.
  glEnable(GL_POLYGON_OFFSET_FILL);
  glPolygonOffset(1.0F, 16.0F);
  // Depth first, then colour: only the nearest surface shows, in whatever order the items come.
  glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
  drawItems(items, camera);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  glEnable(GL_BLEND);
  glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
  drawItems(items, camera);
  glDisable(GL_BLEND);
  glDisable(GL_POLYGON_OFFSET_FILL);
}

PartPass::PartPass()
    : program_(kShadowVertex, kPartFragment),
      clip_from_mesh_(program_.uniform("clip_from_mesh")),
      colour_(program_.uniform("colour")) {}

void PartPass::draw(const DrawLists& lists, const model::Camera& camera) const {
  program_.use();
  glClearColor(0.0F, 0.0F, 0.0F, 0.0F);
  glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  const Eigen::Matrix4f clip_from_world = clipFromWorld(camera);
  for (const auto* items : {&lists.opaque, &lists.translucent}) {
    for (const DrawItem& item : *items) {
      if (item.part == 0 || !isInView(camera, item.centre_W, item.radius)) continue;
      setUniform(clip_from_mesh_, Eigen::Matrix4f(clip_from_world * item.world_from_mesh));
      const auto low = static_cast<float>(item.part % 256U), high = static_cast<float>(item.part / 256U);
      setUniform(colour_, Eigen::Vector4f(low / 255.0F, high / 255.0F, 0.0F, 1.0F));
      item.mesh->draw(item.first, item.count);
    }
  }
}

}  // namespace raven2_trainer::render
