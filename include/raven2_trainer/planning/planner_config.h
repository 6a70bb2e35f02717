#pragma once

#include <cstdint>
#include <string>

#include "raven2_trainer/core/types.h"

namespace raven2_trainer {

/** config/planner.yaml */
struct PlannerConfig {
  std::string planner;               ///< one of planning::kPlannerNames
  std::uint32_t samples{};           ///< n of the paper
  std::uint32_t max_samples{};       ///< most, those added after failures included
  double eta_length{};               ///< eta1 of eq. (1)
  double eta_acceleration{};         ///< eta2 of eq. (1)
  double eta_clearance{};            ///< weight of the clearance term
  double clearance_range{};          ///< [m] nearer than this an obstacle costs
  double radius_multiplier{};        ///< [-] times the smallest radius that keeps FMT* optimal
  std::uint32_t volume_samples{};    ///< of the estimate of the free volume
  double volume_confidence{};        ///< [-] that the bound of the free volume holds
  std::uint32_t improve_attempts{};  ///< [-] of the local improvement; 0 leaves FMT*'s path as it is
  std::uint32_t max_rollouts{};      ///< [-] paths that may fail in the roll-out before the plan does
  double max_tracking_error{};       ///< [m] of the tip in the roll-out; farther astray it does not follow
  double time_limit{};               ///< [s]
  double edge_step{};                ///< [-] eight times the largest step, in the unit cube, between checks along an
                                     ///< edge from or to an end that is nearer than the clearance; of no other edge
  double clearance{};                ///< [m] kept from obstacles
  JointArray velocity_limit{};       ///< [rad/s, m/s]
  JointArray acceleration_limit{};   ///< [rad/s2, m/s2]
  Vec3 goal_W{};                     ///< [m] default goal of the tip: at the ring
};

}  // namespace raven2_trainer
