#include "render/gl_library.h"

#include <dlfcn.h>

#include <cstdint>
#include <cstdlib>
#include <initializer_list>
#include <memory>
#include <mutex>
#include <string>

#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/render/renderer.h"
#include "render/gl.h"

namespace raven2_trainer::render {
namespace {

/** A shared library that is loaded, and stays so: drivers do not survive being taken away. */
class Shared {
 public:
  explicit Shared(std::initializer_list<const char*> files) {
    for (const char* file : files) {
      if (handle_ == nullptr) handle_ = ::dlopen(file, RTLD_NOW | RTLD_LOCAL);
    }
  }

  bool isThere() const noexcept { return handle_ != nullptr; }

  template <typename Function>
  Function* find(const char* name) const {
    return reinterpret_cast<Function*>(::dlsym(handle_, name));
  }

  /** @throw RenderException if it is not in the library. */
  template <typename Function>
  void load(const char* name, Function** function) const {
    *function = find<Function>(name);
    if (*function == nullptr) throw RenderException(std::string(name) + ": " + ::dlerror());
  }

 private:
  void* handle_{nullptr};
};

// Mesa's own headers are gone with OSMesa; its interface (GL/osmesa.h of Mesa 22.3) has not changed since 2015.
class OsMesa : public GlLibrary {
 public:
  explicit OsMesa(const Shared& library) {
    library.load("OSMesaCreateContextAttribs", &create_);
    library.load("OSMesaDestroyContext", &destroy_);
    library.load("OSMesaMakeCurrent", &make_current_);
    library.load("OSMesaGetCurrentContext", &current_);
    library.load("OSMesaGetProcAddress", &function_);
  }

  const char* name() const noexcept override { return "OSMesa"; }
  void* createContext() override {
    constexpr int kFormat = 0x22, kDepthBits = 0x30, kProfile = 0x33, kCoreProfile = 0x34, kMajor = 0x36, kMinor = 0x37;
    const int attributes[] = {kFormat, GL_RGBA, kDepthBits, 24, kProfile, kCoreProfile, kMajor, 3, kMinor, 3, 0};
    return create_(attributes, nullptr);
  }
  void destroyContext(void* context) noexcept override { destroy_(context); }
  void* current() const noexcept override { return current_(); }
  /** OSMesa wants its own picture: one pixel, which nothing is drawn into. */
  bool makeCurrent(void* context) noexcept override {
    if (context == nullptr) return make_current_(nullptr, nullptr, 0, 0, 0) != 0;
    return make_current_(context, pixel_, GL_UNSIGNED_BYTE, 1, 1) != 0;
  }
  void* function(const char* name) const noexcept override { return reinterpret_cast<void*>(function_(name)); }

 private:
  void* (*create_)(const int*, void*){};
  void (*destroy_)(void*){};
  unsigned char (*make_current_)(void*, void*, unsigned, int, int){};
  void* (*current_)(){};
  void (*(*function_)(const char*))(){};
  std::uint8_t pixel_[4]{};
};

/** EGL 1.5 on Mesa's surfaceless platform (EGL_MESA_platform_surfaceless). */
class Egl : public GlLibrary {
 public:
  explicit Egl(const Shared& library) {
    library.load("eglGetPlatformDisplay", &display_of_);
    library.load("eglInitialize", &initialize_);
    library.load("eglBindAPI", &bind_api_);
    library.load("eglChooseConfig", &choose_);
    library.load("eglCreateContext", &create_);
    library.load("eglDestroyContext", &destroy_);
    library.load("eglMakeCurrent", &make_current_);
    library.load("eglGetCurrentContext", &current_);
    library.load("eglGetProcAddress", &function_);
    library.load("eglGetError", &error_);
    // The driver is loaded with the library, so that recording::pictureIdentity() can name it. It starts no threads
    // before the first context: a program may fork until then.
    Shared({"libEGL_mesa.so.0"});
  }

