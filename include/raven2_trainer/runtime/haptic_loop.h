#pragma once

#include <cstdint>

#include "raven2_trainer/core/config.h"
#include "raven2_trainer/core/shared_state.h"

namespace raven2_trainer::runtime {

/** Body of the haptic thread: eqs. (5) and (6) of the paper on the newest states of model and robot. Real-time safe. */
class HapticLoop {
 public:
  HapticLoop(const TrainerConfig& config, SharedState* shared);
  /** @param[in] now_ns CLOCK_MONOTONIC, judges the age of the robot's state. */
  void tick(std::int64_t now_ns) noexcept;
  /** Cells that could not be read in a bounded number of tries. */
  std::uint64_t staleReads() const noexcept { return stale_reads_; }

 private:
  void compute(std::int64_t now_ns) noexcept;

  const HapticGains gains_;
  const std::int64_t stale_ns_;
  SharedState& shared_;
  ModelState model_{};
  RobotState robot_{};
  HapticState haptic_{};
  std::uint32_t sequence_{0};
  std::uint64_t stale_reads_{0};
};

}  // namespace raven2_trainer::runtime
