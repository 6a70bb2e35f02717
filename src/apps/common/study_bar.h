#pragma once

#include <chrono>
#include <string>

#include "apps/common/command_line.h"

namespace raven2_trainer::apps {

/** A progress bar that says how long is left. */
class StudyBar {
 public:
  explicit StudyBar(const std::string& label) : bar_(label) {}
  void update(double share) { bar_.update(share, left(share)); }
  void done(const std::string& detail) { bar_.done(detail); }

 private:
  std::string left(double share) const {
    if (!(share > 0.0)) return "";
    const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - start_;
    return std::to_string(static_cast<long>(spent.count() * (1.0 - share) / share)) + " s left";
  }

  ProgressBar bar_;
  std::chrono::steady_clock::time_point start_{std::chrono::steady_clock::now()};
};

}  // namespace raven2_trainer::apps
