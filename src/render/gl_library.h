#pragma once

namespace raven2_trainer::render {

/** OpenGL without a screen: OSMesa's or EGL's. The caller makes the framebuffers; contexts have no own ones. */
class GlLibrary {
 public:
  GlLibrary() = default;
  virtual ~GlLibrary() = default;
  GlLibrary(const GlLibrary&) = delete;
  GlLibrary& operator=(const GlLibrary&) = delete;

  virtual const char* name() const noexcept = 0;
  /** OpenGL 3.3 core. @return nullptr on failure. */
  virtual void* createContext() = 0;
  virtual void destroyContext(void* context) noexcept = 0;
  /** Of the calling thread; nullptr: none. */
  virtual void* current() const noexcept = 0;
  /** Binds a context to the calling thread, or none. @return whether it could. */
  virtual bool makeCurrent(void* context) noexcept = 0;
  /** @return nullptr for a function that it does not have. */
  virtual void* function(const char* name) const noexcept = 0;
};

/**
 * The process's own, loaded with the first call, with the functions of gl.h: OSMesa where it is installed, else EGL on
 * Mesa's surfaceless platform, which draws on a GPU where there is one. The environment variable RAVEN2_TRAINER_GL
 * chooses: auto, osmesa or egl.
 * @throw RenderException naming what is missing, or a bad value of the variable.
 */
GlLibrary& glLibrary();

}  // namespace raven2_trainer::render
