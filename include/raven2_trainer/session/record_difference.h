#pragma once

#include <string>

#include "raven2_trainer/core/record.h"

namespace raven2_trainer::session {

/**
 * Compares field by field, bit for bit: -0 is not 0, and a NaN equals itself; padding does not count.
 * @return empty if equal, else the first field that differs and both values: "arms[1].q[2] is 0.1, was 0.2".
 */
std::string difference(const ModelState& now, const ModelState& before);
std::string difference(const HapticState& now, const HapticState& before);
std::string difference(const ContactRecord& now, const ContactRecord& before);
std::string difference(const ExecutionRecord& now, const ExecutionRecord& before);
std::string difference(const ExerciseRecord& now, const ExerciseRecord& before);

}  // namespace raven2_trainer::session
