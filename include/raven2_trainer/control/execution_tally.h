#pragma once

#include "raven2_trainer/core/command.h"
#include "raven2_trainer/core/types.h"

namespace raven2_trainer::control {

/** Where the tips are in one tick of an execution, in the arm's base frame B. */
struct ExecutionSample {
  Vec3 path_B{};             ///< [m] where the path puts the tip
  Vec3 goal_B{};             ///< [m] where the path ends
  Vec3 model_B{};            ///< [m] of the nominal model
  Vec3 robot_B{};            ///< [m] of the robot, as received
  std::uint32_t contacts{};  ///< contact points on the model's arm
  double model_clearance{};  ///< [m] of the model's arm from anything
  double robot_clearance{};  ///< [m] of the robot's
};

/** Adds up how an execution goes, tick by tick, to its report. Pure; real-time safe. */
class ExecutionTally {
 public:
  /** Armed: `id` is that of the request. */
  void start(std::uint32_t id, const PlanResult& plan, bool on_robot) noexcept;
  /** The same for anything else: `asked` has the known fields. */
  void start(const ExecutionReport& asked) noexcept;
  /** The pedal went down in this tick. */
  void begin(Tick tick) noexcept { report_.started = tick; }
  void add(const ExecutionSample& sample) noexcept;
  /** [m] of the newest sample: the farther of both tips, the robot's only if it moves, from its place on the path. */
  double deviation() const noexcept { return deviation_; }
  /** [m] of the newest sample: the farther of both tips from the goal. */
  double distanceToGoal() const noexcept;
  /** @param[in] tick first one that no longer moves anything. @param[in] progress [-] of the path. */
  ExecutionReport finish(ExecutionEnd end, Tick tick, double progress) const noexcept;

 private:
  ExecutionReport report_{};  ///< its means are sums
  std::uint32_t samples_{0};
  double deviation_{0.0};
};

}  // namespace raven2_trainer::control
