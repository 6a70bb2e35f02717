#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "raven2_trainer/config/trainer_config.h"
#include "raven2_trainer/ros/ros_face.h"
#include "raven2_trainer/session/session_directory.h"

namespace raven2_trainer::ros_bridge {

struct SessionReplayOptions {
  double rate{1.0};          ///< [-] of the session's time to the wall's
  double from{-1.0};         ///< [s] session time of the first message; negative: the log's first tick
  bool loop{false};          ///< begins again at the end
  bool set_sim_time{false};  ///< sets /use_sim_time where it is not set
};

/**
 * Plays a recorded session into ROS: the daemon's topics of states (StateTopics), a message of each every
 * runtime.ros_period of the session, and /clock. All have the stamps of the log: the daemon's CLOCK_MONOTONIC of the
 * tick, or in lockstep tick x 1 ms. A gap of ticks longer than a second is skipped.
 *
 * Subscribers must use /clock: without the parameter /use_sim_time nothing is played. A log has no pictures, no
 * diagnostics and no counters of the planner (zero in plan/progress), so they are not published.
 */
class SessionReplay : public RosFace {
 public:
  /**
   * @param[in] config with the arms, the scene and the exercise of the session.
   * @throw SessionException for a log that cannot be read; ConfigException if its robot is not `config`'s.
   */
  SessionReplay(const TrainerConfig& config, const session::SessionPaths& paths, const SessionReplayOptions& options);
  ~SessionReplay() override;
  SessionReplay(const SessionReplay&) = delete;
  SessionReplay& operator=(const SessionReplay&) = delete;

  void start() override;
  void stop() override;
  std::vector<std::string> services() const override { return {}; }

  /** After start(): whether /use_sim_time is not set, so that nothing can be played and there are no topics. Any
   * thread. */
  bool isRefused() const noexcept;

  /**
   * Plays until the end of the log, or for ever. Between start() and stop(), unless isRefused().
   * @param[in] wait Waits so many seconds, zero included; true: end now.
   * @return instants published. @throw SessionException if the log cannot be read.
   */
  std::uint64_t play(const std::function<bool(double)>& wait);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace raven2_trainer::ros_bridge
