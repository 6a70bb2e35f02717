#pragma once

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <string>

#include "raven2_trainer/config/trainer_config.h"
#include "raven2_trainer/core/fault_variables.h"
#include "raven2_trainer/lockstep/lockstep.h"
#include "raven2_trainer/loop/planner_worker.h"
#include "raven2_trainer/recording/recorder.h"
#include "support/rig.h"
#include "support/servo_client.h"

namespace raven2_trainer::lockstep {

using raven2_trainer::testing::beside;
using raven2_trainer::testing::packagedConfig;
using raven2_trainer::testing::Rig;
using raven2_trainer::testing::ServoClient;

/** A session with every kind of input that physics accepts, recorded as the daemon records it. */
class EventfulSession {
 public:
  explicit EventfulSession(const std::string& directory, std::uint64_t seed = packagedConfig().seed)
      : config(eventfulConfig(seed)),
        paths(session::createSessionDirectory(directory)),
        rig(config),
        planner(config, rig.raven, rig.scene, rig.shared.get()),
        recorder(config, rig.physics.bodyNames(), paths, "test", rig.shared.get()) {
    rig.record = [this] { recorder.drain(); };
  }

  void run() {
    ASSERT_TRUE(rig.home());
    strokesAndClutches();
    training();
    clients();
    replays();
    executions();
    plans();
    collisions();
    robotDrop();
    timeSlip();
    hazard();
    recorder.finish(rig.counts());
  }

  const TrainerConfig config;
  const session::SessionPaths paths;

 private:
  static TrainerConfig eventfulConfig(std::uint64_t seed) {
    TrainerConfig config = packagedConfig();
    config.seed = seed;
    config.hazard = "none";
    config.runtime.plan_at = -1.0;
    Fault& jump = raven2_trainer::testing::onlyFaultOf(&config, "sudden_jump");
    jump.first_tick = 0;  // at the first pedal-down once it is armed
    jump.duration_ticks = 100;
    config.planner.samples = 50;
    config.haptics.guidance.enabled = config.haptics.edge.enabled = true;
    return config;
  }

  void stroke(int ticks, double direction) {
    for (int i = 0; i < ticks; ++i)
      rig.tick(true, {direction * 20e-6, direction * (i % 7) * 3e-6, i % 2 == 0 ? 10e-6 : 0.0});
  }

  void rest(bool pedal, int ticks) {
    for (int i = 0; i < ticks; ++i)
      rig.tick(pedal);
  }

  void request(RequestKind kind, std::uint32_t id = 0, bool enabled = false, bool on_robot = false) {
    Request order;
    order.kind = kind;
    order.on_robot = on_robot ? 1 : 0;
    order.id = id;
    order.enabled = enabled ? 1 : 0;
    ASSERT_TRUE(rig.shared->requests.tryPush(order));
  }

  void strokesAndClutches() {
    for (int clutch = 0; clutch < 4; ++clutch) {
      stroke(150, clutch % 2 == 0 ? 1.0 : -1.0);
      rest(false, 60);
    }
  }

  /** The tool moves into the scene, then with collisions off, then disengaged. */
  void collisions() {
    for (int i = 0; i < 700; ++i)
      rig.tick(true, {0.0, 0.0, 50e-6});
    request(RequestKind::kSetCollisions, 0, false);
    stroke(50, 1.0);
    request(RequestKind::kSetCollisions, 0, true);
    request(RequestKind::kDisengage);
    stroke(50, -1.0);
    request(RequestKind::kEngage);
    rest(false, 300);
  }

  /** Plans that are refused, cancelled while the planner works, too many at once, and followed. */
  void plans() {
    rest(true, 5);
    request(RequestKind::kPlan, 11);
    rest(true, 5);
    rest(false, 100);
    for (std::uint32_t id = 20; id < 26; ++id) {
      request(RequestKind::kPlan, id);
      request(RequestKind::kCancelPlan);
      rest(false, 3);
    }
    while (planner.serve())
      rest(false, 2);
    request(RequestKind::kPlan, 30);
    rest(false, 20);
    planner.serve();
    rest(false, 600);
    until(Mode::kTeleoperating, true);  // the model goes back first
  }

