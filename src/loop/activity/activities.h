#pragma once

#include <array>

#include "loop/activity/camera.h"
#include "loop/activity/execution.h"
#include "loop/activity/goal_selection.h"
#include "loop/activity/hold.h"
#include "loop/activity/planning.h"
#include "loop/activity/replay.h"
#include "loop/activity/returning.h"
#include "loop/activity/teleoperation.h"
#include "loop/activity/trial.h"
#include "loop/servo_manager.h"

namespace raven2_trainer::loop {

/** All activities, and the mode: events from robot, pedal, requests and activities change it by control/mode_table.h.
 * One thread; real-time safe but for the constructor. */
class Activities final : public ModeMachine {
 public:
  /** @param[in] trial_limit [s]. @throw ModelException for a collision shape that is a mesh. */
  Activities(const model::RavenModel& raven,
             const model::SceneModel& scene,
             const CameraConfig& live_camera,
             double trial_limit,
             Stage* stage);

  /** A tick's steps, in this order: what the robot's state means; what clients, pedals and the planner ask for; what is
   *  over; the pedal. Then the mode is the tick's. */
  void watchRobot() noexcept;
  /** @return whether the request is an activity's, and was served. */
  bool serve(const Request& request) noexcept;
  void takePlans() noexcept;
  void supervise() noexcept;
  void watchPedal() noexcept;
  /** Where the arms shall be; and the model's step. */
  void tick() noexcept { current().tick(); }
  void move() noexcept { current().move(); }

  /** No more increments go to the robot until the next pedal-down. */
  void disengage() noexcept;
  /** Simulated time was given up. */
  void loseTime() noexcept;
  /** Writes their part of the state at the end of a tick. */
  void describe(ModelState* state) noexcept;
  /** Whether everything now will be undone. */
  bool rehearses() const noexcept { return trial_.rehearses(); }
  /** A pedal-down leads to teleoperation, now or once the robot is ready. */
  bool leadsToTeleoperation() const noexcept;

  void raise(control::Event event) noexcept override;
  PlanningAnswer ask(control::Event event) noexcept override;

 private:
  Activity& current() noexcept { return *all_[static_cast<std::size_t>(traitsOf(stage_.mode()).activity)]; }
  Activity* serverOf(RequestKind kind) noexcept;
  void enter(Mode next) noexcept;
  void link(Moves moves) noexcept;
  void watchRunLevel() noexcept;
  bool waitsForReturn() noexcept;

  Stage& stage_;
  Hold hold_;
  Teleoperation teleoperation_;
  Planning planning_;
  GoalSelection goal_selection_;
  Trial trial_;
  Execution execution_;
  Returning returning_;
  Replay replay_;
  Camera camera_;
  std::array<Activity*, kActivityCount> all_;  ///< by ActivityKind
};

}  // namespace raven2_trainer::loop
