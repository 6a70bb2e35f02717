#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace raven2_trainer {

/** What is to be done before the next stage. */
struct CurriculumStage {
  std::string exercise;
  std::string drill;      ///< scenario of config/faults; empty: none
  std::int64_t passes{};  ///< in a row
  std::int64_t extra{};   ///< passes behind those, in any order
};

/** One file of config/curricula. */
struct Curriculum {
  std::string name, title;
  std::vector<CurriculumStage> stages;
  double deviations{};  ///< [-] of a band that a metric may lie on the worse side of its mean
};

}  // namespace raven2_trainer