  /** A goal is chosen and planned. The model executes the whole path, the robot a part. Another goal is abandoned. */
  void executions() {
    request(RequestKind::kBeginPlanning, 40);
    rest(false, 2);
    for (int i = 0; i < 300; ++i)
      rig.tick(true, {-20e-6, 40e-6, 0.0});
    rest(false, 5);
    request(RequestKind::kRecordGoal, 41);
    rest(false, 2);
    planner.serve();
    rest(false, 50);
    request(RequestKind::kExecutePlan, 42);
    rest(false, 20);
    for (int i = 0; i < 60000 && (i < 10 || rig.model().mode == Mode::kExecuting); ++i)
      rig.tick(true);
    rest(false, 20);
    request(RequestKind::kExecutePlan, 43, false, /*on_robot=*/true);
    rest(false, 20);
    rest(true, 600);
    rest(false, 50);
    request(RequestKind::kBeginPlanning, 44);
    rest(false, 2);
    stroke(50, 1.0);
    request(RequestKind::kEndPlanning, 45);
    rest(false, 100);
  }

  void until(Mode mode, bool pedal) {
    for (int i = 0; i < 6000 && rig.model().mode != mode; ++i)
      rig.tick(pedal);
    ASSERT_EQ(rig.model().mode, mode);
  }

  /** Pure simulation and back, the camera, a stop with the model away from the robot, and a trial that is repeated. */
  void training() {
    request(RequestKind::kBeginSimulation, 60);
    request(RequestKind::kSetView, 61, true);
    request(RequestKind::kToolChange, 62);
    rest(false, 2);
    stroke(200, 1.0);
    request(RequestKind::kSetCameraPedal, 63, true);
    stroke(100, -1.0);
    request(RequestKind::kSetCameraPedal, 64, false);
    stroke(100, 1.0);
    request(RequestKind::kEmergencyStop, 65);
    rest(false, 30);
    request(RequestKind::kClearStop, 66);
    rest(false, 1);
    until(Mode::kPedalUp, false);
    request(RequestKind::kBeginSimulation, 67);
    rest(false, 2);
    stroke(100, 1.0);
    rest(false, 10);
    request(RequestKind::kEndSimulation, 68);
    rest(false, 1);
    until(Mode::kTeleoperating, true);
    rest(false, 60);
    trial();
  }

  void trial() {
    request(RequestKind::kBeginTrial, 70);
    rest(false, 2);
    stroke(150, 1.0);
    rest(false, 30);
    stroke(150, 1.0);
    rest(false, 30);
    request(RequestKind::kEndTrial, 71);
    for (const bool on_robot : {false, true}) {
      request(RequestKind::kRepeatTrial, 72, false, on_robot);
      rest(false, 1);
      until(Mode::kArmed, false);
      rest(true, on_robot ? 350 : 3000);
      rest(false, 50);
    }
    request(RequestKind::kBeginTrial, 73);
    rest(false, 2);
    stroke(100, 1.0);
    rest(false, 2);
    request(RequestKind::kDiscardTrial, 74);
    rest(false, 1);
    until(Mode::kPedalUp, false);
  }

  /** A CRTK client: servos and moves of both arms, the console that takes over, a stop, and a second enable. */
  void clients() {
    ServoClient client(&rig);
    ASSERT_TRUE(client.enable());
    for (const Arm arm : kArms) {
      ServoJoints q = client.arm(arm).setpoint_q;
      q[kElbow] -= 0.02;
      q[kToolRotation] += 0.2;
      client.send(ServoKind::kServoPose, arm, beside(client.arm(arm).setpoint_B, {0.004, -0.003, 0.005}, 0.1));
      client.rest(80);
      client.send(ServoKind::kMoveJoints, arm, q);
      client.sendJaw(ServoKind::kServoJaw, arm, 0.9);
      client.rest(300);
    }
    client.rest(40, /*console_pedal=*/true);
    stroke(60, 1.0);
    rest(false, 30);
    ASSERT_EQ(client.ask(StateCommand::kResume), ServoRefusal::kNone);
    client.rest(30);
    request(RequestKind::kEmergencyStop, 76);
    client.rest(5);
    request(RequestKind::kClearStop, 77);
    client.rest(2);
    ASSERT_TRUE(client.enable());
    client.send(ServoKind::kServoPoseBy, Arm::kGold, RigidPose{{0.002, 0.0, 0.001}, kIdentityQuat});
    client.rest(100);
    ASSERT_EQ(client.ask(StateCommand::kDisable), ServoRefusal::kNone);
    ASSERT_EQ(client.refusals, 0U);
    until(Mode::kPedalUp, false);
    ASSERT_GT(rig.counts().master_overruled, 500U);
    ASSERT_GT(rig.counts().servo_made, 500U);
  }

