#pragma once

#include <Eigen/Core>

#include "render/gl.h"

namespace raven2_trainer::render {

/** A linked pair of shaders. The context must be current on every call. */
class ShaderProgram {
 public:
  /** @throw RenderException with the compiler's log. */
  ShaderProgram(const char* vertex_source, const char* fragment_source);
  ~ShaderProgram();
  ShaderProgram(const ShaderProgram&) = delete;
  ShaderProgram& operator=(const ShaderProgram&) = delete;

  void use() const noexcept { glUseProgram(program_); }

  /** Location of a uniform. @throw RenderException if the program has no uniform of that name. */
  GLint uniform(const char* name) const;

 private:
  GLuint program_{0};
};

void setUniform(GLint location, const Eigen::Matrix4f& m) noexcept;
void setUniform(GLint location, const Eigen::Vector3f& v) noexcept;
void setUniform(GLint location, const Eigen::Vector4f& v) noexcept;

}  // namespace raven2_trainer::render
