#pragma once

#include <array>
#include <string_view>

#include "raven2_trainer/training/band.h"

namespace raven2_trainer {

/** All that can be scored of an attempt, in the order of training::listMetrics(). What they are: doc/scores.md. */
constexpr std::array<const char*, 34> kMetricNames{
    "time",
    "path",
    "economy",
    "off_path",
    "off_path_p95",
    "idle",
    "mean_jerk",
    "sparc",
    "stroke_sparc",
    "ldlj",
    "tremor",
    "collisions",
    "collision_time",
    "wire_touches",
    "wire_time",
    "drops",
    "break_offs",
    "out_of_order",
    "wrong_arm",
    "peak_force",
    "force_p95",
    "force_impulse",
    "force_above",
    "out_of_view",
    "clutches",
    "clutch_time",
    "engaged",
    "camera_moves",
    "camera_time",
    "master_radius",
    "master_deviation",
    "bimanual",
    "speed_correlation",
    "tracking",
};

/** Of these more is better, of the others less. */
constexpr std::array<const char*, 7> kHigherIsBetter{"economy", "sparc",    "stroke_sparc",     "ldlj",
                                                     "engaged", "bimanual", "speed_correlation"};

inline bool isMetric(std::string_view name) noexcept {
  for (const char* known : kMetricNames) {
    if (name == known) return true;
  }
  return false;
}

inline Better betterOf(std::string_view metric) noexcept {
  for (const char* name : kHigherIsBetter) {
    if (metric == name) return Better::kHigher;
  }
  return Better::kLower;
}

constexpr const char* kLogarithmic = "ldlj";        ///< a share of its mean means nothing
constexpr const char* kForceAbove = "force_above";  ///< whose limit is a force [N], not the worst time that passes

}  // namespace raven2_trainer
