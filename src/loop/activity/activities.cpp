#include "loop/activity/activities.h"

#include "raven2_trainer/core/pedals.h"

namespace raven2_trainer::loop {

using control::Event;

Activities::Activities(const model::RavenModel& raven,
                       const model::SceneModel& scene,
                       const CameraConfig& live_camera,
                       double trial_limit,
                       Stage* stage)
    : stage_(*stage),
      hold_(stage),
      teleoperation_(stage),
      planning_(raven, scene, stage),
      goal_selection_(&planning_, stage),
      trial_(raven, scene, trial_limit, stage),
      execution_(&planning_, &trial_, stage),
      returning_(stage->config.planner, &trial_, stage),
      replay_(stage),
      camera_(live_camera, stage),
      all_{&execution_,      &trial_,     &planning_, &hold_,  &teleoperation_,
           &goal_selection_, &returning_, &replay_,   &camera_} {
  stage->modes = this;
}

// ---- the mode ----------------------------------------------------------------------------------------------------

void Activities::raise(Event event) noexcept {
  const Mode next = control::nextMode(stage_.mode(), event);
  if (next == stage_.mode()) return;
  for (Activity* each : all_)
    each->settle(next, event);
  enter(next);
  if (next == Mode::kPedalUp && stage_.mustReturn()) raise(Event::kReturnWanted);
  trial_.endRehearsal();
}

PlanningAnswer Activities::ask(Event event) noexcept {
  const Mode before = stage_.mode();
  raise(event);
  return stage_.mode() != before ? PlanningAnswer::kAccepted : PlanningAnswer::kNotNow;
}

void Activities::enter(Mode next) noexcept {
  const Mode before = stage_.mode();
  current().leave(next);
  stage_.state.mode = next;
  const ModeTraits traits = traitsOf(next);
  link(traits.moves);
  current().enter(before);
  if (traits.begins && stage_.state.session_tick < 0) stage_.state.session_tick = 0;
}

/** Model and robot start from one pose; where no robot joins, the model goes on alone. */
void Activities::link(Moves moves) noexcept {
  const bool is_the_robots = moves == Moves::kBoth || (moves == Moves::kBothIfAsked && execution_.movesRobot());
  stage_.robot.link(is_the_robots && stage_.robotJoins());
  const bool is_linked = stage_.robot.isLinked();
  if (is_linked) stage_.arms.join(stage_.robot.joints());
  if (moves == Moves::kModel || (mayMoveRobot(moves) && !is_linked)) stage_.arms.leaveRobot();
}

// ---- what changes it ---------------------------------------------------------------------------------------------

void Activities::watchRobot() noexcept {
  RobotTie& robot = stage_.robot;
  if (!stage_.arms.world().healthy()) raise(Event::kEmergencyStop);
  robot.forgetOld();
  if (robot.wasThere() && !robot.isReady()) execution_.loseRobot();  // a new one may be ready within this tick
  if (robot.isFresh()) watchRunLevel();
  if (robot.wasThere() && robot.isReady() && robot.isLost()) execution_.loseRobot();
  robot.remember();
}

void Activities::watchRunLevel() noexcept {
  RobotTie& robot = stage_.robot;
  if (robot.isReady() && robot.isStopped()) {
    stage_.stopped_by_robot = true;  // also behind a stop of ours, which then does not end it
    raise(Event::kEmergencyStop);
  } else if (stage_.stopped_by_robot && robot.state().runlevel >= RunLevel::kPedalUp) {
    stage_.stopped_by_robot = false;
    if (!stage_.stop_asked) raise(Event::kStopCleared);
  }
  if (robot.becomesReady()) raise(Event::kRobotReady);
}

bool Activities::serve(const Request& request) noexcept {
  Activity* const server = serverOf(request.kind);
  if (server != nullptr) stage_.answers.give(request.id, server->request(request));
  return server != nullptr;
}

Activity* Activities::serverOf(RequestKind kind) noexcept {
  switch (kind) {
    case RequestKind::kPlan:
      return &planning_;
    case RequestKind::kBeginPlanning:
    case RequestKind::kRecordGoal:
    case RequestKind::kEndPlanning:
      return &goal_selection_;
    case RequestKind::kExecutePlan:
    case RequestKind::kCancelPlan:
      return &execution_;
    case RequestKind::kBeginSimulation:
    case RequestKind::kEndSimulation:
    case RequestKind::kSetEffort:
      return &teleoperation_;
    case RequestKind::kBeginTrial:
    case RequestKind::kEndTrial:
    case RequestKind::kDiscardTrial:
    case RequestKind::kRepeatTrial:
      return &trial_;
    case RequestKind::kEmergencyStop:
    case RequestKind::kClearStop:
      return &hold_;
    case RequestKind::kBeginReplay:
    case RequestKind::kEndReplay:
      return &replay_;
    case RequestKind::kSetCameraPedal:
      return &camera_;
    default:
      return nullptr;
  }
}

void Activities::takePlans() noexcept {
  planning_.takeResults();
  planning_.planBySchedule();
}

/** One may hand over to another, which looks in the same tick whether it is over, too. */
void Activities::supervise() noexcept {
  for (Activity* each : all_) {
    if (each == &current()) each->supervise();
  }
}

void Activities::watchPedal() noexcept {
  EngagingPedal& pedal = stage_.pedal;
  const bool pressed = pedal.is_down && !pedal.was_down;
  const bool released = !pedal.is_down && pedal.was_down;
  // Asked again next tick: the pedal counts once the robot is homed, and the model back on it.
  if (pressed && (stage_.robot.isNotReady() || waitsForReturn())) return;
  pedal.was_down = pedal.is_down;
  stage_.state.pedal = pedal.held();
  if (pressed && current().press()) raise(Event::kPedalPressed);
  if (!released) return;
  current().release();
  raise(Event::kPedalReleased);
}

/** A pedal-down has to wait until the model is back on the robot. If the model is not on its path there yet, it starts.
 */
bool Activities::waitsForReturn() noexcept {
  if (stage_.mustReturn()) raise(Event::kReturnWanted);
  return stage_.mode() == Mode::kReturning;
}

void Activities::disengage() noexcept {
  stage_.state.engaged = 0;
  execution_.giveUp(ExecutionEnd::kCancelled);
  stage_.robot.unlink();
}

void Activities::loseTime() noexcept {
  stage_.robot.unlink();
  raise(Event::kTimeSlip);
  planning_.store().forget();
}

// ---- what is published --------------------------------------------------------------------------------------------

bool Activities::leadsToTeleoperation() const noexcept {
  const Mode mode = stage_.mode();
  return mode == Mode::kTeleoperating || (mode == Mode::kReturning && !execution_.repeats()) ||
         control::nextMode(mode, Event::kPedalPressed) == Mode::kTeleoperating;
}

void Activities::describe(ModelState* state) noexcept {
  state->planning = trial_.store().overlay(planning_.store().state());
  stage_.answers.show(&state->planning);
  state->guide_plan = planning_.store().guidePlan();
  trial_.keep();
  state->trial_ticks = trial_.store().ticks();
  state->camera = camera_.state();
  state->pedals = state->mode == Mode::kCameraMoving ? bit(Pedal::kCamera) : 0;
  if (state->mode == Mode::kReplaying) state->bodies = replay_.shown().bodies_W;
}

}  // namespace raven2_trainer::loop
