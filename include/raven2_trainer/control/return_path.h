#pragma once

#include <cstdint>

#include "raven2_trainer/core/types.h"

namespace raven2_trainer::control {

/**
 * Both arms from their places to their goals: minimum jerk in the joints (the quintic of path_follower.h),
 * rest to rest, as fast as the limits let the slower of them. Both arrive in the same tick. Pure; real-time safe.
 */
class ReturnPath {
 public:
  /** [rad/s, m/s] and [rad/s2, m/s2] */
  ReturnPath(const JointArray& velocity_limit, const JointArray& acceleration_limit) noexcept
      : velocity_limit_(velocity_limit), acceleration_limit_(acceleration_limit) {}

  /** [rad; m] */
  void start(const PerArm<JointArray>& from, const PerArm<JointArray>& to) noexcept;

  /** Where the arms shall be one tick later. */
  PerArm<JointArray> tick() noexcept;

  /** The last tick was the goal. */
  bool isOver() const noexcept { return static_cast<double>(elapsed_) * kTickSeconds >= duration_; }
  /** [s] */
  double duration() const noexcept { return duration_; }
  /** [rad; m] */
  const PerArm<JointArray>& goal() const noexcept { return to_; }

 private:
  JointArray velocity_limit_, acceleration_limit_;
  PerArm<JointArray> from_{}, to_{};
  double duration_{0.0};
  std::int64_t elapsed_{0};
};

}  // namespace raven2_trainer::control
