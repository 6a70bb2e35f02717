#include "apps/common/study_bar.h"

#include <algorithm>

namespace raven2_trainer::apps {

namespace {

constexpr double kEstimateAfter = 2.0;  // [s]
constexpr double kLongest = 1e9;        // [s]; avoids an overflow

}  // namespace

std::string timeLeft(double spent, double done, double left) {
  if (!(spent > kEstimateAfter) || !(done > 0.0) || !(left >= 0.0)) return "";
  const auto seconds = static_cast<long>(std::min(spent * left / done, kLongest));
  if (seconds >= 3600) return std::to_string(seconds / 3600) + " h " + std::to_string(seconds / 60 % 60) + " min left";
  return (seconds >= 60 ? std::to_string(seconds / 60) + " min " : "") + std::to_string(seconds % 60) + " s left";
}

void StudyBar::update(double share, double found) {
  const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - start_;
  bar_.update(share, timeLeft(spent.count(), share - found, 1.0 - share));
}

}  // namespace raven2_trainer::apps
