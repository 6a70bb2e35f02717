#pragma once

#include <memory>

#include "raven2_trainer/loop/loop_config.h"
#include "raven2_trainer/loop/shared_state.h"
#include "raven2_trainer/physics/raven_world.h"
#include "raven2_trainer/training/exercise_judge.h"

namespace raven2_trainer::loop {

/**
 * The exercise of a session within the physics loop: its judge, the scene's first state, and the ring that brings its
 * events to recorder and pages; lost events count among the ring's dropped ones. Without an exercise it
 * does nothing. The constructor is set-up; the rest is real-time safe; one thread.
 */
class ExerciseRunner {
 public:
  /** The first attempt begins with the first tick. @param[in] world as the session begins; outlives this.
   *  @throw ConfigException as training::ExerciseJudge. */
  ExerciseRunner(const LoopConfig& config,
                 const model::SceneModel& scene,
                 const CameraConfig& camera,
                 physics::RavenWorld* world,
                 SharedState* shared);

  bool hasExercise() const noexcept { return judge_ != nullptr; }
  /** Objects back to where they were, and a new attempt. */
  void restart() noexcept;
  /** Judges what the tick did: fills in `state->exercise`. @param[in] contacts of the same tick. @param[in]
   * is_rehearsal what happens in it will be undone (ExerciseJudge::setRehearsal). */
  void tick(ModelState* state, const ContactList& contacts, bool is_rehearsal) noexcept;
  /** For the triggers of the next tick. */
  FaultSignals signals() const noexcept { return judge_ != nullptr ? judge_->signals() : FaultSignals{}; }

 private:
  void publish(Tick tick) noexcept;

  physics::RavenWorld& world_;
  SharedState& shared_;
  std::unique_ptr<training::ExerciseJudge> judge_;
  physics::SceneSnapshot at_first_;
  ExerciseNews news_;
  std::uint64_t lost_{};  ///< events that the judge had no room for, as counted in the ring
};

}  // namespace raven2_trainer::loop
