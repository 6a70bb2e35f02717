#pragma once

#include <nlohmann/json.hpp>
#include <optional>

#include "raven2_trainer/core/types.h"

// What metrics.json and score.json have in common: units, and null for what did not happen.

namespace raven2_trainer::training {

using Json = nlohmann::ordered_json;

inline Json orNull(const std::optional<double>& value, double factor = 1.0) {
  return value ? Json(*value * factor) : Json(nullptr);
}

inline Json orNull(Tick tick) {
  return tick < 0 ? Json(nullptr) : Json(tick);
}

}  // namespace raven2_trainer::training
