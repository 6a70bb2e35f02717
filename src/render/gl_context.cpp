#include "render/gl_context.h"

#include <atomic>
#include <cstdlib>
#include <mutex>
#include <string>

#include "raven2_trainer/core/exceptions.h"

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

OSMesaContext createContext() {
  const int attributes[] = {OSMESA_FORMAT,
                            OSMESA_RGBA,
                            OSMESA_DEPTH_BITS,
                            24,
                            OSMESA_PROFILE,
                            OSMESA_CORE_PROFILE,
                            OSMESA_CONTEXT_MAJOR_VERSION,
                            3,
                            OSMESA_CONTEXT_MINOR_VERSION,
                            3,
                            0};
  return OSMesaCreateContextAttribs(attributes, nullptr);
}

}  // namespace

GlContext::GlContext(int width, int height) : width_(width), height_(height) {
  if (width < 1 || height < 1 || width > kMaxSize || height > kMaxSize) {
    throw RenderException("picture size " + std::to_string(width) + "x" + std::to_string(height) +
                          ", allowed 1x1 to 4096x4096");
  }
  rgba_.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 4);
  limitRasterThreads();
  g_used.store(true);
  context_ = createContext();
  if (context_ == nullptr) throw RenderException("OSMesaCreateContextAttribs: no OpenGL 3.3 core context");
  try {
    makeCurrent();
  } catch (...) {
    OSMesaDestroyContext(context_);
    throw;
  }
}

GlContext::~GlContext() {
  if (OSMesaGetCurrentContext() == context_) OSMesaMakeCurrent(nullptr, nullptr, 0, 0, 0);
  OSMesaDestroyContext(context_);
}

bool GlContext::isUsed() noexcept {
  return g_used.load();
}

void GlContext::makeCurrent() {
  if (OSMesaGetCurrentContext() == context_) return;
  if (OSMesaMakeCurrent(context_, rgba_.data(), GL_UNSIGNED_BYTE, width_, height_) != GL_TRUE) {
    throw RenderException("OSMesaMakeCurrent failed for " + std::to_string(width_) + "x" + std::to_string(height_));
  }
  OSMesaPixelStore(OSMESA_Y_UP, 0);
}

}  // namespace raven2_trainer::render
