#pragma once

#include <cstdint>

#include "raven2_trainer/core/config.h"
#include "raven2_trainer/core/shared_state.h"
#include "raven2_trainer/haptics/force_limiter.h"
#include "raven2_trainer/kinematics/eigen.h"

namespace raven2_trainer::runtime {

/**
 * Body of the haptic thread: eqs. (5) and (6) of the paper on the newest states of model and robot, through a limiter
 * of size and slew. A model or robot that is stale, not linked or not finite is not felt: its force falls to nothing.
 * Real-time safe.
 */
class HapticLoop {
 public:
  HapticLoop(const TrainerConfig& config, SharedState* shared);
  /** @param[in] now_ns CLOCK_MONOTONIC, judges the age of both states. */
  void tick(std::int64_t now_ns) noexcept;
  /** Goes on from the forces of a recorded tick, as re-simulation does. */
  void resume(const HapticState& last) noexcept;
  /** Cells that could not be read in a bounded number of tries. */
  std::uint64_t staleReads() const noexcept { return stale_reads_; }

 private:
  void compute(std::int64_t now_ns) noexcept;
  bool isFresh(std::int64_t now_ns) const noexcept;
  Vector3 wantedForce(Arm arm) const noexcept;

  const HapticGains gains_;
  const std::int64_t stale_ns_;
  SharedState& shared_;
  ModelState model_{};
  RobotState robot_{};
  HapticState haptic_{};
  PerArm<haptics::ForceLimiter> limiters_;
  std::int64_t last_ns_{0};
  std::uint32_t sequence_{0};
  std::uint64_t stale_reads_{0};
};

}  // namespace raven2_trainer::runtime