  void replay(std::uint32_t number, int ticks, bool ends) {
    raven2_trainer::testing::offerSession(rig.shared.get(), number, ticks, ends);
    Request order;
    order.kind = RequestKind::kBeginReplay;
    order.id = 80 + number;
    order.plan = number;
    ASSERT_TRUE(rig.shared->requests.tryPush(order));
    rest(false, 40);
    ASSERT_EQ(rig.model().mode, ticks > 40 || !ends ? Mode::kReplaying : Mode::kPedalUp) << number;
  }

  /** Replays that run to their end, run out of frames and are ended, are ended by a press, and refuse a second one. */
  void replays() {
    rest(false, 60);
    replay(1, 30, true);
    replay(2, 20, false);
    request(RequestKind::kEndReplay, 90);
    rest(false, 20);
    replay(3, 200, true);
    rest(true, 20);
    rest(false, 60);
    replay(4, 60, true);
    raven2_trainer::testing::offerSession(rig.shared.get(), 5, 50, false);
    request(RequestKind::kBeginReplay, 91);
    rest(false, 60);
    replay(6, 30, true);
    stroke(60, 1.0);
    rest(false, 60);
    stroke(60, -1.0);
    rest(false, 60);
  }

  void robotDrop() {
    stroke(60, 1.0);
    rig.robot_connected = false;
    rest(true, 30);  // silent, then gone
    rig.link.disconnected();
    stroke(60, 1.0);
    rest(false, 30);
    forces();
    rig.connect();
    rig.robot_connected = true;
    rest(false, 100);
    until(Mode::kPedalUp, false);  // the model went on alone and goes back
  }

  /** A client's forces, on both arms of the model alone. */
  void forces() {
    ServoClient client(&rig);
    ASSERT_TRUE(client.enable());
    const ModelState before = rig.model();
    client.send(ServoKind::kServoForces, Arm::kGold, ServoJoints{0.3, -0.2, 1.0, 0.0, 0.01, 0.0});
    ServoCommand wrench;
    wrench.kind = ServoKind::kServoWrench;
    wrench.arm = Arm::kGreen;
    wrench.frame = WrenchFrame::kBody;
    wrench.force = {1.0, 0.5, -0.5};
    client.send(wrench);
    client.sendJaw(ServoKind::kServoJawForce, Arm::kGold, 0.02);
    client.rest(60);
    for (const Arm arm : kArms)
      ASSERT_NE(at(rig.model().arms, arm).q, at(before.arms, arm).q) << name(arm);
    ASSERT_EQ(client.ask(StateCommand::kDisable), ServoRefusal::kNone);
    ASSERT_EQ(client.refusals, 0U);
    rest(false, 20);
  }

  void timeSlip() {
    stroke(60, -1.0);
    rig.physics.timeSlip();
    stroke(30, -1.0);
    rest(false, 100);
  }

  void hazard() {
    ASSERT_TRUE(rig.shared->fault_requests.tryPush({FaultOrder::kArm, config::faultId(config, "sudden_jump")}));
    stroke(400, 1.0);
    ASSERT_TRUE(rig.shared->fault_requests.tryPush({FaultOrder::kClear, 0}));
    stroke(100, -1.0);
  }

  Rig rig;
  loop::PlannerWorker planner;
  recording::Recorder recorder;
};

}  // namespace raven2_trainer::lockstep
