#include "raven2_trainer/loop/physics_loop.h"

#include <atomic>

#include "loop/activity/activities.h"
#include "loop/exercise_runner.h"
#include "loop/loop_faults.h"
#include "loop/master_intake.h"
#include "loop/operator_pauses.h"
#include "loop/robot_relay.h"
#include "loop/servo_manager.h"
#include "loop/stage.h"
#include "raven2_trainer/loop/contact_records.h"

namespace raven2_trainer::loop {
/** The parts of a tick, in the order in which it uses them. */
struct PhysicsLoop::Parts {
  Parts(const LoopConfig& config,
        const model::RavenModel& raven,
        const model::SceneModel& scene,
        SharedState* shared_state,
        double trial_limit)
      : shared(*shared_state),
        stage(config, raven, scene, shared_state),
        faults(shared_state),
        servo(config, shared_state),
        intake(&faults, &servo, &stage),
        activities(raven, scene, config.live_camera, trial_limit, &stage),
        relay(&faults, &stage),
        exercise(config, scene, config.live_camera, &stage.arms.world(), shared_state) {}

  void readInputs(std::int64_t now_ns) noexcept;
  void takeRequests() noexcept;
  void take(const Request& request) noexcept;
  PlanningAnswer serve(const Request& request) noexcept;
  PlanningAnswer restartExercise() noexcept;
  bool mayInject() const noexcept;
  faults::FaultCycle faultCycle() const noexcept;
  void timeSlip() noexcept;
  void describe(std::int64_t now_ns) noexcept;
  void listContacts() noexcept;
  void publish() noexcept;

