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
 * Judges the attempts at an exercise, one after the other, from the contacts and poses of each tick. It does not use
 * the source of the motion.
 *
 * - An arm holds an object when each of its jaws has pressed on it with more than 0.05 N for 20 ms. The hold ends after
 *   50 ms without such a press.
 * - A step is done when all its conditions have been true together for its `dwell`; it stays done. A track begins when
 *   the track named in its `after` is done. Each track finishes at most one step per tick.
 * - Mistakes count once the timer runs. A part that breaks off counts from the start of the attempt.
 * - An object was dropped if it had been lifted for 0.1 s or more, was released, and `grace` later is neither held, nor
 *   around a target, nor where the track's current or previous step expects it.
 * - An object is lost if it rests untouched for 1 s where neither arm reaches it in any of 720 tool orientations, or if
 *   it fell off the table. Each tick tries one orientation of one arm.
 * - Nothing is judged in modes without ModeTraits::judged (choosing a goal, tracking a plan, returning, replay and
 *   others) and in rehearsals: held objects count as released, and touches end. The timer runs where ModeTraits::timed.
 *
 * Real-time safe except for the constructor. One thread owns a judge.
 */
class ExerciseJudge {
 public:
  /**
   * @param[in] exercise Without tracks, the status stays kNone.
   * @param[in] roles Roles of the exercise's scene. @param[in] scene That scene.
   * @param[in] camera Only the lens is used; the pose is ModelState::camera.
   * @param[in] body_names physics::RavenWorld::bodyNames().
   * @throw ConfigException with FILE:LINE if a rule names a body that is missing in scene and robot, an object is not a
   * free body, or tissue is missing, moves or collides by a mesh.
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

  /** Begins a new attempt in the next tick. Nothing is judged before the first attempt. */
  void start() noexcept;

  /** The current attempt, if any, fails in the next tick. */
  void giveUp() noexcept;

  /**
   * @param[in] is_rehearsal True if the effects of the next ticks will be undone, as in a virtual trial. The timer
   * runs, but nothing is judged, not even parts that break off, because judgements are never undone. The trial's
   * repetition on the robot is no rehearsal.
   */
  void setRehearsal(bool is_rehearsal) noexcept;

  /** Judges one tick. @param[in] state, contacts, broken Of the same tick; ModelState::exercise is not used. */
  void tick(const ModelState& state, const ContactList& contacts, BrokenOff broken) noexcept;

  /** State after the last tick. */
  const ExerciseState& state() const noexcept;

  /** Inputs of hazard triggers after the last tick. The step is 0 until the timer runs; `tool_changes` stays 0. Both
   *  distances are infinite before the first attempt and during a replay, and the target's distance after an attempt.
   *  Targets are those of the current steps: peg, point, region, place on a wire, or else the track's object. */
  FaultSignals signals() const noexcept;

  static constexpr std::size_t kMaxEvents = 16;
  /** Events of the last tick. The last of kMaxEvents places is reserved for the attempt's end. */
  std::size_t eventCount() const noexcept;
  const ExerciseEvent& event(std::size_t i) const noexcept;
  /** Events beyond kMaxEvents per tick, of all ticks. */
  std::uint64_t lostEvents() const noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace raven2_trainer::training
