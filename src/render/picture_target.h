#pragma once

#include <cstdint>

#include "render/gl.h"

namespace raven2_trainer::render {

/** A framebuffer with colours, depth and stencil, all of one format: copied from one to another as they are. The
 * context must be current on every call. */
class PictureTarget {
 public:
  /** @throw RenderException if OpenGL cannot make one of this size. */
  PictureTarget(int width, int height);
  ~PictureTarget();
  PictureTarget(const PictureTarget&) = delete;
  PictureTarget& operator=(const PictureTarget&) = delete;

  void bind() const noexcept { glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_); }
  /** Copies all of it into another one of the same size; draws there from then on. */
  void copyTo(const PictureTarget& other) const noexcept;
  /** Waits for what was drawn. @param[out] rgba 4 bytes a pixel, top row first. */
  void read(std::uint8_t* rgba) const noexcept;
  /** The same of the depth, 0 near to 1 far. @param[out] depth a number a pixel. */
  void readDepth(float* depth) const noexcept;

 private:
  template <typename Number>
  void readPixels(GLenum format, GLenum type, int numbers, Number* pixels) const noexcept;

  int width_, height_;
  bool can_invert_;
  GLuint framebuffer_{0}, colour_{0}, depth_{0};
};

}  // namespace raven2_trainer::render
