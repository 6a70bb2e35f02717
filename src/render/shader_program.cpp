#include "render/shader_program.h"

#include <array>
#include <string>

#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::render {

namespace {

GLuint compile(GLenum kind, const char* source) {
  const GLuint shader = glCreateShader(kind);
  glShaderSource(shader, 1, &source, nullptr);
  glCompileShader(shader);
  GLint ok = GL_FALSE;
  glGetShaderiv(shader, GL_COMPILE_STATUS, &ok);
  if (ok == GL_TRUE) return shader;
  std::array<char, 1024> log{};
  glGetShaderInfoLog(shader, static_cast<GLsizei>(log.size()), nullptr, log.data());
  glDeleteShader(shader);
  throw RenderException(std::string("glCompileShader: ") + log.data());
}

GLuint link(GLuint vertex, GLuint fragment) {
  const GLuint program = glCreateProgram();
  glAttachShader(program, vertex);
  glAttachShader(program, fragment);
  glLinkProgram(program);
  glDeleteShader(vertex);
  glDeleteShader(fragment);
  GLint ok = GL_FALSE;
  glGetProgramiv(program, GL_LINK_STATUS, &ok);
  if (ok == GL_TRUE) return program;
  std::array<char, 1024> log{};
  glGetProgramInfoLog(program, static_cast<GLsizei>(log.size()), nullptr, log.data());
  glDeleteProgram(program);
  throw RenderException(std::string("glLinkProgram: ") + log.data());
}

}  // namespace

ShaderProgram::ShaderProgram(const char* vertex_source, const char* fragment_source) {
  const GLuint vertex = compile(GL_VERTEX_SHADER, vertex_source);
  program_ = link(vertex, compile(GL_FRAGMENT_SHADER, fragment_source));
}

ShaderProgram::~ShaderProgram() {
  glDeleteProgram(program_);
}

GLint ShaderProgram::uniform(const char* name) const {
  const GLint location = glGetUniformLocation(program_, name);
  if (location < 0) throw RenderException(std::string("glGetUniformLocation: no uniform ") + name);
  return location;
}

void setUniform(GLint location, const Eigen::Matrix4f& m) noexcept {
  glUniformMatrix4fv(location, 1, GL_FALSE, m.data());
}

void setUniform(GLint location, const Eigen::Vector3f& v) noexcept {
  glUniform3fv(location, 1, v.data());
}

void setUniform(GLint location, const Eigen::Vector4f& v) noexcept {
  glUniform4fv(location, 1, v.data());
}

}  // namespace raven2_trainer::render
