#pragma once

#include <cstdint>

#include "raven2_trainer/core/config.h"

namespace raven2_trainer::raven {

/** Second phase of the robot's homing: all joints of both arms from where they stand to home, one half-cosine
 *  (raven2.md 4.4). Once a process. Real-time safe. */
class Homing {
 public:
  Homing(const JointArray& home, double time) noexcept;

  /** Starts over from `q` if it is not done; to be called while homing is not allowed. */
  void hold(const PerArm<JointArray>& q) noexcept;

  /** Advances by one cycle. */
  void tick() noexcept;

  JointArray desired(Arm arm) const noexcept;
  bool done() const noexcept { return done_; }

 private:
  JointArray home_;
  std::int64_t length_;  // [cycles]
  std::int64_t elapsed_{0};
  PerArm<JointArray> start_{};
  bool done_{false};
};

}  // namespace raven2_trainer::raven
