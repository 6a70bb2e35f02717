#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <string_view>

#include "raven2_trainer/training/band.h"

namespace raven2_trainer {

/** As the industry groups them (sources.md 3.4). */
enum class MetricGroup : std::uint8_t { kEfficiency, kSafety, kControl };
constexpr std::array<const char*, 3> kMetricGroupNames{"efficiency", "safety", "control"};

struct MetricInfo {
  const char* name;
  const char* unit;
  MetricGroup group;
  Better better;
};

/** All that can be scored of an attempt, in the order in which it is listed. What they are: doc/scores.md. */
constexpr std::array<MetricInfo, 34> kMetrics{{
    {"time", "s", MetricGroup::kEfficiency, Better::kLower},
    {"path", "mm", MetricGroup::kEfficiency, Better::kLower},
    {"economy", "-", MetricGroup::kEfficiency, Better::kHigher},
    {"off_path", "mm", MetricGroup::kEfficiency, Better::kLower},
    {"off_path_p95", "mm", MetricGroup::kEfficiency, Better::kLower},
    {"idle", "-", MetricGroup::kEfficiency, Better::kLower},
    {"mean_jerk", "m/s^3", MetricGroup::kEfficiency, Better::kLower},
    {"sparc", "-", MetricGroup::kEfficiency, Better::kHigher},
    {"stroke_sparc", "-", MetricGroup::kEfficiency, Better::kHigher},
    {"ldlj", "-", MetricGroup::kEfficiency, Better::kHigher},
    {"tremor", "um", MetricGroup::kEfficiency, Better::kLower},
    {"collisions", "count", MetricGroup::kSafety, Better::kLower},
    {"collision_time", "s", MetricGroup::kSafety, Better::kLower},
    {"wire_touches", "count", MetricGroup::kSafety, Better::kLower},
    {"wire_time", "s", MetricGroup::kSafety, Better::kLower},
    {"drops", "count", MetricGroup::kSafety, Better::kLower},
    {"break_offs", "count", MetricGroup::kSafety, Better::kLower},
    {"out_of_order", "count", MetricGroup::kSafety, Better::kLower},
    {"wrong_arm", "count", MetricGroup::kSafety, Better::kLower},
    {"peak_force", "N", MetricGroup::kSafety, Better::kLower},
    {"force_p95", "N", MetricGroup::kSafety, Better::kLower},
    {"force_impulse", "Ns", MetricGroup::kSafety, Better::kLower},
    {"force_above", "s", MetricGroup::kSafety, Better::kLower},
    {"out_of_view", "s", MetricGroup::kSafety, Better::kLower},
    {"clutches", "count", MetricGroup::kControl, Better::kLower},
    {"clutch_time", "s", MetricGroup::kControl, Better::kLower},
    {"engaged", "-", MetricGroup::kControl, Better::kHigher},
    {"camera_moves", "count", MetricGroup::kControl, Better::kLower},
    {"camera_time", "s", MetricGroup::kControl, Better::kLower},
    {"master_radius", "mm", MetricGroup::kControl, Better::kLower},
    {"master_deviation", "mm", MetricGroup::kControl, Better::kLower},
    {"bimanual", "-", MetricGroup::kControl, Better::kHigher},
    {"speed_correlation", "-", MetricGroup::kControl, Better::kHigher},
    {"tracking", "mm", MetricGroup::kControl, Better::kLower},
}};

/** nullptr: no metric is called so. */
inline const MetricInfo* findMetric(std::string_view name) noexcept {
  const auto* found =
      std::find_if(kMetrics.begin(), kMetrics.end(), [&](const MetricInfo& info) { return name == info.name; });
  return found == kMetrics.end() ? nullptr : found;
}

constexpr const char* kLogarithmic = "ldlj";        ///< a share of its mean means nothing
constexpr const char* kForceAbove = "force_above";  ///< whose limit is a force [N], not the worst time that passes

}  // namespace raven2_trainer
