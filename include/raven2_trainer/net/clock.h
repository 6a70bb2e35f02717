#pragma once

#include <cstdint>

namespace raven2_trainer::net {

/** [ns] CLOCK_MONOTONIC: never steps, never compared between machines. Real-time safe (vDSO). */
std::int64_t monotonicNow() noexcept;

}  // namespace raven2_trainer::net
