#pragma once

#include <functional>
#include <memory>

#include "raven2_trainer/config/trainer_config.h"
#include "raven2_trainer/loop/shared_state.h"
#include "raven2_trainer/model/raven_model.h"
#include "raven2_trainer/session/replay_timeline.h"
#include "raven2_trainer/session/session_directory.h"
#include "raven2_trainer/session/session_log.h"
#include "ros/bridge/state_topics.h"

namespace raven2_trainer::ros_bridge {

/**
 * Publishes a recorded session as the daemon's topics of states (StateTopics), an instant every runtime.ros_period: to
 * ROS, or into a bag. A log has no pictures, no diagnostics and no counters of the planner (zero in plan/progress), so
 * they are not published.
 */
class SessionPublisher {
 public:
  /**
   * @param[in] config with the arms, the scene and the exercise of the session.
   * @throw SessionException for a log that cannot be read; ConfigException if its robot is not `config`'s.
   */
  SessionPublisher(const TrainerConfig& config, const session::SessionPaths& paths);

  /** Makes the topics, and publishes /tf_static. They exist until end(). */
  void begin(const TopicMaker& topics, std::uint32_t queue, const ros::Time& now);
  void end() { topics_.reset(); }

  /** Another run begins. */
  void startOver();
  void publish(const session::ReplayInstant& instant, const ros::Time& stamp);
  /** Without publishing it: new plans and events are published with the next. */
  void remember(const session::ReplayInstant& instant);

  /**
   * Reads the log. @param[in] from [s] session time of the first instant; negative: the log's first tick.
   * @param[in] use Given each instant. @param[in] on_tick Given each tick as it is read, before instants of that tick;
   * may be empty. An exception of theirs ends the reading. @throw SessionException.
   */
  void read(double from,
            const std::function<void(const session::ReplayInstant&)>& use,
            const std::function<void(const TickRecord&)>& on_tick = {}) const;

  const session::LogHeader& header() const noexcept { return header_; }
  const TrainerConfig& config() const noexcept { return config_; }

 private:
  const TrainerConfig config_;
  const session::SessionPaths paths_;
  const session::LogHeader header_;
  const model::RavenModel raven_;
  std::unique_ptr<SharedState> shared_;  ///< its own
  ExerciseNews events_;
  std::unique_ptr<StateTopics> topics_;
};

}  // namespace raven2_trainer::ros_bridge
