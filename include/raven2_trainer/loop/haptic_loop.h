#pragma once

#include <cstdint>

#include "raven2_trainer/haptics/force_limiter.h"
#include "raven2_trainer/haptics/passivity_guard.h"
#include "raven2_trainer/kinematics/eigen.h"
#include "raven2_trainer/loop/loop_config.h"
#include "raven2_trainer/loop/shared_state.h"

namespace raven2_trainer::loop {

/**
 * Body of the haptic thread. It applies equations 5 and 6 of the paper to the newest states of model and robot, and, if
 * they are on, guidance along a planned path and a cue at the edge of the master's workspace. All goes through the
 * passivity controller and a limiter of size and slew. A model or robot that is stale, not linked or not finite is not
 * felt: its force falls to nothing. Real-time safe.
 *
 * Two accounts of each port: that of all that is given, which shortens the guidance first and then the edge, and that
 * of what is given less those two, which shortens the cue. So the cue never pays for what the others gave, and they do
 * not give where the cue has used up what the hand can take. doc/haptics.md has the bound for the whole.
 *
 * While a CRTK client holds the pedal (ServoState) the force is its own: the console's hand, which moves nothing, is
 * given none.
 *
 * A tick is observe(), compute(), account(). Everything that one tick passes to the next is in its HapticState,
 * so that re-simulation computes a recorded tick from the records before it, with the same three functions.
 */
class HapticLoop {
 public:
  HapticLoop(const LoopConfig& config, SharedState* shared);
  /** @param[in] now_ns CLOCK_MONOTONIC, judges the age of both states. */
  void tick(std::int64_t now_ns) noexcept;

  /** First: where the masters are. @param[in] master_I ModelState::master_I. */
  void observe(const PerArm<Vec3>& master_I) noexcept;
  /** Then: what these states ask for, after the tick that was accounted for last. Changes nothing.
   *  @param[in] path followed if it is that of model.guide_plan. */
  HapticState compute(const ModelState& model,
                      const RobotState& robot,
                      const GuidePath& path,
                      std::int64_t now_ns) const noexcept;
  /** Last: what was given. */
  void account(const HapticState& state) noexcept;

  /** Records are missing: what was handed on is not known until the guards have started again. */
  void forget() noexcept;
  bool knowsItself() const noexcept;

  /** Cells that could not be read in a bounded number of tries. */
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
  const bool has_fixtures_;  ///< guidance or edge is on: without them both accounts were the same
  PerArm<haptics::ForceLimiter> limiters_;
  PerArm<haptics::ForceLimiter> fixture_limiters_;  ///< of guidance and edge, before the whole is limited
  PerArm<haptics::PassivityGuard> guards_;          ///< of all that is given
  PerArm<haptics::PassivityGuard> cue_guards_;      ///< of that less guidance and edge; idle without them
  PerArm<haptics::ForceLimiter> console_limiters_;  ///< of what the console is given, in I; idle without clients
  PerArm<bool> is_spared_{};                        ///< the console is given less than what there is
  ServoState servo_{};
  bool forgotten_{false};
  std::uint64_t stale_reads_{0};
};

}  // namespace raven2_trainer::loop
