#pragma once

// RAVEN2_HAS_SANITIZER: AddressSanitizer or ThreadSanitizer, which bring their own allocator, signals and system calls.

#if defined(__has_feature)  // clang
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define RAVEN2_HAS_SANITIZER
#endif
#endif
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)  // gcc
#define RAVEN2_HAS_SANITIZER
#endif

namespace raven2_trainer::testing {

/** Under a sanitizer memory and times mean little, and long simulations take 30 to 60 times as long: tests may shorten
 *  them. */
constexpr bool kIsSanitized =
#ifdef RAVEN2_HAS_SANITIZER
    true;
#else
    false;
#endif

}  // namespace raven2_trainer::testing
