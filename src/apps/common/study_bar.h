#pragma once

#include <chrono>
#include <string>

#include "apps/common/command_line.h"

namespace raven2_trainer::apps {

/**
 * The time left in words, at the speed so far: "3 min 20 s left".
 * @param[in] spent [s] since the start. @param[in] done,left work since then and from now on, in the same unit.
 * @return empty in the first 2 s, which include the one-time preparation.
 */
std::string timeLeft(double spent, double done, double left);

/** A progress bar with the time left. */
class StudyBar {
 public:
  explicit StudyBar(const std::string& label) : bar_(label) {}
  /** @param[in] share of the work that is done. @param[in] found part of it that took no time: it existed or failed. */
  void update(double share, double found = 0.0);
  void done(const std::string& detail) { bar_.done(detail); }

 private:
  ProgressBar bar_;
  std::chrono::steady_clock::time_point start_{std::chrono::steady_clock::now()};
};

}  // namespace raven2_trainer::apps
