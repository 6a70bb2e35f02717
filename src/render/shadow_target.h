#pragma once

#include <vector>

#include "render/gl.h"

namespace raven2_trainer::render {

/** Depth texture seen from a light. The context must be current on every call. */
class ShadowTarget {
 public:
  static constexpr int kSize = 1024;  ///< [px] of each edge: 0.3 to 1.3 mm a pixel

  /** @throw RenderException if the framebuffer is not complete. */
  ShadowTarget();
  ~ShadowTarget();
  ShadowTarget(const ShadowTarget&) = delete;
  ShadowTarget& operator=(const ShadowTarget&) = delete;

  /** Binds it, with nothing in it. Its outermost pixels stay so: what lies outside the map is lit. Leaves the scissor
   *  test on. */
  void begin() const noexcept;

  /** Binds it, with what is in another. */
  void beginAs(const ShadowTarget& other) const noexcept;

  /** Waits for what was drawn. @param[out] depth all of it, bottom row first: kSize x kSize. */
  void read(std::vector<float>* depth) const;

  GLuint texture() const noexcept { return texture_; }

 private:
  GLuint framebuffer_{0}, texture_{0};
};

}  // namespace raven2_trainer::render
