#pragma once

#include <string>

#include "raven2_trainer/core/command.h"

namespace raven2_trainer {

/** One file of config/problems: what the program `plan` asks the planner, again and again. */
struct PlanProblem {
  std::string name;         ///< of the file, without .yaml
  std::string description;  ///< one line
  PlanRequest request{};    ///< its goal is kTip or kJoints; id and tick stay 0
};

}  // namespace raven2_trainer
