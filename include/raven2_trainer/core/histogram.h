#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <type_traits>

namespace raven2_trainer {

/**
 * Counts durations in fixed buckets: 8 per octave (each at most 12.5 % wide) from 256 ns to 268 ms, one below and one
 * above. A plain struct, for threads and the log. Real-time safe.
 */
class Histogram {
 public:
  static constexpr int kFirstOctave = 8;  ///< 2^8 ns = 256 ns
  static constexpr int kOctaves = 20;     ///< up to 2^28 ns = 268 ms
  static constexpr int kParts = 8;        ///< buckets per octave, linear within it
  static constexpr std::size_t kBuckets = 2 + kOctaves * kParts;

  /** Counts one duration [ns]; negative ones count as the shortest. */
  void add(std::int64_t ns) noexcept { ++counts[bucketOf(ns)]; }

  std::uint64_t total() const noexcept {
    std::uint64_t sum = 0;
    for (const std::uint32_t n : counts)
      sum += n;
    return sum;
  }

  /**
   * @param[in] p in [0, 1].
   * @return [ns] upper edge of the bucket with the p-quantile: at most 12.5 % too large, but at least 256. 0 if
   * nothing was counted; 268 ms for longer durations.
   */
  std::int64_t quantile(double p) const noexcept {
    const auto rank = static_cast<std::uint64_t>(std::ceil(p * static_cast<double>(total())));
    std::uint64_t sum = 0;
    for (std::size_t i = 0; i < kBuckets; ++i) {
      sum += counts[i];
      if (sum > 0 && sum >= rank) return upperEdge(i);
    }
    return 0;
  }

  /** [ns] Upper edge of bucket `i`; of the last bucket the lower edge. */
  static constexpr std::int64_t upperEdge(std::size_t i) noexcept {
    const std::size_t step = i < kBuckets - 1 ? i : i - 1;
    const std::int64_t octave = std::int64_t{1} << (static_cast<int>(step / kParts) + kFirstOctave);
    return octave + octave / kParts * static_cast<std::int64_t>(step % kParts);
  }

  static constexpr std::size_t bucketOf(std::int64_t ns) noexcept {
    if (ns < (std::int64_t{1} << kFirstOctave)) return 0;
    if (ns >= (std::int64_t{1} << (kFirstOctave + kOctaves))) return kBuckets - 1;
    int octave = kFirstOctave;
    while ((ns >> (octave + 1)) != 0)
      ++octave;
    const std::int64_t part = (ns >> (octave - 3)) & (kParts - 1);  // the three bits below the highest set bit
    return 1 + static_cast<std::size_t>((octave - kFirstOctave) * kParts + part);
  }

  std::array<std::uint32_t, kBuckets> counts{};
};
static_assert(std::is_trivially_copyable<Histogram>::value, "crosses threads word by word");

}  // namespace raven2_trainer
