#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

// What those who master an exercise reach in it (config/bands/EXERCISE.yaml, written by scripts/make_expert_band).

namespace raven2_trainer {

enum class Better : std::uint8_t { kLower, kHigher };
constexpr std::array<const char*, 2> kBetterNames{"lower", "higher"};

/** One metric of a band, in the unit of score.json. */
struct BandMetric {
  std::string name;
  double mean{};
  double deviation{};  ///< sample deviation
  Better better{Better::kLower};
  double least{};  ///< spread that is granted in any case; a count that is always 0 may be so large
};

struct Band {
  std::string exercise;     ///< the file's name
  std::string origin;       ///< whose band it is, in words
  std::int64_t sessions{};  ///< that it was made from
  double least_spread{};    ///< [-] of the mean, granted in any case
  std::vector<BandMetric> metrics;
};

}  // namespace raven2_trainer