  const char* name() const noexcept override { return "EGL"; }
  void* createContext() override {
    constexpr int kSurfaceType = 0x3033, kPbuffer = 1, kRenderableType = 0x3040, kOpenGl = 8, kNone = 0x3038;
    constexpr int kMajor = 0x3098, kMinor = 0x30FB, kProfile = 0x30FD, kCore = 1;
    const int wanted[] = {kSurfaceType, kPbuffer, kRenderableType, kOpenGl, kNone};
    const int attributes[] = {kMajor, 3, kMinor, 3, kProfile, kCore, kNone};
    std::call_once(initialized_, [this] { initialize(); });
    void* config = nullptr;
    int count = 0;
    if (bind_api_(kOpenGlApi) == 0 || choose_(display_, wanted, &config, 1, &count) == 0 || count == 0) return nullptr;
    return create_(display_, config, nullptr, attributes);
  }
  void destroyContext(void* context) noexcept override { destroy_(display_, context); }
  void* current() const noexcept override { return current_(); }
  bool makeCurrent(void* context) noexcept override {
    bind_api_(kOpenGlApi);  // of the thread
    return make_current_(display_, nullptr, nullptr, context) != 0;
  }
  void* function(const char* name) const noexcept override { return reinterpret_cast<void*>(function_(name)); }

 private:
  void initialize() {
    constexpr unsigned kSurfaceless = 0x31DD;
    display_ = display_of_(kSurfaceless, nullptr, nullptr);
    if (display_ == nullptr || initialize_(display_, nullptr, nullptr) == 0)
      throw RenderException("eglInitialize on the surfaceless platform: EGL error " + std::to_string(error_()));
  }

  static constexpr unsigned kOpenGlApi = 0x30A2;

  void* (*display_of_)(unsigned, void*, const std::intptr_t*){};
  unsigned (*initialize_)(void*, int*, int*){};
  unsigned (*bind_api_)(unsigned){};
  unsigned (*choose_)(void*, const int*, void**, int, int*){};
  void* (*create_)(void*, void*, void*, const int*){};
  unsigned (*destroy_)(void*, void*){};
  unsigned (*make_current_)(void*, void*, void*, void*){};
  void* (*current_)(){};
  void (*(*function_)(const char*))(){};
  int (*error_)(){};
  std::once_flag initialized_;
  void* display_{nullptr};
};

std::string wantedLibrary() {
  const char* text = std::getenv("RAVEN2_TRAINER_GL");
  const std::string wanted = text == nullptr || *text == '\0' ? "auto" : text;
  if (wanted != "auto" && wanted != "osmesa" && wanted != "egl")
    throw RenderException("RAVEN2_TRAINER_GL is \"" + wanted + "\", allowed auto, osmesa, egl");
  return wanted;
}

std::unique_ptr<GlLibrary> chooseLibrary() {
  const std::string wanted = wantedLibrary();
  if (wanted != "egl") {
    const Shared osmesa({"libOSMesa.so.8", "libOSMesa.so.6"});
    if (osmesa.isThere()) return std::make_unique<OsMesa>(osmesa);
  }
  if (wanted != "osmesa") {
    const Shared egl({"libEGL.so.1"});
    if (egl.isThere()) return std::make_unique<Egl>(egl);
  }
  throw RenderException("OpenGL (RAVEN2_TRAINER_GL " + wanted + ") needs " +
                        (wanted == "egl"      ? "libEGL.so.1: apt-get install libegl1"
                         : wanted == "osmesa" ? "libOSMesa.so.8: apt-get install libosmesa6"
                                              : "libOSMesa.so.8 or libEGL.so.1: apt-get install libosmesa6, or libegl1"));
}

void loadFunctions(const GlLibrary& library) {
#define RAVEN2_LOAD(pointer, type)                              \
  pointer = reinterpret_cast<type>(library.function(#pointer)); \
  if (pointer == nullptr) throw RenderException(std::string(library.name()) + " has no " #pointer);
  RAVEN2_GL_FUNCTIONS(RAVEN2_LOAD)
#undef RAVEN2_LOAD
}

}  // namespace

GlLibrary& glLibrary() {
  static GlLibrary* const library = [] {
    std::unique_ptr<GlLibrary> chosen = chooseLibrary();
    loadFunctions(*chosen);
    return chosen.release();  // as long as the process: contexts of other threads may outlive what main() owns
  }();
  return *library;
}

const char* loadOpenGl() {
  return glLibrary().name();
}

}  // namespace raven2_trainer::render
