#include "loop/exercise_runner.h"

namespace raven2_trainer::loop {

ExerciseRunner::ExerciseRunner(const LoopConfig& config,
                               const model::SceneModel& scene,
                               const CameraConfig& camera,
                               physics::RavenWorld* world,
                               SharedState* shared)
    : world_(*world), shared_(*shared) {
  if (config.exercise.tracks.empty()) return;
  judge_ = std::make_unique<training::ExerciseJudge>(config.exercise, config.roles, scene, config.arms, camera,
                                                     world->bodyNames());
  world_.saveScene(&at_first_);
  judge_->start();
}

void ExerciseRunner::restart() noexcept {
  if (judge_ == nullptr) return;
  world_.restoreScene(at_first_);
  judge_->start();
}

void ExerciseRunner::tick(ModelState* state, const ContactList& contacts, bool is_rehearsal) noexcept {
  if (judge_ == nullptr) return;
  judge_->setRehearsal(is_rehearsal);
  judge_->tick(*state, contacts, world_.brokenOff());
  state->exercise = judge_->state();
  const std::uint16_t parked = world_.parked();
  for (std::size_t i = 0; i < state->exercise.bodies.size(); ++i) {
    if ((parked >> i & 1U) != 0) state->exercise.bodies[i] |= kBodyParked;
  }
  if (judge_->eventCount() > 0) publish(state->tick);
  const std::uint64_t lost = judge_->lostEvents();
  if (lost != lost_) shared_.exercise_records.drop(lost - lost_);
  lost_ = lost;
}

void ExerciseRunner::publish(Tick tick) noexcept {
  for (std::size_t i = 0; i < judge_->eventCount(); ++i) {
    const ExerciseRecord record{tick, judge_->event(i)};
    shared_.exercise_records.tryPush(record);
    news_.add(record);
  }
  shared_.exercise_news.store(news_);
}

}  // namespace raven2_trainer::loop
