#pragma once

#include <cstdint>

#include "ros/bridge/topic_source.h"
#include "ros/bridge/training_messages.h"
#include "ros/node/outlet.h"

namespace raven2_trainer::ros_bridge {

/** `mode` and `exercise/state`, latched, and `exercise/events`. */
class TrainingTopics {
 public:
  TrainingTopics(const TopicMaker& topics, const TopicSource& source);

  /** Publishes what is new. To be called every runtime.ros_period; one thread. @param[in] model of this cycle. */
  void publish(const ModelState& model, const ros::Time& stamp);

  /** Ticks begin again: all is reported again, but for the events that there are already. */
  void startOver();

 private:
  void publishMode(const ModelState& model, const ros::Time& stamp);
  void publishProgress(const ModelState& model, const ros::Time& stamp);
  void publishEvents(const ros::Time& stamp);

  TopicSource source_;
  Outlet<TrainerMode> mode_;
  Outlet<ExerciseProgress> progress_;
  Outlet<ExerciseEventStamped> events_;
  ModelState published_mode_, published_progress_;  ///< states of the newest messages
  bool has_published_{false};
  std::uint64_t events_published_{0};
};

}  // namespace raven2_trainer::ros_bridge
