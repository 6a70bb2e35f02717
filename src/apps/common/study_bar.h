#pragma once

#include <chrono>
#include <string>

#include "apps/common/command_line.h"

namespace raven2_trainer::apps {

/**
 * How long is left, in words, if it goes on as it went: "3 min 20 s left".
 * @param[in] spent [s] since the start. @param[in] done,left since then and from now on, both in one unit, whichever.
 * @return empty while nothing can be said: the first 2 s hold what is done only once, and say nothing of the rest.
 */
std::string timeLeft(double spent, double done, double left);

/** A progress bar that says how long is left. */
class StudyBar {
 public:
  explicit StudyBar(const std::string& label) : bar_(label) {}
  /** @param[in] share of all that is done. @param[in] found the part of it that took no time: it was there, or failed.
   */
  void update(double share, double found = 0.0);
  void done(const std::string& detail) { bar_.done(detail); }

 private:
  ProgressBar bar_;
  std::chrono::steady_clock::time_point start_{std::chrono::steady_clock::now()};
};

}  // namespace raven2_trainer::apps
