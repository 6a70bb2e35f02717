#include "render/picture_target.h"

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <string>

#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::render {

namespace {

constexpr GLenum kPackInvert = 0x8758;  // GL_PACK_INVERT_MESA: llvmpipe turns rows round while it copies them

bool hasExtension(const char* name) {
  GLint count = 0;
  glGetIntegerv(GL_NUM_EXTENSIONS, &count);
  for (GLuint i = 0; i < static_cast<GLuint>(count); ++i)
    if (std::strcmp(reinterpret_cast<const char*>(glGetStringi(GL_EXTENSIONS, i)), name) == 0) return true;
  return false;
}

/** A texture: of a renderbuffer's bytes OpenGL chooses the order, and a copy would be slow where it differs. */
GLuint attachColour(int width, int height) {
  GLuint texture = 0;
  glGenTextures(1, &texture);
  glBindTexture(GL_TEXTURE_2D, texture);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, width, height, 0, GL_RGBA, GL_UNSIGNED_BYTE, nullptr);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, texture, 0);
  return texture;
}

GLuint attachDepth(int width, int height) {
  GLuint buffer = 0;
  glGenRenderbuffers(1, &buffer);
  glBindRenderbuffer(GL_RENDERBUFFER, buffer);
  glRenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH24_STENCIL8, width, height);
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_STENCIL_ATTACHMENT, GL_RENDERBUFFER, buffer);
  return buffer;
}

}  // namespace

PictureTarget::PictureTarget(int width, int height)
    : width_(width), height_(height), can_invert_(hasExtension("GL_MESA_pack_invert")) {
  glGenFramebuffers(1, &framebuffer_);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  colour_ = attachColour(width, height);
  depth_ = attachDepth(width, height);
  const GLenum status = glCheckFramebufferStatus(GL_FRAMEBUFFER);
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
  if (status != GL_FRAMEBUFFER_COMPLETE)
    throw RenderException("glCheckFramebufferStatus of a picture: status " + std::to_string(status));
}

PictureTarget::~PictureTarget() {
  glDeleteFramebuffers(1, &framebuffer_);
  glDeleteTextures(1, &colour_);
  glDeleteRenderbuffers(1, &depth_);
}

void PictureTarget::copyTo(const PictureTarget& other) const noexcept {
  glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer_);
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, other.framebuffer_);
  glBlitFramebuffer(0, 0, width_, height_, 0, 0, width_, height_,
                    GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT | GL_STENCIL_BUFFER_BIT, GL_NEAREST);
}

template <typename Number>
void PictureTarget::readPixels(GLenum format, GLenum type, int numbers, Number* pixels) const noexcept {
  glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer_);
  if (can_invert_) glPixelStorei(kPackInvert, GL_TRUE);
  glReadPixels(0, 0, width_, height_, format, type, pixels);
  if (can_invert_) return glPixelStorei(kPackInvert, GL_FALSE);
  const auto row = static_cast<std::ptrdiff_t>(width_) * numbers;
  for (std::ptrdiff_t top = 0, bottom = height_ - 1; top < bottom; ++top, --bottom)
    std::swap_ranges(pixels + top * row, pixels + (top + 1) * row, pixels + bottom * row);
}

void PictureTarget::read(std::uint8_t* rgba) const noexcept {
  readPixels(GL_RGBA, GL_UNSIGNED_BYTE, 4, rgba);
}

void PictureTarget::readDepth(float* depth) const noexcept {
  readPixels(GL_DEPTH_COMPONENT, GL_FLOAT, 1, depth);
}

}  // namespace raven2_trainer::render