  SharedState& shared;
  Stage stage;
  LoopFaults faults;
  ServoManager servo;
  MasterIntake intake;
  Activities activities;
  RobotRelay relay;
  ExerciseRunner exercise;
  ContactList contacts{};
  std::uint32_t tool_changes{0};
  bool slipped{false};  ///< since the last tick
  std::atomic<bool> pause_requested{false};
};

PhysicsLoop::PhysicsLoop(const LoopConfig& config,
                         const model::RavenModel& raven,
                         const model::SceneModel& scene,
                         SharedState* shared,
                         double trial_limit)
    : parts_(std::make_unique<Parts>(config, raven, scene, shared, trial_limit)) {}

PhysicsLoop::~PhysicsLoop() = default;

void PhysicsLoop::tick(std::int64_t now_ns) noexcept {
  Parts& p = *parts_;
  const bool is_paused = takePauses(p.stage);
  if (p.pause_requested.exchange(false, std::memory_order_relaxed) || is_paused) p.timeSlip();
  // what arrived since the last tick
  p.readInputs(now_ns);
  p.activities.watchRobot();
  p.takeRequests();
  p.activities.takePlans();
  p.activities.supervise();
  p.activities.watchPedal();
  // where the arms shall be, the model follows, the robot gets its packet
  p.stage.state.commands_used = 0;
  p.activities.tick();
  p.activities.move();
  p.relay.tick();
  p.describe(now_ns);
  p.publish();
}

void PhysicsLoop::timeSlip() noexcept {
  parts_->timeSlip();
}

void PhysicsLoop::requestPause() noexcept {
  parts_->pause_requested.store(true, std::memory_order_relaxed);
}

void PhysicsLoop::setSignals(const FaultSignals& signals) noexcept {
  parts_->stage.state.faults.signals = signals;
}

std::uint32_t PhysicsLoop::newestCommand() const noexcept {
  return parts_->intake.newest();
}

const std::vector<std::string>& PhysicsLoop::bodyNames() const noexcept {
  return parts_->stage.arms.world().bodyNames();
}

void PhysicsLoop::Parts::timeSlip() noexcept {
  slipped = true;
  activities.loseTime();
}

// ---- what arrived ------------------------------------------------------------------------------------------------

void PhysicsLoop::Parts::readInputs(std::int64_t now_ns) noexcept {
  faults.read(stage.thisTick());
  stage.robot.hear(shared.robot, now_ns);
  stage.state.robot_fresh = stage.robot.isFresh() ? 1 : 0;
  faults.hold(!mayInject());
  stage.robot.listen();
  intake.tick(activities.leadsToTeleoperation());
}

/** Into what a real robot is sent, only with the second key. Once a robot was there and no virtual one is now, our
 *  packets may reach a real one, whether its state reaches us or not. */
bool PhysicsLoop::Parts::mayInject() const noexcept {
  const RobotTie& robot = stage.robot;
  return stage.config.library.injection.real_robot || !robot.wasHeard() || (robot.isHeard() && robot.state().is_virtual != 0);
}

void PhysicsLoop::Parts::takeRequests() noexcept {
  Request request;
  for (auto* ring : {&shared.pedal_requests, &shared.requests}) {
    while (ring->tryPop(&request))
      take(request);
  }
  while (servo.nextEffort(&request)) {
    shared.efforts_made.add();
    take(request);
  }
}

void PhysicsLoop::Parts::take(const Request& request) noexcept {
  shared.request_records.tryPush({stage.thisTick(), request});
  if (!activities.serve(request)) stage.answers.give(request.id, serve(request));
}

/** Those that are no activity's. */
PlanningAnswer PhysicsLoop::Parts::serve(const Request& request) noexcept {
  switch (request.kind) {
    case RequestKind::kEngage:
      stage.state.engaged = 1;
      return PlanningAnswer::kNone;
    case RequestKind::kDisengage:
      activities.disengage();
      return PlanningAnswer::kNone;
    case RequestKind::kSetCollisions:
      stage.arms.setCollisions(request.arm, request.enabled != 0);
      return PlanningAnswer::kNone;
    case RequestKind::kSetView:
      stage.state.view = request.enabled != 0 ? 1 : 0;
      return PlanningAnswer::kAccepted;
    case RequestKind::kToolChange:  // counted for faults' triggers; an instrument is changed with the pedal up
      if (!stage.pedal.isUp()) return PlanningAnswer::kNotNow;
      ++tool_changes;
      return PlanningAnswer::kAccepted;
    case RequestKind::kStartExercise:
      return restartExercise();
    default:
      return PlanningAnswer::kNotNow;  // nothing that is served here
  }
}

PlanningAnswer PhysicsLoop::Parts::restartExercise() noexcept {
  const bool may_restart = traitsOf(stage.mode()).may_restart && stage.pedal.isUp();
  if (!exercise.hasExercise() || !may_restart) return PlanningAnswer::kNotNow;
  exercise.restart();
  return PlanningAnswer::kAccepted;
}

// ---- what is published --------------------------------------------------------------------------------------------

faults::FaultCycle PhysicsLoop::Parts::faultCycle() const noexcept {
  return {stage.robot.isLinked(), static_cast<int>(stage.robot.state().runlevel), stage.state.faults.signals};
}

void PhysicsLoop::Parts::describe(std::int64_t now_ns) noexcept {
  ModelState& state = stage.state;
  ++state.tick;
  state.time_ns = now_ns;
  state.linked = stage.robot.isLed() ? 1 : 0;
  faults.corruptConsole(faultCycle(), &state.faults);
  faults.publish(state.tick, &state.faults);
  const bool touches = traitsOf(state.mode).world != WorldMotion::kStill;
  for (const Arm arm : kArms)
    stage.arms.describe(arm, touches, &at(state.arms, arm));
  stage.arms.world().bodyPoses(&state.bodies);
  activities.describe(&state);
  listContacts();
  exercise.tick(&state, contacts, activities.rehearses());
}

void PhysicsLoop::Parts::listContacts() noexcept {
  contacts.count = 0;
  contacts.dropped = 0;
  if (traitsOf(stage.mode()).world != WorldMotion::kStill)
    stage.arms.world().contactList(&contacts);  // else those of the last step are long past
  contacts.tick = stage.state.tick;
}

void PhysicsLoop::Parts::publish() noexcept {
  ModelState& state = stage.state;
  servo.publish(state.tick, state.time_ns, relay.setPoints());
  shared.model.store(state);
  shared.contacts.store(contacts);
  shared.contacts_dropped.add(contacts.dropped);
  if (contacts.count > 0)
    forEachPair(contacts, [this](const ContactRecord& record) { shared.contact_records.tryPush(record); });
  shared.tick_records.tryPush({state, stage.robot.state(), static_cast<std::uint8_t>(slipped ? 1 : 0)});
  slipped = false;
  if (state.session_tick >= 0 && state.mode != Mode::kPaused) ++state.session_tick;
  if (exercise.hasExercise()) state.faults.signals = exercise.signals();
  if (tool_changes > 0) state.faults.signals.tool_changes = tool_changes;  // what the next tick's triggers see
}

}  // namespace raven2_trainer::loop
