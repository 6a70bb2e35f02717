#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "raven2_trainer/loop/loop_config.h"
#include "raven2_trainer/loop/shared_state.h"
#include "raven2_trainer/model/raven_model.h"

namespace raven2_trainer::loop {

/** [s] Longest recorded virtual trial, pedal down; our choice: 160 bytes a tick, 19 MB, allocated at construction. */
constexpr double kTrialLimit = 120.0;

/**
 * Body of the physics thread: masters' increments to desired joints, controllers, one ODE step, the relay to the robot,
 * and the mode. It owns the live world. tick() is real-time safe after the first ticks.
 *
 * Each mode has an activity that does its work in a tick (src/loop/activity/, core/mode.h): teleoperation, planning,
 * goal selection, execution, trial, returning, replay, camera, hold.
 *
 * Linking model and robot: while the pedal is up and the robot's state is fresh, the model's controllers bring it to
 * the robot's joints (objects in the jaws stay held). At pedal-down the model jumps there, except its jaws' opening:
 * both start from one pose. Neither applies increments before the robot reports PEDAL_DN, so that both apply the same
 * ones. If the robot's link is lost while engaged, the model continues alone. The robot then gets pedal-up until the
 * surgeon's next pedal-down: without a new start from a common pose it does not move, and the cue does not act.
 *
 * CRTK clients are one more master (ServoManager): their motion becomes commands, and faults, log, model and relay
 * treat these like the console's.
 */
class PhysicsLoop {
 public:
  /** @param[in] config outlives the loop. @param[in] trial_limit [s] longest virtual trial. @throw ModelException. */
  PhysicsLoop(const LoopConfig& config,
              const model::RavenModel& raven,
              const model::SceneModel& scene,
              SharedState* shared,
              double trial_limit = kTrialLimit);
  ~PhysicsLoop();

  /** Advances the nominal model by one 1 ms step. @param[in] now_ns CLOCK_MONOTONIC; in lockstep tick x 1e6. */
  void tick(std::int64_t now_ns) noexcept;

  /** Simulated time was lost (CyclicThread): pauses the exercise and unlinks the robot until the next pedal-down. */
  void timeSlip() noexcept;
  /** As timeSlip(), at the next tick; for any thread whose loop lost time. */
  void requestPause() noexcept;

  /** Inputs of fault triggers, from the next tick on. Call it in the thread of tick(). */
  void setSignals(const FaultSignals& signals) noexcept;

  /** Number of the newest used packet of the masters, after the faults on their stream; 0 before the first. Call it in
   *  the thread of tick(). */
  std::uint32_t newestCommand() const noexcept;

  /** Names of bodies by their numbers in contacts. */
  const std::vector<std::string>& bodyNames() const noexcept;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace raven2_trainer::loop
