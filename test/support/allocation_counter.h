#pragma once

#include <dlfcn.h>
#include <pthread.h>

#include <cerrno>
#include <cstddef>
#include <cstdlib>

#include "support/sanitizer.h"

// Counts the calls of the allocator, and the locks of mutexes. It replaces the allocator of the whole program, so that
// libode's and libstdc++'s calls are counted too; neither -Wl,--wrap nor dSetAllocHandler sees them (measured). The
// definitions are weak because several sources of a program may include them; they still come before libc's. Sanitizers
// bring their own allocator: nothing is defined under them.

#ifndef RAVEN2_HAS_SANITIZER
#define RAVEN2_COUNTS_ALLOCATIONS

namespace raven2_trainer::testing {
inline thread_local bool counting = false;
inline thread_local int calls = 0;
inline thread_local int locks = 0;

inline void count() {
  if (counting) ++calls;
}
}  // namespace raven2_trainer::testing

#define RAVEN2_WEAK __attribute__((weak))

extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);
void __libc_free(void*);

RAVEN2_WEAK void* malloc(std::size_t size) {
  raven2_trainer::testing::count();
  return __libc_malloc(size);
}
RAVEN2_WEAK void* calloc(std::size_t number, std::size_t size) {
  raven2_trainer::testing::count();
  return __libc_calloc(number, size);
}
RAVEN2_WEAK void* realloc(void* memory, std::size_t size) {
  raven2_trainer::testing::count();
  return __libc_realloc(memory, size);
}
RAVEN2_WEAK void* memalign(std::size_t alignment, std::size_t size) {
  raven2_trainer::testing::count();
  return __libc_memalign(alignment, size);
}
RAVEN2_WEAK void* aligned_alloc(std::size_t alignment, std::size_t size) {
  raven2_trainer::testing::count();
  return __libc_memalign(alignment, size);
}
// For libode's, libstdc++'s and our locks: an uncontended lock makes no system call, so only this counts it.
RAVEN2_WEAK int pthread_mutex_lock(pthread_mutex_t* mutex) noexcept {
  using Function = int (*)(pthread_mutex_t*);
  static const auto real = reinterpret_cast<Function>(dlsym(RTLD_NEXT, "pthread_mutex_lock"));
  if (raven2_trainer::testing::counting) ++raven2_trainer::testing::locks;
  return real(mutex);
}
RAVEN2_WEAK int pthread_mutex_trylock(pthread_mutex_t* mutex) noexcept {
  using Function = int (*)(pthread_mutex_t*);
  static const auto real = reinterpret_cast<Function>(dlsym(RTLD_NEXT, "pthread_mutex_trylock"));
  if (raven2_trainer::testing::counting) ++raven2_trainer::testing::locks;
  return real(mutex);
}
RAVEN2_WEAK int posix_memalign(void** memory, std::size_t alignment, std::size_t size) noexcept {
  raven2_trainer::testing::count();
  *memory = __libc_memalign(alignment, size);
  return *memory == nullptr ? ENOMEM : 0;
}
RAVEN2_WEAK void free(void* memory) {
  raven2_trainer::testing::count();
  __libc_free(memory);
}
}

#undef RAVEN2_WEAK

namespace raven2_trainer::testing {

/** Mutexes locked on this thread in the last allocatorCalls(). */
inline int mutexLocks() {
  return locks;
}

/** Calls of the allocator on this thread while `body` runs. */
template <typename Body>
int allocatorCalls(const Body& body) {
  calls = 0;
  locks = 0;
  counting = true;
  body();
  counting = false;
  return calls;
}

}  // namespace raven2_trainer::testing

#endif
