#pragma once

#include "raven2_trainer/control/arm_controller.h"
#include "raven2_trainer/core/command.h"
#include "raven2_trainer/core/types.h"

namespace raven2_trainer::control {

/** Shortest duration [s] of a rest-to-rest quintic over `delta` within the limits: peak velocity 15/8 and peak
 *  acceleration 10/sqrt(3) times the mean (closed form of 10s^3 - 15s^4 + 6s^5). Real-time safe. */
double quinticDuration(const JointArray& delta,
                       const JointArray& velocity_limit,
                       const JointArray& acceleration_limit) noexcept;

/** 10s^3 - 15s^4 + 6s^5 at s clamped to [0, 1]. */
double quinticBlend(double s) noexcept;

/** Derivative of quinticBlend at s, 0 outside of [0, 1]. */
double quinticBlendRate(double s) noexcept;

/** At time `t` [s] on the rest-to-rest quintic that leaves `from` at `departure` and is at `to` at `arrival`: there
 *  before and after. Real-time safe. */
JointTarget quinticTarget(const JointArray& from,
                          const JointArray& to,
                          double departure,
                          double arrival,
                          double t) noexcept;

/** Desired joints `seconds` after the start of a plan's motion: the first waypoint before it, the last one after its
 * end.
 *  @param[in,out] segment edge where the search begins; where it ended. 0 before the first call. Real-time safe. */
JointArray pathJoints(const PlanResult& plan, double seconds, std::uint32_t* segment) noexcept;

/** Plays a PlanResult: rest-to-rest quintics between its waypoints, at the times in `arrival`. Real-time safe. */
class PathFollower {
 public:
  /** Begins at the first waypoint. A plan that did not succeed leaves active() false. */
  void start(const PlanResult& plan) noexcept;
  void stop() noexcept { active_ = false; }
  bool active() const noexcept { return active_; }
  Arm arm() const noexcept { return plan_.arm; }
  /** Desired joints one tick later; the last waypoint, and active() false, after the end. Holds still while not
   *  active: at the end, or where stop() left it; zeros if no plan was ever started. */
  JointArray tick() noexcept;

  /** The last result of tick(), and its speed: zero while not active. */
  JointTarget target() const noexcept;

 private:
  double seconds() const noexcept { return static_cast<double>(elapsed_) * kTickSeconds; }
  PlanResult plan_{};
  bool active_{false};
  std::int64_t elapsed_{0};
  std::uint32_t segment_{0};
};

}  // namespace raven2_trainer::control
