#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "raven2_trainer/config/trainer_config.h"
#include "raven2_trainer/core/state.h"
#include "raven2_trainer/detector/anomaly_detector.h"

namespace raven2_trainer::studies {

/** One tick of a trial: what an observer at the USB boards sees, and the truth next to it. */
struct TrialTick {
  PerArm<Vec3> motor{};                       ///< [rad] positioning motors, measured, at the cycle's start
  PerArm<std::array<std::int32_t, 3>> dac{};  ///< [counts] their commands, as written at its end
  PerArm<JointArray> q{};                     ///< [rad; m] joints that the control program makes of the motors
  Vec3 tip{};                                 ///< [m] [@frame B] true tip of the gold arm, at its end
  RunLevel level{};                           ///< of the control program
  std::uint8_t soft_estopped{};               ///< 1 once the robot's own check has stopped it
};

/** Input of a detector in the robot in that cycle. */
detector::Observation observationOf(const TrialTick& tick) noexcept;

/**
 * A lockstep stack led to `ticks` after the first pedal-down and then left as it is: every run is a fork of it, so runs
 * differ by their fault alone. Needs a process without threads; ODE must be initialised. No files, no clocks.
 */
class DetectorTrial {
 public:
  /** @param[in] config its hazard is not armed. @throw ModelException; Exception if no pedal-down comes. */
  DetectorTrial(const TrainerConfig& config, Tick ticks);
  ~DetectorTrial();

  /** The last `ticks` ms; at most those since the start. */
  const std::vector<TrialTick>& past() const noexcept { return past_; }

  /** The next `ticks` ms with this plan armed, none of them kept. @throw Exception if it cannot be forked. */
  std::vector<TrialTick> run(const FaultPlan& plan, Tick ticks) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
  std::vector<TrialTick> past_;
};

}  // namespace raven2_trainer::studies
