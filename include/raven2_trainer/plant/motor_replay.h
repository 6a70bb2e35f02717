#pragma once

#include <array>
#include <memory>
#include <vector>

#include "raven2_trainer/model/raven_model.h"
#include "raven2_trainer/plant/motor_recording.h"
#include "raven2_trainer/raven/virtual_raven_config.h"

namespace raven2_trainer::plant {

/**
 * The plant's gold arm started from recorded motor states and driven by the recorded DAC, open loop.
 * Identification compares it with the recording. Unrecorded states come from the past only: up to the start the motors
 * follow the recording, so that stretched cables and links obey their equations. The tool joints
 * are at home, held by the control software's proportional gains. Deterministic.
 */
class MotorReplay {
 public:
  /** @throw ModelException, ConfigException as ArmPlant. */
  MotorReplay(const model::RavenModel& raven, const VirtualRavenConfig& config, MotorRecording recording);
  ~MotorReplay();

  using Motors = std::array<double, 3>;

  /** Leads the motors on to row `row`; from the first row again if it has passed. @pre row < rows */
  void leadTo(std::size_t row);

  /** Motor positions [rad] 1 .. horizon milliseconds after the row led to. @pre it has that many rows after it */
  std::vector<Motors> predict(std::size_t horizon) const;

  const MotorRecording& recording() const noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/** Root mean square prediction errors of motors 1 to 3 over many starts. [rad] */
struct ReplayError {
  std::array<double, 3> plant{};              ///< of the plant
  std::array<double, 3> constant_velocity{};  ///< of going on with the last row's rate
};

/** Errors `horizon` milliseconds ahead, from every `stride`-th row of [first, last). */
ReplayError replayError(MotorReplay* replay,
                        std::size_t first,
                        std::size_t last,
                        std::size_t stride,
                        std::size_t horizon);

}  // namespace raven2_trainer::plant
