#include "render/gl_context.h"

#include <atomic>
#include <cstdlib>
#include <mutex>
#include <string>

#include "raven2_trainer/core/exceptions.h"
#include "render/gl_library.h"

namespace raven2_trainer::render {

namespace {

constexpr int kMaxSize = 4096;  // [px] of each edge, as in config/render.yaml

std::atomic<bool> g_used{false};

/** llvmpipe reads this once, before the first context: one raster thread, so that drawing never takes both cores
 *  from the 1 kHz loops. */
void limitRasterThreads() {
  static std::once_flag once;
  std::call_once(once, [] { setenv("LP_NUM_THREADS", "1", 0); });
}

/** Before the library is loaded. */
GlLibrary& libraryFor(int width, int height) {
  if (width < 1 || height < 1 || width > kMaxSize || height > kMaxSize) {
    throw RenderException("picture size " + std::to_string(width) + "x" + std::to_string(height) +
                          ", allowed 1x1 to 4096x4096");
  }
  limitRasterThreads();
  g_used.store(true);
  return glLibrary();
}

}  // namespace

GlContext::GlContext(int width, int height) : width_(width), height_(height), library_(libraryFor(width, height)) {
  context_ = library_.createContext();
  if (context_ == nullptr) throw RenderException(std::string(library_.name()) + ": no OpenGL 3.3 core context");
  try {
    makeCurrent();
  } catch (...) {
    library_.destroyContext(context_);
    throw;
  }
}

GlContext::~GlContext() {
  if (library_.current() == context_) library_.makeCurrent(nullptr);
  library_.destroyContext(context_);
}

bool GlContext::isUsed() noexcept {
  return g_used.load();
}

void GlContext::makeCurrent() {
  if (library_.current() == context_ || library_.makeCurrent(context_)) return;
  throw RenderException(std::string(library_.name()) + ": the context cannot be made current");
}

}  // namespace raven2_trainer::render
