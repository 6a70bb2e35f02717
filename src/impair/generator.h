#pragma once

#include <cstdint>

#include "raven2_trainer/core/random.h"

namespace raven2_trainer::impair {

/** One of many independent generators of a seed. PCG's own streams of one seed are affine images of each other, so the
 *  seed is mixed too (SplitMix64, Steele, Lea, Flood 2014). */
inline Random generator(std::uint64_t seed, std::uint64_t stream) noexcept {
  std::uint64_t z = seed + (stream + 1) * 0x9E3779B97F4A7C15ULL;
  z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9ULL;
  z = (z ^ (z >> 27U)) * 0x94D049BB133111EBULL;
  return Random(z ^ (z >> 31U), stream);
}

}  // namespace raven2_trainer::impair
