#pragma once

#include "raven2_trainer/training/exercise_judge.h"
#include "raven2_trainer/training/tissue_distance.h"
#include "training/reach_search.h"
#include "training/scene_senses.h"
#include "training/touch_watch.h"
#include "training/track_runner.h"

namespace raven2_trainer::training {

/** History of one object. */
struct ObjectStory {
  PerArm<bool> held{};         ///< at the end of the last tick
  std::int32_t lifted{0};      ///< [ticks] of this hold
  std::int64_t verdict{-1};    ///< [ticks] until it is known whether it was dropped; -1 it is not in question
  std::int32_t rested{0};      ///< [ticks] let alone and at rest
  Vector3 reachable{0, 0, 0};  ///< [m] where it lay when it was known to be in reach
};

struct ExerciseJudge::Impl {
  Impl(const Exercise& e,
       const SceneRoles& roles,
       const model::SceneModel& scene_model,
       const ArmsConfig& arms,
       const CameraConfig& camera,
       const std::vector<std::string>& body_names);

  void begin() noexcept;
  void tick(const ModelState& model, const ContactList& contacts, BrokenOff broken) noexcept;
  void judge(const ModelState& model, const ContactList& contacts) noexcept;
  void suspend() noexcept;
  void watchHolds() noexcept;
  void takeHold(std::size_t object, std::size_t arm, bool held) noexcept;
  void watchBreaking(BrokenOff broken) noexcept;
  void markBroken(BrokenOff broken) noexcept;
  bool hasBegun(const ModelState& model) const noexcept;
  void countTime() noexcept;
  void watchTouches(const ContactList& contacts) noexcept;
  void reportTouches() noexcept;
  void countTouches() noexcept;
  void watchDrops() noexcept;
  void watchDrop(std::size_t object) noexcept;
  bool belongsWhereItIs(std::size_t object) const noexcept;
  void runTracks() noexcept;
  bool hasTurn(const TrackRunner& track) const noexcept;
  void watchLost() noexcept;
  void considerLost(std::size_t object) noexcept;
  void end(ExerciseStatus status, ExerciseFailure failure) noexcept;
  void measure(const ModelState& model) noexcept;
  double targetDistance() const noexcept;

  int ruleOf(Mistake kind) const noexcept;
  void count(int rule, std::uint16_t a, std::uint16_t b, Hand arm) noexcept;
  void push(const ExerciseEvent& event) noexcept;
  void push(ExerciseEventKind kind) noexcept;
  bool isRunning() const noexcept { return state.status == ExerciseStatus::kRunning; }
  bool isOpen() const noexcept { return isRunning() || state.status == ExerciseStatus::kWaiting; }

  const Exercise exercise;
  const JudgeScene scene;
  SceneSenses senses;
  TouchWatch touches;
  ReachSearch reach;
  TissueDistance tissue;
  std::vector<TrackRunner> tracks;
  std::vector<std::uint32_t> rule_counts;
  std::array<ObjectStory, kMaxSceneBodies> objects{};
  std::array<ExerciseEvent, kMaxEvents> events{};
  std::size_t event_count{0};
  std::uint64_t lost_events{0};
  ExerciseState state{};
  FaultSignals signals{};
  Tick now{0};
  std::int64_t elapsed{0};  ///< [ticks] on the timer
  std::int64_t time_limit;  ///< [ticks]
  std::size_t searched{0};  ///< object that `reach` is busy with
  std::uint16_t broken_seen{0};
  bool start_wanted{false}, give_up_wanted{false}, is_suspended{false}, is_rehearsal{false};
};

}  // namespace raven2_trainer::training
