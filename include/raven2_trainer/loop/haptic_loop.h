#pragma once

#include <cstdint>

#include "raven2_trainer/haptics/force_limiter.h"
#include "raven2_trainer/haptics/passivity_guard.h"
#include "raven2_trainer/kinematics/eigen.h"
#include "raven2_trainer/loop/loop_config.h"
#include "raven2_trainer/loop/shared_state.h"

namespace raven2_trainer::loop {

/**
 * Body of the haptic thread. It applies eqs. 5, 6 of Li et al. 2017 to the newest states of model and robot. If
 * enabled, it adds guidance along a planned path and a force at the edge of the master's workspace. The passivity
 * controller and a limiter of size and slew bound the sum. If states are stale or unlinked, the force falls
 * to zero; NaN zeroes only forces that use it. Real-time safe.
 *
 * With guidance or edge, each port has two energy accounts. The account of the total force reduces first the guidance,
 * then the edge force. The account without these two reduces the force cue. So the cue never pays for the energy
 * of guidance and edge, and these give nothing once the cue has used the hand's allowance. doc/haptics.md has the bound
 * for the total.
 *
 * While a CRTK client holds the pedal (ServoState), the console gets zero force, because its hand moves nothing.
 *
 * A tick is observe(), compute(), account(). All memory between ticks follows from the HapticStates so far. So
 * re-simulation computes a recorded tick from the records before it, with the same three functions.
 */
class HapticLoop {
 public:
  HapticLoop(const LoopConfig& config, SharedState* shared);
  /** @param[in] now_ns CLOCK_MONOTONIC, for the age of both states. */
  void tick(std::int64_t now_ns) noexcept;

  /** First: the masters' positions. @param[in] master_I ModelState::master_I. */
  void observe(const PerArm<Vec3>& master_I) noexcept;
  /** Then: the forces for these states, after the last accounted tick. Changes nothing.
   *  @param[in] path used if it belongs to model.guide_plan. */
  HapticState compute(const ModelState& model,
                      const RobotState& robot,
                      const GuidePath& path,
                      std::int64_t now_ns) const noexcept;
  /** Last: the forces that were given. */
  void account(const HapticState& state) noexcept;

  /** Call if records are missing: knowsItself() is false until both guards rest together (`passivity/rest`). */
  void forget() noexcept;
  bool knowsItself() const noexcept;

  /** Reads of a StateCell that failed in every try. */
  std::uint64_t staleReads() const noexcept { return stale_reads_; }

 private:
  struct Inputs {
    const ModelState& model;
    const RobotState& robot;
    const GuidePath& path;
    double seconds;  ///< [s] since the last tick
  };

  void readCells() noexcept;
  void send(double seconds) noexcept;
  Vec3 forConsole(Arm arm, double seconds) noexcept;
  bool isFresh(const Inputs& in, std::int64_t now_ns) const noexcept;
  void computeArm(Arm arm, const Inputs& in, HapticState* out) const noexcept;
  Vector3 handFromMiddle(Arm arm, const ModelState& model) const noexcept;
  Vector3 cue(Arm arm, const Inputs& in) const noexcept;
  Vector3 guidance(Arm arm, const Inputs& in, HapticState* out) const noexcept;
  Vector3 edge(Arm arm, const HapticState& out) const noexcept;
  Vector3 fixtures(Arm arm, const HapticState& asked, double seconds) const noexcept;
  const haptics::PassivityGuard& cueGuard(Arm arm) const noexcept;
  void accountArm(Arm arm, const HapticState& state, double seconds) noexcept;
  void accountCue(Arm arm, const HapticState& state) noexcept;

  const HapticGains gains_;
  const double scale_;  ///< [-] motion of the tip per motion of the hand
  const std::int64_t stale_ns_;
  SharedState& shared_;
  ModelState model_{};
  RobotState robot_{};
  GuidePath path_{};
  std::uint64_t path_version_{0};
  HapticState last_{};
  const bool has_fixtures_;  ///< guidance or edge is enabled; else one account is enough
  PerArm<haptics::ForceLimiter> limiters_;
  PerArm<haptics::ForceLimiter> fixture_limiters_;  ///< of guidance and edge, before the total is limited
  PerArm<haptics::PassivityGuard> guards_;          ///< of the total force
  PerArm<haptics::PassivityGuard> cue_guards_;      ///< of the total without guidance and edge; unused without them
  PerArm<haptics::ForceLimiter> console_limiters_;  ///< of the console's force, in I; unused without clients
  PerArm<bool> is_spared_{};                        ///< the console gets less than the computed force
  ServoState servo_{};
  bool forgotten_{false};
  std::uint64_t stale_reads_{0};
};

}  // namespace raven2_trainer::loop
