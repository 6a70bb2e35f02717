#pragma once

#include "loop/activity/activity.h"
#include "raven2_trainer/loop/replay_frame.h"

namespace raven2_trainer::loop {

/** Shows a recorded session, kinematically, from a ring that recording/session_player.h fills. The world is paused
 * meanwhile, and continues unchanged. */
class Replay final : public Activity {
 public:
  explicit Replay(Stage* stage) noexcept : Activity(stage) {}

  /** The bodies' poses that are shown. */
  const ReplayFrame& shown() const noexcept { return shown_; }

  void leave(Mode next) noexcept override;
  void supervise() noexcept override;
  void move() noexcept override;
  PlanningAnswer request(const Request& request) noexcept override;

 private:
  PlanningAnswer begin(const Request& request) noexcept;
  bool isOver() noexcept;

  std::uint32_t number_{0};  ///< Request::plan of the newest replay
  ReplayFrame shown_{};
  PerArm<JointArray> stood_q_{}, stood_dq_{};  ///< before it
};

}  // namespace raven2_trainer::loop
