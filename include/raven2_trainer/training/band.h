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
  double least{};  ///< smallest spread; lets a count whose mean is 0 vary by this much
};

struct Band {
  std::string exercise;     ///< the file's name
  std::string origin;       ///< whose band it is, in words
  std::int64_t sessions{};  ///< that it was made from
  double least_spread{};    ///< [-] of the mean, granted in any case
  std::vector<BandMetric> metrics;
};

}  // namespace raven2_trainer

namespace raven2_trainer::training {

/** A value compared with a band. */
struct BandJudgement {
  double limit{};   ///< worst value that passes
  double spread{};  ///< that was granted: the greatest of deviation, least, and least_spread of the mean (not of ldlj)
  bool passed{};
  /** [spreads] from the limit to the value, towards worse; negative within; +-1e9 where there is no spread. */
  double excess{};
};

/**
 * Whether a value is at most `deviations` spreads worse than the mean. Where mean and deviation are 0 the limit is
 * `least` itself, however many deviations are granted. A value that is not finite does not pass.
 */
BandJudgement judge(double value, const BandMetric& metric, double least_spread, double deviations);

/** Judges by an absolute limit: no spread is granted, the excess is in shares of the limit. */
BandJudgement judgeByLimit(double value, double limit, Better better);

/** The metric of that name; nullptr if it is not in the band. */
const BandMetric* find(const Band& band, const std::string& metric);

}  // namespace raven2_trainer::training
