#pragma once

// RAVEN2_HAS_SANITIZER: AddressSanitizer or ThreadSanitizer, which bring their own allocator, signals and system calls.

#if defined(__has_feature)  // clang's way to tell
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define RAVEN2_HAS_SANITIZER
#endif
#endif
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)  // gcc's
#define RAVEN2_HAS_SANITIZER
#endif
