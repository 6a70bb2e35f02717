#pragma once

#include <array>

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

constexpr const char* kForceAbove = "force_above";  ///< whose limit is a force [N], not the worst time that passes

}  // namespace raven2_trainer
