#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "raven2_trainer/loop/loop_config.h"
#include "raven2_trainer/loop/shared_state.h"
#include "raven2_trainer/model/raven_model.h"

namespace raven2_trainer::loop {

/** [s] Longest virtual trial that is kept, pedal down; ours: 160 bytes a tick, 19 MB, are taken at construction. */
constexpr double kTrialLimit = 120.0;

/**
 * Body of the physics thread: masters' increments to desired joints, controllers, one ODE step, the relay to the robot,
 * and the mode. Owner of the live world. tick() is real-time safe once warm.
 *
 * What a tick does in a mode is the work of that mode's activity (src/loop/activity/, core/mode.h): teleoperation,
 * planning, goal selection, execution, trial, returning, replay, camera, hold.
 *
 * Linking model and robot: while the pedal is up and the robot's state is fresh, the model's controllers bring it to
 * the robot's joints (objects in the jaws stay held). At pedal down it is put exactly there, and both start from one
 * pose. Increments count for neither until the robot reports PEDAL_DN, so that both apply the same ones. If the robot's
 * link is lost while engaged, the model goes on alone and the robot is sent pedal-up until the surgeon's next
 * pedal-down: it never moves, nor does the cue act, without a new start from a common pose.
 *
 * CRTK clients are one more master (ServoManager): their requests arrive as commands in addition to the console's, and
 * is recorded, corrupted, taken and relayed as those are.
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

  /** Simulated time was given up (CyclicThread): pauses the exercise and unlinks the robot until the next pedal-down.
   */
  void timeSlip() noexcept;
  /** The same at the next tick, from any thread: another loop of the exercise gave up time, or somebody asks for a
   * pause. */
  void requestPause() noexcept;

  /** Signals for faults' triggers, from the next tick on; from the thread of the ticks. */
  void setSignals(const FaultSignals& signals) noexcept;

  /** Bodies by the numbers of contacts. */
  const std::vector<std::string>& bodyNames() const noexcept;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace raven2_trainer::loop
