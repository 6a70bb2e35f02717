#include "ros/bridge/training_topics.h"

#include "ros/node/topic.h"

namespace raven2_trainer::ros_bridge {
namespace {

constexpr Tick kPeriod = 100;               // [1 ms] enough for a clock and a bar that move
constexpr std::uint32_t kEventQueue = 256;  // as many as four cycles can bring (ExerciseNews::kKept)

}  // namespace

TrainingTopics::TrainingTopics(const TopicMaker& topics, const TopicSource& source)
    : source_(source),
      mode_(topics.advertise<TrainerMode>("mode", kQueue, kLatched)),
      progress_(topics.advertise<ExerciseProgress>("exercise/state", kQueue, kLatched)),
      events_(topics.advertise<ExerciseEventStamped>("exercise/events", kEventQueue)) {}

void TrainingTopics::publish(const ModelState& model, const ros::Time& stamp) {
  publishMode(model, stamp);
  publishEvents(stamp);
  publishProgress(model, stamp);
  has_published_ = true;
}

void TrainingTopics::startOver() {
  has_published_ = false;
  events_published_ = source_.shared.exercise_news.load().count;
}

void TrainingTopics::publishMode(const ModelState& model, const ros::Time& stamp) {
  const bool is_due = model.mode == Mode::kTrial && model.tick - published_mode_.tick >= kPeriod;
  if (has_published_ && !is_due && isSameMode(model, published_mode_)) return;
  published_mode_ = model;
  mode_.publish(trainerMode(model, stamp));
}

void TrainingTopics::publishProgress(const ModelState& model, const ros::Time& stamp) {
  const bool is_running = model.exercise.status == ExerciseStatus::kRunning;
  const bool is_due = is_running && model.tick - published_progress_.tick >= kPeriod;
  if (has_published_ && !is_due && isSameProgress(model.exercise, published_progress_.exercise)) return;
  published_progress_ = model;
  progress_.publish(exerciseProgress(model, source_.exercise, stamp));
}

void TrainingTopics::publishEvents(const ros::Time& stamp) {
  const ExerciseNews news = source_.shared.exercise_news.load();
  for (std::uint64_t n = news.firstAfter(events_published_); n <= news.count; ++n) {
    const ExerciseRecord& record = news.newest[n % ExerciseNews::kKept];
    events_.publish(exerciseEvent(n, record, source_.exercise, source_.body_names, stamp));
  }
  events_published_ = news.count;
}

}  // namespace raven2_trainer::ros_bridge
