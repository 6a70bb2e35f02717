#pragma once

#include "render/gl.h"

namespace raven2_trainer::render {

class GlLibrary;

/** An OpenGL context, core profile 3.3, for pictures of a size. PictureTarget has the framebuffer. */
class GlContext {
 public:
  /** @throw RenderException if the size is not in 1..4096 or no context can be had. */
  GlContext(int width, int height);
  ~GlContext();
  GlContext(const GlContext&) = delete;
  GlContext& operator=(const GlContext&) = delete;

  /** True once a context was made in this process: it must not fork drawing processes then. */
  static bool isUsed() noexcept;

  /** Binds it to the calling thread; cheap if it is bound already. */
  void makeCurrent();

  int width() const noexcept { return width_; }
  int height() const noexcept { return height_; }

 private:
  int width_, height_;
  GlLibrary& library_;
  void* context_{nullptr};
};

}  // namespace raven2_trainer::render
