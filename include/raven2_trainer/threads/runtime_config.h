#pragma once

#include <cstdint>
#include <string>

namespace raven2_trainer {

/** Scheduling of one thread. */
struct ThreadConfig {
  int priority{};  ///< SCHED_FIFO priority, 0 = normal scheduling
  int cpu{};       ///< -1 any
};

/** config/runtime.yaml */
struct RuntimeConfig {
  ThreadConfig physics{}, haptic{}, ingest{}, robot_link{}, sender{};
  int stack_kib{};                     ///< [KiB] of each thread above
  int background_nice{};               ///< [-] of planner, renderer, recovery
  int max_catch_up{};                  ///< [ticks] extra steps per tick when behind
  double max_backlog{};                ///< [s] beyond it the backlog is given up as a time-slip event
  double fault_period{};               ///< [s] of the fault director
  double recorder_period{};            ///< [s]
  std::string flight_recorder;         ///< folder on a tmpfs for the record queues, or "none"
  double ros_period{};                 ///< [s] of the ROS publishers
  double plan_at{};                    ///< [s] session time of the scheduled plan; negative = none
  std::int64_t lockstep_plan_delay{};  ///< [ticks] from plan request to result in lockstep
  double start_timeout{};              ///< [s] wait for the first pedal down; 0 = for ever
  bool enable_remote_control{};        ///< offer ROS commands to a network, too
};

}  // namespace raven2_trainer
