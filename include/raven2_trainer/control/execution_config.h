#pragma once

#include <array>
#include <cstdint>

#include "raven2_trainer/core/types.h"

namespace raven2_trainer {

/** Motion of the model's arm along a path. */
enum class ExecutionDrive : std::uint8_t {
  kTracking,  ///< its control law
  kOpenLoop,  ///< torques that the law computes for a separate arm, whatever the model does (paper, 2.3.3)
};
constexpr std::array<const char*, 2> kExecutionDriveNames{"tracking", "open_loop"};

/** config/execution.yaml */
struct ExecutionConfig {
  double speed{};  ///< [-] of the plan's own
  ExecutionDrive drive{};
  double hold_time{};            ///< [s] from the arm's place to the path's start
  JointArray start_tolerance{};  ///< [rad, m] an arm farther from its old place has moved
  double deviation_limit{};      ///< [m] of either tip from its place on the path
  double settle_tolerance{};     ///< [m] of both tips from the goal, to be there
  double settle_speed{};         ///< [m/s] of both tips, to be at rest
  double settle_time{};          ///< [s] after the path's end, to come to rest
  double pedal_timeout{};        ///< [s] armed without a pedal-down
  double robot_timeout{};        ///< [s] that the path may wait because the robot does not follow
};

}  // namespace raven2_trainer
