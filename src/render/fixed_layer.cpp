#include "render/fixed_layer.h"

#include <algorithm>
#include <iterator>

#include "render/passes.h"
#include "render/projection.h"
#include "render/shaders.h"

namespace raven2_trainer::render {

namespace {

bool isSame(const model::Camera& a, const model::Camera& b) noexcept {
  return a.X_WC.p == b.X_WC.p && a.X_WC.R == b.X_WC.R && a.width == b.width && a.height == b.height && a.fx == b.fx &&
         a.fy == b.fy && a.cx == b.cx && a.cy == b.cy;
}

}  // namespace

bool isSameLook(const DrawItem& a, const DrawItem& b) noexcept {
  return a.mesh == b.mesh && a.first == b.first && a.count == b.count && a.world_from_mesh == b.world_from_mesh &&
         a.colour == b.colour;
}

FixedLayer::FixedLayer(int width, int height)
    : width_(width),
      height_(height),
      target_(width, height),
      tiles_(ShadowTarget::sizeFor(height)),
      marker_(kTileVertex, kNoFragment) {
  glGenVertexArrays(1, &arrays_);
  glBindVertexArray(arrays_);
  glGenBuffers(1, &corners_);
  glBindBuffer(GL_ARRAY_BUFFER, corners_);
  glVertexAttribPointer(0, 2, GL_FLOAT, GL_FALSE, sizeof(Eigen::Vector2f), nullptr);
  glEnableVertexAttribArray(0);
}

FixedLayer::~FixedLayer() {
  glDeleteBuffers(1, &corners_);
  glDeleteVertexArrays(1, &arrays_);
}

void FixedLayer::look(const std::vector<DrawItem>& opaque,
                      const model::Camera& camera,
                      const Eigen::Matrix4f& shadow_clip_from_world) {
  bool is_same = isSame(camera, camera_) && shadow_clip_from_world == shadow_clip_from_world_;
  std::size_t count = 0;
  for (const DrawItem& item : opaque) {
    if (!item.is_fixed) continue;
    is_same = is_same && count < items_.size() && isSameLook(item, items_[count]);
    ++count;
  }
  is_seen_again_ = is_same && count == items_.size();
  if (is_seen_again_) return;
  is_kept_ = false;
  camera_ = camera;
  shadow_clip_from_world_ = shadow_clip_from_world;
  items_.clear();
  std::copy_if(opaque.begin(), opaque.end(), std::back_inserter(items_), [](const DrawItem& i) { return i.is_fixed; });
}

void FixedLayer::keep(const std::function<void()>& draw, const ShadowTarget& fixed_map, float margin) {
  target_.bind();
  glClear(GL_DEPTH_BUFFER_BIT | GL_STENCIL_BUFFER_BIT);
  draw();
  depth_.resize(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_));
  glReadPixels(0, 0, width_, height_, GL_DEPTH_COMPONENT, GL_FLOAT, depth_.data());
  fixed_map.read(&shadow_);
  tiles_.setPicture(width_, height_, depth_, clipFromWorld(camera_), shadow_clip_from_world_, margin, shadow_);
  is_kept_ = true;
}

bool FixedLayer::copyTo(const PictureTarget& picture, const ShadowTarget& map) {
  map.read(&shadow_);
  target_.copyTo(picture);
  return mark(tiles_.touched(shadow_));
}

/** Where the stencil becomes 1. @return whether it does. */
bool FixedLayer::mark(const std::vector<PixelRun>& runs) {
  const auto corner = [this](int x, int y) {
    return Eigen::Vector2f(2.0F * static_cast<float>(x) / static_cast<float>(width_) - 1.0F,
                           2.0F * static_cast<float>(y) / static_cast<float>(height_) - 1.0F);
  };
  triangles_.clear();
  touched_ = {width_, 0, height_, 0};
  for (const PixelRun& run : runs) {
    touched_ = {std::min(touched_.left, run.left), std::max(touched_.right, run.right),
                std::min(touched_.bottom, run.bottom), std::max(touched_.top, run.top)};
    const Eigen::Vector2f a = corner(run.left, run.bottom), b = corner(run.right, run.bottom);
    const Eigen::Vector2f c = corner(run.right, run.top), d = corner(run.left, run.top);
    triangles_.insert(triangles_.end(), {a, b, c, a, c, d});
  }
  if (triangles_.empty()) return false;
  marker_.use();
  glBindVertexArray(arrays_);
  glBindBuffer(GL_ARRAY_BUFFER, corners_);
  glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(triangles_.size() * sizeof(Eigen::Vector2f)), triangles_.data(),
               GL_STREAM_DRAW);
  glEnable(GL_STENCIL_TEST);
  glStencilFunc(GL_ALWAYS, 1, 0xFF);
  glStencilOp(GL_KEEP, GL_REPLACE, GL_REPLACE);
  glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
  glDepthMask(GL_FALSE);
  glDepthFunc(GL_ALWAYS);
  glDrawArrays(GL_TRIANGLES, 0, static_cast<GLsizei>(triangles_.size()));
  glDepthFunc(GL_LEQUAL);
  glDepthMask(GL_TRUE);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  glDisable(GL_STENCIL_TEST);
  return true;
}

void FixedLayer::forget(const GpuMesh* mesh) noexcept {
  const bool has = std::any_of(items_.begin(), items_.end(), [&](const DrawItem& item) { return item.mesh == mesh; });
  if (!has) return;
  is_kept_ = false;
  items_.clear();
  camera_.width = 0;  // no picture's: what comes next is new
}

}  // namespace raven2_trainer::render
