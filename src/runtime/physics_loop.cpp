#include "raven2_trainer/runtime/physics_loop.h"

#include <algorithm>
#include <cmath>

#include "raven2_trainer/core/pedals.h"
#include "raven2_trainer/faults/packet_faults.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"
#include "raven2_trainer/runtime/contact_records.h"

namespace raven2_trainer::runtime {
namespace {

using control::Event;
using kinematics::IkStatus;

constexpr double kNanoseconds = 1e9;

// A link silent for this long is lost: model and robot must start again from a common pose. Shorter gaps only
// silence the cue (stale_after); a busy host stalls for some tens of milliseconds now and then.
constexpr double kLostAfter = 0.5;

Vec3 sum(const Vec3& a, const Vec3& b) noexcept {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}

Quat product(const Quat& later, const Quat& earlier) noexcept {
  if (later == kIdentityQuat) return earlier;  // exact, and the common case
  return toArray((toEigen(later) * toEigen(earlier)).normalized());
}

/** The masters move the arms. */
bool isTold(Mode mode) noexcept {
  return mode == Mode::kTeleoperating || mode == Mode::kSimulating || mode == Mode::kTrial;
}

/** The world stands still, but for what is shown kinematically. */
bool isShown(Mode mode) noexcept {
  return mode == Mode::kChoosing || mode == Mode::kReplaying;
}

/** The one through which the surgeon looks. */
const CameraConfig& liveCamera(const RenderConfig& render) {
  for (const CameraConfig& camera : render.cameras) {
    if (camera.name == render.live_camera) return camera;
  }
  return render.cameras.front();
}

/** What a fault made of a turn may be no turn: then there is none. */
Quat unitOrNone(const Quat& q) noexcept {
  const double norm = toEigen(q).norm();
  return norm > 1e-6 && std::isfinite(norm) ? toArray(toEigen(q).normalized()) : kIdentityQuat;
}

}  // namespace

PhysicsLoop::PhysicsLoop(const TrainerConfig& config,
                         const model::RavenModel& raven,
                         const model::SceneModel& scene,
                         SharedState* shared,
                         double trial_limit)
    : config_(config),
      shared_(*shared),
      world_(raven, scene, config.model),
      mappers_{control::TeleopMapper(config.arms.geometry, Arm::kGold),
               control::TeleopMapper(config.arms.geometry, Arm::kGreen)},
      driver_(config.model, config.arms.geometry, &world_),
      desk_(config, raven, scene, shared),
      trial_(config, raven, scene, shared, trial_limit),
      return_(config.planner.velocity_limit, config.planner.acceleration_limit),
      camera_(liveCamera(config.render)),
      exercise_(config, scene, liveCamera(config.render), &world_, shared),
      servo_(config, shared),
      stale_ns_(static_cast<std::int64_t>(config.network.stale_after * kNanoseconds)),
      lost_ns_(static_cast<std::int64_t>(kLostAfter * kNanoseconds)),
      silence_limit_(static_cast<Tick>(std::llround(config.network.itp.pedalTimeout() / kTickSeconds))) {
  for (const Arm arm : kArms) {
    at(q_d_, arm) = config.arms.geometry.home;
    world_.setJointState(arm, config.arms.geometry.home, JointArray{});
    at(collisions_, arm) = at(config.model.arm_contacts, arm);
  }
  if (config.execution.drive == ExecutionDrive::kOpenLoop) driver_.allowOpenLoop(raven, config.model);
}

void PhysicsLoop::tick(std::int64_t now_ns) noexcept {
  // what arrived since the last tick
  if (pause_requested_.exchange(false, std::memory_order_relaxed)) timeSlip();
  readInputs(now_ns);
  updateRobotEvents();
  drainRequests();
  scheduledPlan();
  superviseExecution();
  superviseTrial();
  superviseReturn();
  superviseReplay();
  updatePedal();
  // where the arms shall be
  updateTargets();
  // the model follows, the robot is told
  moveModel();
  relay();
  publish(now_ns);
}

void PhysicsLoop::readInputs(std::int64_t now_ns) noexcept {
  readFaults();
  shared_.robot.tryLoad(&robot_);
  const std::int64_t age = now_ns - robot_.received_ns;
  const bool has_robot = hasRobot();
  relay_started_ = relay_started_ || has_robot;
  holdFaults();
  state_.robot_fresh = has_robot && age <= stale_ns_ ? 1 : 0;
  robot_silent_ = age > lost_ns_;
  if (isRobotLost()) linked_ = false;
  listenToRobot();
  drainCommands();
}

void PhysicsLoop::readFaults() noexcept {
  FaultPlan plan;
  if (!shared_.faults.tryLoad(&plan)) return;
  relay_faults_.setPlan(plan);
  master_faults_.setPlan(plan);
  console_faults_.setPlan(plan);
  if (plan.generation == fault_generation_) return;
  fault_generation_ = plan.generation;
  shared_.fault_records.tryPush({state_.tick + 1, plan});
}

void PhysicsLoop::drainCommands() noexcept {
  increments_ = Increments{};
  if (++silent_ticks_ >= silence_limit_) pedal_ = false;
  master_faults_.beginCycle({pedal_, static_cast<int>(robot_.runlevel), state_.faults.signals});
  drainConsole();
  serveClients();
  takeHeldCommands();
}

void PhysicsLoop::consume(const MasterCommand& command) noexcept {
  shared_.command_records.tryPush({state_.tick + 1, command});
  for (const Arm arm : kArms) {  // where the hands really are
    if (command.pedal != kClientsPedal) at(state_.master_I, arm) = sum(at(state_.master_I, arm), at(command.dp_I, arm));
  }
  master_faults_.beginPacket(command.pedal != 0);
  corruptMaster(command);
}

void PhysicsLoop::corruptMaster(const MasterCommand& command) noexcept {
  if (!master_faults_.isArmed() && master_stream_.isEmpty()) {
    master_stream_.pass(command);
    takeCommand(command);
    return;
  }
  master_stream_.offer(command, &master_faults_);
  takeHeldCommands();
}

void PhysicsLoop::takeHeldCommands() noexcept {
  MasterCommand command;
  while (master_stream_.take(&command, master_faults_)) {
    faults::applyToCommand(&master_faults_, &command);
    for (Quat& dq : command.dq_I)
      dq = unitOrNone(dq);
    takeCommand(command);
  }
}

void PhysicsLoop::takeCommand(const MasterCommand& command) noexcept {
  pedal_ = command.pedal != 0;
  is_clients_ = command.pedal == kClientsPedal;
  silent_ticks_ = 0;
  increments_.last_sequence = command.sequence;
  ++increments_.commands;
  if (!pedal_ && state_.mode != Mode::kCameraMoving) return;  // the camera has a pedal of its own
  for (const Arm arm : kArms) {
    at(increments_.dp_I, arm) = sum(at(increments_.dp_I, arm), at(command.dp_I, arm));
    at(increments_.dq_I, arm) = product(at(command.dq_I, arm), at(increments_.dq_I, arm));
    at(increments_.dgrasp, arm) += at(command.dgrasp, arm);
  }
}

/** Into what a real robot is sent, only with the second key. Once a robot was there and no virtual one is now, our
 *  packets may reach a real one, whether its state reaches us or not. */
bool PhysicsLoop::mayInject() const noexcept {
  return config_.injection.real_robot || !relay_started_ || (hasRobot() && robot_.is_virtual != 0);
}

void PhysicsLoop::holdFaults() noexcept {
  const bool is_held = !mayInject();
  for (faults::FaultEngine* engine : {&relay_faults_, &master_faults_, &console_faults_})
    engine->hold(is_held);
  if (!is_held) return;
  master_stream_.clear();  // what a fault held back of a virtual robot's is not for a real one
  relay_stream_.clear();
}

/** Beginnings and ends since the last tick: the robot's as they came, and our own. */
void PhysicsLoop::tellFaultChanges() noexcept {
  FaultChange change;
  while (shared_.fault_changes.tryPop(&change))
    shared_.change_records.tryPush({state_.tick, change});
  for (faults::FaultEngine* engine : {&relay_faults_, &master_faults_, &console_faults_}) {
    while (engine->nextChange(&change)) {
      change.cycle = static_cast<std::uint64_t>(state_.tick);
      shared_.change_records.tryPush({state_.tick, change});
    }
  }
  const std::uint64_t untold =
      relay_faults_.changesUntold() + master_faults_.changesUntold() + console_faults_.changesUntold();
  if (untold > changes_untold_) shared_.fault_changes_untold.add(untold - changes_untold_);
  changes_untold_ = untold;
}

/** What faults made of packets. */
void PhysicsLoop::countFaultedPackets() noexcept {
  shared_.master_faults.store(master_stream_.counts());
  shared_.relay_faults.store(relay_stream_.counts());
}

/** Whether this tick may take one more. After a stall many wait: together they would be a jump, to the model as to the
 *  robot, which refuses in one packet what one packet may not hold. The ticks that catch up take the rest. */
bool PhysicsLoop::fits(const MasterCommand& command) const noexcept {
  if (increments_.commands == 0 || command.pedal == 0) return true;
  if (!pedal_) return false;  // a press after a release: in one tick nobody would see that the pedal was up
  const ItpRules& rules = config_.network.itp;
  for (const Arm arm : kArms) {
    for (const double dp : sum(at(increments_.dp_I, arm), at(command.dp_I, arm))) {
      if (std::abs(dp) > rules.max_increment_um * 1e-6) return false;
    }
    const Quat turned = product(at(command.dq_I, arm), at(increments_.dq_I, arm));
    if (2.0 * std::acos(std::min(1.0, std::abs(toEigen(turned).w()))) > rules.max_rotation) return false;
  }
  return true;
}

void PhysicsLoop::drainRequests() noexcept {
  Request request;
  for (auto* ring : {&shared_.pedal_requests, &shared_.requests}) {
    while (ring->tryPop(&request)) {
      shared_.request_records.tryPush({state_.tick + 1, request});
      handleRequest(request);
    }
  }
  while (servo_.nextEffort(&request)) {
    shared_.efforts_made.add();
    shared_.request_records.tryPush({state_.tick + 1, request});
    handleRequest(request);
  }
  PlanResult result;
  while (shared_.plan_results.tryPop(&result))
    handlePlanResult(result);
}

void PhysicsLoop::handleRequest(const Request& request) noexcept {
  switch (request.kind) {
    case RequestKind::kEngage:
      state_.engaged = 1;
      break;
    case RequestKind::kDisengage:
      state_.engaged = 0;
      if (state_.mode == Mode::kArmed) disarm(ExecutionEnd::kCancelled);
      if (state_.mode == Mode::kExecuting) endExecution(ExecutionEnd::kCancelled);
      linked_ = false;  // to engage again takes a new pedal-down from a common pose
      break;
    case RequestKind::kPlan:
      requestPlan(request);
      break;
    case RequestKind::kCancelPlan:
      cancelPlan(request);
      break;
    case RequestKind::kBeginPlanning:
      beginChoosing(request);
      break;
    case RequestKind::kRecordGoal:
      recordGoal(request);
      break;
    case RequestKind::kEndPlanning:
      endChoosing(request);
      break;
    case RequestKind::kExecutePlan:
      armPlan(request);
      break;
    case RequestKind::kSetEffort:
      pushModel(request);
      break;
    case RequestKind::kSetCollisions:
      at(collisions_, request.arm) = request.enabled != 0;
      break;
    default:
      serveTraining(request);
      break;
  }
}

void PhysicsLoop::updateTargets() noexcept {
  state_.commands_used = 0;
  if (state_.mode == Mode::kTracking && follower_.active()) aimAtPath(follower_.arm(), follower_.tick());
  if (state_.mode == Mode::kChoosing) moveGoal();
  if (state_.mode == Mode::kCameraMoving) moveCamera();
  if (isTold(state_.mode) && robotApplies()) return aimAsTold();
  dropMotion();
  if (state_.mode == Mode::kExecuting) trial_.isUnderWay() ? repeat() : execute();
}

/** What the masters moved in this tick moves nothing. */
void PhysicsLoop::dropMotion() noexcept {
  increments_.dp_I = {};
  increments_.dq_I = {{kIdentityQuat, kIdentityQuat}};
  increments_.dgrasp = {};
}

/** Where the masters want the arms. A model that goes on alone, whatever took the robot from it, has to come back. */
void PhysicsLoop::aimAsTold() noexcept {
  if (!linked_) leaveRobot();
  bool is_clamped = false;
  for (const Arm arm : kArms) {
    ArmState& state = at(state_.arms, arm);
    if (driver_.isPushed(arm)) {  // it goes where forces take it
      at(increments_.dp_I, arm) = {};
      at(increments_.dq_I, arm) = kIdentityQuat;
      at(mappers_, arm).rebasePose(state.q);
    }
    const IkStatus status =
        at(mappers_, arm)
            .add(at(increments_.dp_I, arm), at(increments_.dq_I, arm), at(increments_.dgrasp, arm), state.q);
    state.ik_status = static_cast<std::uint32_t>(status);
    is_clamped = is_clamped || status == IkStatus::kClamped;
    at(q_d_, arm) = at(mappers_, arm).desired();
  }
  if (is_clamped) shared_.ik_clamped.add();
  useCommands();
}

void PhysicsLoop::useCommands() noexcept {
  state_.commands_used = increments_.commands;
  shared_.master_used.add(increments_.commands);
}

void PhysicsLoop::moveModel() noexcept {
  if (state_.mode == Mode::kChoosing) return showGoal();
  if (state_.mode == Mode::kReplaying) return showReplay();
  const bool is_returning = state_.mode == Mode::kReturning;
  const bool disengaged = state_.mode == Mode::kWaiting || state_.mode == Mode::kPedalUp ||
                          (state_.mode == Mode::kCameraMoving && !is_apart_);
  // A robot that is not ready searches its stops, wherever that leads: the model passes through everything until then.
  for (const Arm arm : kArms)
    world_.setCollisions(arm, at(collisions_, arm) && state_.mode != Mode::kWaiting && !is_returning);
  PerArm<JointArray> target = q_d_;
  if (disengaged && state_.robot_fresh != 0) {
    for (const Arm arm : kArms)
      at(target, arm) = followRobot(arm);
  }
  if (is_returning) {
    q_d_ = return_.tick();
    for (const Arm arm : kArms)
      at(target, arm) = bringTo(arm, at(q_d_, arm));
  }
  if (state_.mode == Mode::kTracking && follower_.active())
    at(target, follower_.arm()) = driver_.leading(follower_.arm(), follower_.target());
  if (state_.mode == Mode::kExecuting && !trial_.isUnderWay()) at(target, desk_.plan().arm) = path_lead_;
  driveModel(target);
}

void PhysicsLoop::driveModel(const PerArm<JointArray>& target) noexcept {
  const PerArm<JointArray> tau = driver_.step(target);
  for (const Arm arm : kArms)
    at(state_.arms, arm).tau = at(tau, arm);
}

void PhysicsLoop::relay() noexcept {
  const bool has_robot = hasRobot();
  if (has_robot && !relay_in_step_) relay_sequence_ = robot_.last_sequence;
  relay_in_step_ = has_robot;
  if (!relay_started_) return;
  RelayPacket packet;  // a robot whose state no longer reaches us is told pedal-up: its last word must not be "down"
  packet.tick = state_.tick + 1;
  packet.command.sequence = ++relay_sequence_;
  packet.command.pedal = isRobotLed() ? 1 : 0;
  if (isRobotLed()) {
    packet.command.dp_I = increments_.dp_I;
    packet.command.dq_I = increments_.dq_I;
    packet.command.dgrasp = increments_.dgrasp;
  }
  relay_faults_.beginCycle({linked_, static_cast<int>(robot_.runlevel), state_.faults.signals});
  relay_faults_.beginPacket(linked_);
  if (!relay_faults_.isArmed() && relay_stream_.isEmpty()) {
    relay_stream_.pass(packet.command);
    return sendToRobot(packet);
  }
  relay_stream_.offer(packet.command, &relay_faults_);
  while (relay_stream_.take(&packet.command, relay_faults_)) {
    faults::applyToCommand(&relay_faults_, &packet.command);
    sendToRobot(packet);
  }
}

void PhysicsLoop::sendToRobot(const RelayPacket& packet) noexcept {
  const auto network = relay_faults_.acting(FaultVariable::kPacket, FaultKind::kImpair);
  RelayPacket sent = packet;
  sent.is_held = relay_faults_.isHeld() ? 1 : 0;
  sent.impairment = network ? 1 + static_cast<std::uint32_t>(network.fault->value) : 0;
  shared_.relay_packets.tryPush(sent);
}

/** What the surgeon feels and sees: from what is right to what faults make of it. */
void PhysicsLoop::corruptConsole() noexcept {
  console_faults_.beginCycle({linked_, static_cast<int>(robot_.runlevel), state_.faults.signals});
  state_.faults.console = console_faults_.activeMask();
  for (const Arm arm : kArms) {
    at(state_.faults.force_gain, arm) = console_faults_.apply(FaultVariable::kForceGain, arm, 0, 1.0);
    at(state_.faults.force_offset_B, arm) = Vec3{};
    console_faults_.applyAll(FaultVariable::kForceOffset, arm, &at(state_.faults.force_offset_B, arm));
  }
  const std::int32_t picture = console_faults_.applyInt(FaultVariable::kPicture, Arm::kGold, 0, 0);
  const std::int32_t delay = console_faults_.applyInt(FaultVariable::kPictureDelay, Arm::kGold, 0, 0);
  constexpr auto kLast = static_cast<std::int32_t>(kPictureFaultCount) - 1;
  state_.faults.picture = static_cast<std::uint8_t>(std::clamp(picture, 0, kLast));
  state_.faults.picture_delay_ms = static_cast<std::uint32_t>(std::clamp(delay, 0, 5000));
}

void PhysicsLoop::publish(std::int64_t now_ns) noexcept {
  ++state_.tick;
  state_.time_ns = now_ns;
  state_.linked = isRobotLed() ? 1 : 0;
  state_.planning = trial_.overlay(desk_.state());
  state_.guide_plan = desk_.guidePlan();
  corruptConsole();
  state_.faults.relay = relay_faults_.activeMask();
  state_.faults.master = master_faults_.activeMask();
  state_.faults.active = relay_faults_.activeId();
  if (state_.faults.active == 0) state_.faults.active = master_faults_.activeId();
  if (state_.faults.active == 0) state_.faults.active = console_faults_.activeId();
  tellFaultChanges();
  countFaultedPackets();
  for (const Arm arm : kArms)
    fillArm(arm, &at(state_.arms, arm));
  if (state_.mode == Mode::kTrial) trial_.keep(state_.arms);
  state_.trial_ticks = trial_.ticks();
  state_.camera = camera_.state();
  state_.pedals = state_.mode == Mode::kCameraMoving ? bit(Pedal::kCamera) : 0;
  world_.bodyPoses(&state_.bodies);
  if (state_.mode == Mode::kReplaying) state_.bodies = shown_.bodies_W;
  listContacts();
  exercise_.tick(&state_, contacts_, rehearses_);
  servo_.publish(state_.tick, state_.time_ns, robotSetPoints());
  shared_.model.store(state_);
  publishContacts();
  shared_.tick_records.tryPush({state_, robot_, static_cast<std::uint8_t>(slipped_ ? 1 : 0)});
  slipped_ = false;
  if (state_.session_tick >= 0 && state_.mode != Mode::kPaused) ++state_.session_tick;
  if (exercise_.hasExercise()) state_.faults.signals = exercise_.signals();
  if (tool_changes_ > 0) state_.faults.signals.tool_changes = tool_changes_;  // what the next tick's triggers see
}

void PhysicsLoop::listContacts() noexcept {
  contacts_.count = 0;
  contacts_.dropped = 0;
  if (!isShown(state_.mode)) world_.contactList(&contacts_);  // else those of the last step are long past
  contacts_.tick = state_.tick;
}

void PhysicsLoop::publishContacts() noexcept {
  shared_.contacts.store(contacts_);
  shared_.contacts_dropped.add(contacts_.dropped);
  if (contacts_.count == 0) return;
  forEachPair(contacts_, [this](const ContactRecord& record) { shared_.contact_records.tryPush(record); });
}

void PhysicsLoop::fillArm(Arm arm, ArmState* state) const noexcept {
  world_.jointState(arm, &state->q, &state->dq);
  state->q_d = at(q_d_, arm);
  state->contacts = isShown(state_.mode) ? 0 : world_.contacts(arm);
  const ArmGeometry& geometry = config_.arms.geometry;
  const Pose X_BT = kinematics::forward(geometry, arm, state->q);
  const Eigen::Matrix<double, 7, 1> dq(state->dq.data());
  const Vector3 v_BT = kinematics::jacobian(geometry, arm, state->q).topRows<3>() * dq;
  state->p_BT = toArray(X_BT.p);
  state->v_BT = toArray(v_BT);
  state->q_BT = toArray(Quaternion(X_BT.R));
}

void PhysicsLoop::timeSlip() noexcept {
  linked_ = false;
  slipped_ = true;
  raise(Event::kTimeSlip);
  desk_.forget();
}

}  // namespace raven2_trainer::runtime
