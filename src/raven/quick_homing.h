#pragma once

#include <cstdint>

#include "raven2_trainer/core/types.h"

namespace raven2_trainer::raven {

/** Homing `quick`: the joints are known from power-on, so only the second phase of the robot's homing is left: all
 * joints of both arms to home in one half-cosine (raven2.md 4.4). Once a process. Real-time safe. */
class QuickHoming {
 public:
  QuickHoming(const JointArray& home, double time) noexcept;

  /** Starts over from `q` if it is not done; to be called while homing is not allowed. */
  void hold(const PerArm<JointArray>& q) noexcept;

  /** Advances by one cycle. */
  void tick() noexcept;

  JointArray desired(Arm arm) const noexcept;
  bool done() const noexcept { return done_; }
  void assumeDone() noexcept { done_ = true; }

 private:
  JointArray home_;
  std::int64_t length_;  // [cycles]
  std::int64_t elapsed_{0};
  PerArm<JointArray> start_{};
  bool done_{false};
};

}  // namespace raven2_trainer::raven
