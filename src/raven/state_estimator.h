#pragma once

#include "raven2_trainer/core/types.h"
#include "raven2_trainer/raven/low_pass.h"
#include "raven2_trainer/raven/usb_packets.h"

namespace raven2_trainer::raven {

/** Motor positions and velocities of one arm from the boards' counts (raven2.md 3.4, 3.7): differences of positions,
 * with or without the low-pass. Counts are relative: the offset comes from homing. Real-time safe. */
class StateEstimator {
 public:
  StateEstimator(Arm arm, bool low_pass) noexcept : arm_(arm), low_pass_(low_pass) {}

  void update(const std::array<std::int32_t, kChannels>& encoder) noexcept;

  /** The motors are here [rad]: new encoder offsets, filter at rest. */
  void setMotor(const JointArray& mpos) noexcept;

  const JointArray& mpos() const noexcept { return mpos_; }      ///< [rad]
  const JointArray& mvel() const noexcept { return mvel_; }      ///< [rad/s]
  const JointArray& offset() const noexcept { return offset_; }  ///< [counts]

 private:
  Arm arm_;
  bool low_pass_;
  bool started_{false};
  LowPass filter_;
  JointArray count_{}, offset_{}, mpos_{}, mvel_{};
};

}  // namespace raven2_trainer::raven
