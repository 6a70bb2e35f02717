#pragma once

#include <optional>

#include "raven2_trainer/core/band.h"

namespace raven2_trainer::training {

/** How a value lies to a band. */
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

/** The same by an absolute limit: no spread is granted, the excess is in shares of the limit. */
BandJudgement judgeByLimit(double value, double limit, Better better);

/** The metric of that name; nullptr if it is not in the band. */
const BandMetric* find(const Band& band, const std::string& metric);

}  // namespace raven2_trainer::training
