// The operators `new` and `delete` of the Python module: from the current arena, if there is one.

#include <cstdlib>
#include <new>

#include "python/arena.h"

using raven2_trainer::python::Arena;

namespace {

constexpr std::size_t kUsual = __STDCPP_DEFAULT_NEW_ALIGNMENT__;

void* allocate(std::size_t size, std::size_t alignment) {
  if (Arena* const arena = Arena::current()) {
    if (void* const place = arena->allocate(size, alignment)) return place;
    throw std::bad_alloc();
  }
  void* place = nullptr;
  if (alignment <= kUsual) {
    place = std::malloc(size == 0 ? 1 : size);
  } else if (posix_memalign(&place, alignment, size == 0 ? alignment : size) != 0) {
    place = nullptr;
  }
  if (place == nullptr) throw std::bad_alloc();
  return place;
}

void release(void* place) noexcept {
  if (place != nullptr && !Arena::release(place)) std::free(place);
}

}  // namespace

void* operator new(std::size_t size) {
  return allocate(size, kUsual);
}
void* operator new[](std::size_t size) {
  return allocate(size, kUsual);
}
void* operator new(std::size_t size, std::align_val_t alignment) {
  return allocate(size, static_cast<std::size_t>(alignment));
}
void* operator new[](std::size_t size, std::align_val_t alignment) {
  return allocate(size, static_cast<std::size_t>(alignment));
}
void operator delete(void* place) noexcept {
  release(place);
}
void operator delete[](void* place) noexcept {
  release(place);
}
void operator delete(void* place, std::size_t) noexcept {
  release(place);
}
void operator delete[](void* place, std::size_t) noexcept {
  release(place);
}
void operator delete(void* place, std::align_val_t) noexcept {
  release(place);
}
void operator delete[](void* place, std::align_val_t) noexcept {
  release(place);
}
void operator delete(void* place, std::size_t, std::align_val_t) noexcept {
  release(place);
}
void operator delete[](void* place, std::size_t, std::align_val_t) noexcept {
  release(place);
}
