#pragma once

#include "loop/answers.h"
#include "loop/increments.h"
#include "loop/model_arms.h"
#include "loop/robot_tie.h"
#include "raven2_trainer/control/mode_table.h"
#include "raven2_trainer/loop/loop_config.h"
#include "raven2_trainer/loop/shared_state.h"

namespace raven2_trainer::loop {

/** The pedal that engages, the surgeon's or a CRTK client's. */
struct EngagingPedal {
  bool is_down{false};
  bool was_down{false};    ///< as the modes have seen it so far
  bool is_clients{false};  ///< the newest command was a CRTK client's pedal-down

  bool isUp() const noexcept { return !is_down && !was_down; }
  /** ModelState::pedal. */
  std::uint8_t held() const noexcept { return !is_down ? 0 : is_clients ? kClientsPedal : kSurgeonsPedal; }
};

/** Changes the mode. */
class ModeMachine {
 public:
  virtual void raise(control::Event event) noexcept = 0;
  /** @return whether the event changed anything. */
  virtual PlanningAnswer ask(control::Event event) noexcept = 0;

 protected:
  ~ModeMachine() = default;
};

/** Data that the activities of one physics loop share. One thread. */
struct Stage {
  Stage(const LoopConfig& configuration,
        const model::RavenModel& raven,
        const model::SceneModel& scene,
        SharedState* shared_state);

  const LoopConfig config;
  SharedState& shared;
  ModelArms arms;
  RobotTie robot;
  Answers answers;
  ModelState state{};
  EngagingPedal pedal{};
  Increments increments{};
  bool stop_asked{false};        ///< by request or pedal, and not cleared
  bool stopped_by_robot{false};  ///< its run level fell to E-STOP
  ModeMachine* modes{nullptr};   ///< set once all activities are there

  Mode mode() const noexcept { return state.mode; }
  Tick thisTick() const noexcept { return state.tick + 1; }
  /** With the pedal up, and no robot that still has to be homed. */
  bool mayBegin() const noexcept { return pedal.isUp() && !robot.isNotReady(); }
  /** The robot is there to follow. */
  bool robotJoins() const noexcept { return robot.isThere() && state.engaged != 0; }
  /** The model is away from a robot that is there. */
  bool mustReturn() const noexcept { return arms.isApart() && robot.isThere(); }
  /** There is a robot, and it is not where the model is, or was. @param[in] from [rad; m] */
  bool isAstray(const PerArm<JointArray>& from) const noexcept;
  /** Applies this tick's motion of the hands. */
  void useCommands() noexcept;
};

}  // namespace raven2_trainer::loop
