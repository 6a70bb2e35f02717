#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "raven2_trainer/core/camera_config.h"
#include "raven2_trainer/core/contact.h"
#include "raven2_trainer/core/exercise.h"
#include "raven2_trainer/core/state.h"
#include "raven2_trainer/kinematics/arms_config.h"
#include "raven2_trainer/model/raven_model.h"

namespace raven2_trainer::training {

/**
 * Judges one attempt at an exercise after the other from what the physics did: contacts and poses of each tick. It
 * neither knows nor asks what moves the arms.
 *
 * - An arm holds an object once both its jaws pressed on it with more than 0.05 N for 20 ms, until they did not for 50
 * ms.
 * - Steps only go forward. A step is done when all it waits for held together for its dwell; a track waits for the one
 *   named in its `after`. In one tick a track goes on by one step at most.
 * - Mistakes count from the beginning of the timer on; what breaks off counts from the start.
 * - An object was dropped if it had been lifted for 0.1 s or more, was let go, and is `grace` later neither held nor
 *   around a target nor where the step it was let go for wants it.
 * - An object is lost if it rests untouched where neither arm reaches it in any of 720 attitudes. They are tried
 *   one a tick.
 * - Where the model does not move by its own physics (choosing a goal, following a plan, returning, replay), in
 * rehearsals and while time is lost nothing is judged: what was held counts as released, and touches end. Time goes on
 * but in waiting, paused and replaying.
 *
 * The constructor is set-up; everything else is real-time safe. One thread owns a judge.
 */
class ExerciseJudge {
 public:
  /**
   * @param[in] exercise without tracks: no exercise; the state stays "none" for ever.
   * @param[in] roles of the scene that the exercise was loaded for. @param[in] scene of the same.
   * @param[in] camera whose lens counts; its place is ModelState::camera.
   * @param[in] body_names physics::RavenWorld::bodyNames().
   * @throw ConfigException with FILE:LINE for a rule that names no body of the scene or robot, an object that is no
   * free body, and tissue that is not there, moves or collides by a mesh.
   */
  ExerciseJudge(const Exercise& exercise,
                const SceneRoles& roles,
                const model::SceneModel& scene,
                const ArmsConfig& arms,
                const CameraConfig& camera,
                const std::vector<std::string>& body_names);
  ~ExerciseJudge();
  ExerciseJudge(const ExerciseJudge&) = delete;
  ExerciseJudge& operator=(const ExerciseJudge&) = delete;

  /** A new attempt begins with the next tick. Before the first one nothing is judged. */
  void start() noexcept;

  /** The attempt, if there is one, fails with the next tick. */
  void giveUp() noexcept;

  /**
   * Whether what the next ticks do will be undone, as a virtual trial is. Then nothing is judged, breaking off
   * included, and time goes on: what is recorded of an attempt is never taken back, and what remains, the trial's
   * repetition on the robot, is judged as any motion.
   */
  void setRehearsal(bool is_rehearsal) noexcept;

  /** @param[in] state, contacts of the same tick. ModelState::exercise is not looked at. */
  void tick(const ModelState& state, const ContactList& contacts, BrokenOff broken) noexcept;

  /** At the end of the last tick. */
  const ExerciseState& state() const noexcept;

  /** Of the last tick: step, 0 until the timer runs, and distances; `tool_changes` is left 0. Distances are infinite
   *  without an attempt, that of the target also after its end. The target is what the running steps wait for: peg,
   *  point, region, place on a wire, or else their object. */
  FaultSignals signals() const noexcept;

  static constexpr std::size_t kMaxEvents = 16;
  /** Events of the last tick, at most kMaxEvents; the last place is the attempt's end. */
  std::size_t eventCount() const noexcept;
  const ExerciseEvent& event(std::size_t i) const noexcept;
  /** Events that found no room in their tick, of all ticks. */
  std::uint64_t lostEvents() const noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace raven2_trainer::training
