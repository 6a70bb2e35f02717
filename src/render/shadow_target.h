#pragma once

#include <vector>

#include "render/gl.h"

namespace raven2_trainer::render {

/** Depth texture seen from a light. The context must be current on every call. */
class ShadowTarget {
 public:
  /** [px] Of each edge for a picture so high: 0.3 to 1.3 mm a pixel, twice that for a picture of fewer than 270 rows,
   * whose own pixels are as coarse. Half the size costs a quarter. */
  static constexpr int sizeFor(int picture_height) noexcept { return picture_height < 270 ? 512 : 1024; }

  /** @param[in] size [px] of each edge. @throw RenderException if the framebuffer is not complete. */
  explicit ShadowTarget(int size);
  ~ShadowTarget();
  ShadowTarget(const ShadowTarget&) = delete;
  ShadowTarget& operator=(const ShadowTarget&) = delete;

  /** Binds it, with nothing in it. Its outermost pixels stay so: what lies outside the map is lit. Leaves the scissor
   *  test on. */
  void begin() const noexcept;

  /** Binds it, with what is in another. */
  void beginAs(const ShadowTarget& other) const noexcept;

  /** Waits for what was drawn. @param[out] depth all of it, bottom row first: size() x size(). */
  void read(std::vector<float>* depth) const;

  GLuint texture() const noexcept { return texture_; }
  int size() const noexcept { return size_; }

 private:
  const int size_;
  GLuint framebuffer_{0}, texture_{0};
};

}  // namespace raven2_trainer::render
