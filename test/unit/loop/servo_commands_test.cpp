#include <gtest/gtest.h>

#include <cmath>
#include <deque>
#include <functional>
#include <memory>

#include "loop/servo_manager.h"
#include "raven2_trainer/config/trainer_config.h"
#include "raven2_trainer/control/axis_map.h"
#include "raven2_trainer/control/mode_table.h"

// Tests the commands that the manager of CRTK clients gives to a loop of the arms' mapping and the mode table alone.

namespace raven2_trainer::loop {
namespace {

using control::Event;

constexpr double kDegree = kPi / 180.0;

TrainerConfig configuration(double trim_time) {
  TrainerConfig c;
  c.crtk.trim_time = trim_time;
  ArmGeometry& g = c.arms.geometry;
  g.d4 = -0.47;
  g.lw = 0.013;
  g.q_min = {0, 45 * kDegree, 0.23, -182 * kDegree, -70 * kDegree, -105 * kDegree, -105 * kDegree};
  g.q_max = {90 * kDegree, 135 * kDegree, 0.56, 182 * kDegree, 70 * kDegree, 105 * kDegree, 105 * kDegree};
  g.home = {30 * kDegree, 90 * kDegree, 0.36, 0.2, 0.1, 35 * kDegree, 45 * kDegree};
  c.network.itp.max_increment_um = 2000;
  c.network.itp.max_rotation = 0.1;
  c.network.itp.master_timeout = 0.2;
  c.crtk.max_speed = 0.1;
  c.crtk.max_turn_rate = 2.0;
  c.crtk.max_step = 0.02;
  c.crtk.max_step_turn = 0.4;
  c.crtk.move_speed = 0.04;
  c.crtk.move_turn_rate = 0.5;
  c.crtk.twist_timeout = 0.1;
  c.crtk.release_after = 1.0;
  return c;
}

double tipsApart(const Vec3& a, const Vec3& b) {
  return (toEigen(a) - toEigen(b)).norm();
}

class ServoCommands : public ::testing::Test {
 protected:
  explicit ServoCommands(double trim_time = 0.0) : config(configuration(trim_time)) {
    stand.is_healthy = stand.applies = true;
    tick();
  }

  /** The console's pedal in one tick: up, down, or the console is silent. */
  enum class Heard { kUp, kDown, kNothing };
  void tick(Heard console = Heard::kUp) {
    stand.mode = mode;
    stand.teleoperates = mode == Mode::kTeleoperating || mode == Mode::kReturning ||
                         control::nextMode(mode, Event::kPedalPressed) == Mode::kTeleoperating;
    stand.pedal_down = pedal;
    stand.is_taken = false;
    MasterCommand command;
    command.pedal = console == Heard::kDown ? 1 : 0;
    if (console != Heard::kNothing && manager.overrules(command)) {
      ++overruled;
    } else if (console != Heard::kNothing) {
      manager.hear(command);
      pedal = command.pedal != 0;
      stand.is_taken = true;
    }
    increments = MasterCommand{};
    made = manager.next(stand, mappers, &command);
    if (made) {
      EXPECT_FALSE(stand.is_taken && command.pedal != 0) << "a press after a release in the same tick is lost";
      under_way.push_back(command);
      if (command.pedal == 0 && lost_releases > 0) {
        --lost_releases;
        under_way.pop_back();
      } else {
        pedal = command.pedal != 0;
      }
    }
    while (under_way.size() > delay) {
      take(under_way.front());
      under_way.pop_front();
    }
    if (in_tick) in_tick();
    press();
    for (const Arm arm : kArms) {
      const bool moves = mode == Mode::kTeleoperating && stand.applies;
      if (moves)
        at(mappers, arm)
            .add(at(increments.dp_I, arm), at(increments.dq_I, arm), at(increments.dgrasp, arm), joints(arm));
    }
    manager.publish(++ticks, 0, {mappers[0].desired(), mappers[1].desired()});
    while (shared->servo_refused.tryPop(&refused)) {
    }
  }
  void tick(int count, Heard console = Heard::kUp) {
    for (int i = 0; i < count; ++i)
      tick(console);
  }

  /** The arm's joints: the desired ones, or joints so far from them that the mapping accepts no motion. */
  JointArray joints(Arm arm) const {
    JointArray q = at(mappers, arm).desired();
    if (is_far) q[kInsertion] += 0.03;
    return q;
  }

  void take(const MasterCommand& command) {
    increments = command;
    if (command.pedal != 0) {
      EXPECT_EQ(command.pedal, kClientsPedal);
    }
    for (const Arm arm : kArms) {
      for (const double d : at(command.dp_I, arm))
        EXPECT_NEAR(d * 1e6, std::round(d * 1e6), 1e-6) << "the increments are whole micrometres";
      EXPECT_NEAR(at(command.dgrasp, arm) * 1e3, std::round(at(command.dgrasp, arm) * 1e3), 1e-9);
    }
  }

  void press() {
    if (pedal && !pedal_before) mode = control::nextMode(mode, Event::kPedalPressed);
    if (!pedal && pedal_before) mode = control::nextMode(mode, Event::kPedalReleased);
    pedal_before = pedal;
  }

  ServoRefusal ask(ServoCommand command) {
    command.id = ++id;
    EXPECT_TRUE(shared->servo_commands.tryPush(command));
    tick();
    return refused.id == id ? refused.reason : ServoRefusal::kNone;
  }
  ServoRefusal ask(StateCommand state) {
    ServoCommand command;
    command.kind = ServoKind::kState;
    command.state = state;
    return ask(command);
  }
  ServoRefusal askPose(ServoKind kind, const Vec3& by, Arm arm = Arm::kGold) {
    ServoCommand command;
    command.kind = kind;
    command.arm = arm;
    command.pose_B = at(state().arms, arm).setpoint_B;
    for (std::size_t i = 0; i < 3; ++i)
      command.pose_B.p[i] += by[i];
    goal = command.pose_B;
    return ask(command);
  }
  void enable() {
    ASSERT_EQ(ask(StateCommand::kEnable), ServoRefusal::kNone);
    tick(2);
    ASSERT_EQ(mode, Mode::kTeleoperating);
  }

  ServoState state() const { return shared->servo.load(); }
  Vec3 tip() const { return state().arms[0].setpoint_B.p; }

  const TrainerConfig config;
  std::unique_ptr<SharedState> shared = std::make_unique<SharedState>();
  ServoManager manager{config, shared.get()};
  PerArm<control::TeleopMapper> mappers{control::TeleopMapper(config.arms.geometry, Arm::kGold),
                                        control::TeleopMapper(config.arms.geometry, Arm::kGreen)};
  ServoSituation stand;
  Mode mode{Mode::kPedalUp};
  bool pedal{false}, pedal_before{false}, made{false};
  MasterCommand increments;
  std::deque<MasterCommand> under_way;
  bool is_far{false};
  int lost_releases{0};
  std::size_t delay{0};  ///< [ticks] from a command to the mapping
  std::function<void()> in_tick;
  RigidPose goal;
  ServoRefused refused;
  std::uint32_t id{0};
  int overruled{0};
  Tick ticks{0};
};

TEST_F(ServoCommands, FollowTheStates) {
  EXPECT_EQ(state().state, OperatingState::kDisabled);
  EXPECT_EQ(askPose(ServoKind::kServoPose, {}), ServoRefusal::kNotEnabled);
  EXPECT_EQ(ask(StateCommand::kResume), ServoRefusal::kInvalid);
  enable();
  EXPECT_EQ(state().state, OperatingState::kEnabled);
  EXPECT_EQ(state().holds_pedal, 1);
  EXPECT_EQ(ask(StateCommand::kPause), ServoRefusal::kNone);
  EXPECT_FALSE(pedal);
  EXPECT_EQ(mode, Mode::kPedalUp);
  EXPECT_EQ(ask(StateCommand::kEnable), ServoRefusal::kInvalid);
  EXPECT_EQ(ask(StateCommand::kResume), ServoRefusal::kNone);
  tick(2);
  EXPECT_TRUE(pedal);
  EXPECT_EQ(ask(StateCommand::kDisable), ServoRefusal::kNone);
  EXPECT_EQ(state().state, OperatingState::kDisabled);
  EXPECT_FALSE(pedal);
  EXPECT_EQ(ask(StateCommand::kUnhome), ServoRefusal::kNotOffered);
  EXPECT_EQ(ask(StateCommand::kHome), ServoRefusal::kNone);
  EXPECT_EQ(state().received, 9U);
  EXPECT_EQ(state().refused, 4U);
  EXPECT_EQ(state().applied, 5U);
}

TEST_F(ServoCommands, LeadTheMappingToTheJointsThatWereAskedFor) {
  enable();
  PerArm<ServoJoints> to{};
  for (const Arm arm : kArms) {
    ServoCommand command;
    command.kind = ServoKind::kServoJoints;
    command.arm = arm;
    const ServoJoints q = at(state().arms, arm).setpoint_q;
    command.joints = {q[0] + 0.03, q[1] - 0.04, q[2] - 0.005, q[3] + 0.2, q[4] - 0.15, q[5] + 0.1};
    at(to, arm) = command.joints;
    EXPECT_EQ(ask(command), ServoRefusal::kNone);
  }
  tick(500);
  for (const Arm arm : kArms) {
    for (std::size_t j = 0; j < kServoJointCount; ++j)
      EXPECT_NEAR(at(state().arms, arm).setpoint_q[j], at(to, arm)[j], 1e-4) << j;
  }
}

TEST_F(ServoCommands, MoveTheTipStraightAndMeetTheGoalToAMicrometre) {
  enable();
  const Vector3 from = toEigen(tip());
  EXPECT_EQ(askPose(ServoKind::kMovePose, {0.01, 0.015, -0.02}), ServoRefusal::kNone);
  const Vector3 way = (toEigen(goal.p) - from).normalized();
  double fastest = 0.0;
  int busy = 0;
  for (; state().arms[0].is_busy != 0 && busy < 10000; ++busy) {
    const Vec3 before = tip();
    tick();
    fastest = std::max(fastest, tipsApart(tip(), before));
    const Vector3 gone = toEigen(tip()) - from;
    ASSERT_LT((gone - gone.dot(way) * way).norm(), 2e-6);
  }
  EXPECT_NEAR(busy, 1262, 3) << "15/8 x 26.93 mm / 40 mm/s";
  EXPECT_LT(tipsApart(tip(), goal.p), 1e-6);
  EXPECT_LT(fastest, 43e-6);
  EXPECT_EQ(tipsApart(state().arms[1].goal_B.p, state().arms[1].setpoint_B.p), 0.0);
}

TEST_F(ServoCommands, OfTheJawsAreWholeMilliradians) {
  enable();
  ServoCommand command;
  command.kind = ServoKind::kMoveJaw;
  command.jaw = 0.6504;
  EXPECT_EQ(ask(command), ServoRefusal::kNone);
  tick(3200);
  EXPECT_NEAR(state().arms[0].setpoint_jaw, 0.6504, 0.5e-3 + 1e-9);
  EXPECT_EQ(state().arms[0].is_busy, 0);
  const double there = state().arms[0].setpoint_jaw;
  tick(100);
  EXPECT_EQ(state().arms[0].setpoint_jaw, there) << "the jaws are at rest";
}

TEST_F(ServoCommands, GiveWayToTheConsole) {
  enable();
  EXPECT_EQ(askPose(ServoKind::kMovePose, {0.03, 0.0, 0.0}), ServoRefusal::kNone);
  tick(200);
  EXPECT_GT(overruled, 200);
  const int before = overruled;
  tick(Heard::kDown);
  EXPECT_FALSE(made);
  EXPECT_EQ(mode, Mode::kTeleoperating) << "teleoperation goes on without a break";
  const Vec3 taken = tip();
  tick(50, Heard::kDown);
  EXPECT_LT(tipsApart(tip(), taken), 1e-9);
  EXPECT_EQ(state().state, OperatingState::kEnabled);
  EXPECT_EQ(state().holds_pedal, 0);
  ServoCommand command;
  command.kind = ServoKind::kState;
  command.state = StateCommand::kDisable;
  command.id = ++id;
  shared->servo_commands.tryPush(command);
  tick(Heard::kDown);
  EXPECT_EQ(refused.id, id);
  EXPECT_EQ(refused.reason, ServoRefusal::kConsole);
  tick(3, Heard::kUp);
  EXPECT_EQ(state().state, OperatingState::kPaused);
  EXPECT_EQ(overruled, before);
  tick(50, Heard::kDown);
  EXPECT_EQ(state().state, OperatingState::kEnabled);
  tick(198, Heard::kNothing);
  EXPECT_EQ(state().state, OperatingState::kEnabled);
  tick(2, Heard::kNothing);
  EXPECT_EQ(state().state, OperatingState::kPaused) << "the console was silent for 0.2 s";
}

TEST_F(ServoCommands, OfBeforeTheConsoleTookThePedalAreOverForGood) {
  enable();
  ASSERT_EQ(askPose(ServoKind::kMovePose, {0.03, 0.0, 0.0}), ServoRefusal::kNone);
  tick(200);
  tick(5, Heard::kDown);
  tick(5, Heard::kUp);
  ASSERT_EQ(state().state, OperatingState::kPaused);
  const Vec3 here = tip();
  ASSERT_EQ(ask(StateCommand::kResume), ServoRefusal::kNone);
  tick(300);
  ASSERT_EQ(mode, Mode::kTeleoperating);
  EXPECT_EQ(state().arms[0].is_busy, 0);
  EXPECT_LT(tipsApart(tip(), here), 1e-9);
}

TEST_F(ServoCommands, EndWhenTheRobotNoLongerFollows) {
  stand.linked = true;
  enable();
  EXPECT_EQ(askPose(ServoKind::kMovePose, {0.03, 0.0, 0.0}), ServoRefusal::kNone);
  tick(100);
  stand.applies = false;
  tick();
  EXPECT_EQ(state().state, OperatingState::kPaused);
  EXPECT_FALSE(pedal);
  EXPECT_EQ(state().arms[0].is_busy, 0);
  stand.applies = true;
  EXPECT_EQ(ask(StateCommand::kResume), ServoRefusal::kNone);
  tick(2);
  const Vec3 here = tip();
  tick(100);
  EXPECT_LT(tipsApart(tip(), here), 1e-9) << "the old command is forgotten";
  stand.linked = false;
  tick();
  EXPECT_EQ(state().state, OperatingState::kPaused) << "the robot has left or is disengaged";
}

TEST_F(ServoCommands, WaitForARobotThatDoesNotTakeThemYet) {
  stand.applies = false;
  enable();
  EXPECT_EQ(askPose(ServoKind::kMovePose, {0.004, 0.0, 0.0}), ServoRefusal::kNone);
  const Vec3 here = tip();
  tick(300);
  EXPECT_LT(tipsApart(tip(), here), 1e-9);
  stand.applies = true;
  tick(250);
  EXPECT_LT(tipsApart(tip(), goal.p), 1e-6);
}

TEST_F(ServoCommands, FindARobotDisabledThatWasNotStartedAndInAFaultOnceItFell) {
  for (int connection = 0; connection < 2; ++connection) {
    stand.robot_there = true;
    stand.robot_stopped = true;
    tick(5);
    EXPECT_EQ(state().state, OperatingState::kDisabled);
    EXPECT_EQ(state().is_homed, 0);
    EXPECT_EQ(ask(StateCommand::kEnable), ServoRefusal::kRobotStop);
    EXPECT_EQ(ask(StateCommand::kDisable), ServoRefusal::kNone);
    EXPECT_EQ(state().state, OperatingState::kDisabled);
    EXPECT_EQ(state().holds_pedal, 0);
    stand.robot_stopped = false;
    stand.robot_homed = stand.robot_ready = true;
    EXPECT_EQ(ask(StateCommand::kEnable), ServoRefusal::kNone);
    stand.robot_stopped = true;
    tick();
    EXPECT_EQ(state().state, OperatingState::kFault);
    EXPECT_EQ(ask(StateCommand::kEnable), ServoRefusal::kRobotStop);
    EXPECT_EQ(ask(StateCommand::kDisable), ServoRefusal::kRobotStop);
    EXPECT_EQ(ask(StateCommand::kPause), ServoRefusal::kInvalid);
    EXPECT_EQ(refused.in, OperatingState::kFault);
    EXPECT_EQ(state().holds_pedal, 0);
    stand = ServoSituation{};  // its control software is started again
    stand.is_healthy = stand.applies = true;
    tick(2);
  }
}

TEST_F(ServoCommands, AreRefusedWithTheReasonThatHolds) {
  stand.robot_there = true;
  stand.robot_stopped = true;
  tick();
  EXPECT_EQ(ask(StateCommand::kEnable), ServoRefusal::kRobotStop);
  EXPECT_EQ(ask(StateCommand::kHome), ServoRefusal::kRobotStop);
  EXPECT_EQ(ask(StateCommand::kPause), ServoRefusal::kInvalid);
  stand.robot_stopped = false;  // the robot homes
  EXPECT_EQ(ask(StateCommand::kHome), ServoRefusal::kNone);
  EXPECT_EQ(state().state, OperatingState::kDisabled);
  EXPECT_EQ(state().is_homed, 0);
  EXPECT_EQ(state().arms[1].is_busy, 1);
  stand.robot_homed = true;  // still in INIT: a client that reads is_homed would move the robot
  tick();
  EXPECT_EQ(state().is_homed, 0);
  EXPECT_EQ(state().arms[0].is_busy, 1);
  EXPECT_EQ(ask(StateCommand::kEnable), ServoRefusal::kNone);
  EXPECT_EQ(askPose(ServoKind::kServoPose, {}), ServoRefusal::kNotHomed);
  stand.robot_ready = true;
  EXPECT_EQ(askPose(ServoKind::kServoPose, {}), ServoRefusal::kNone);
  EXPECT_EQ(state().is_homed, 1);
  EXPECT_EQ(state().arms[0].is_busy, 0);
  EXPECT_EQ(askPose(ServoKind::kServoPose, {1.0, 0.0, 0.0}), ServoRefusal::kTooFar);
  EXPECT_EQ(refused.arm, Arm::kGold);
  EXPECT_EQ(refused.limit, 0.02);
  mode = Mode::kCameraMoving;
  EXPECT_EQ(askPose(ServoKind::kServoPose, {}), ServoRefusal::kMode);
  mode = Mode::kTrialHeld;
  tick();
  EXPECT_EQ(state().state, OperatingState::kPaused);
  EXPECT_EQ(ask(StateCommand::kResume), ServoRefusal::kMode);
  stand.is_healthy = false;
  tick();
  EXPECT_EQ(state().state, OperatingState::kFault);
  EXPECT_EQ(ask(StateCommand::kEnable), ServoRefusal::kMode);
}

TEST_F(ServoCommands, DoNotEndAStopThatAnOperatorAskedFor) {
  enable();
  mode = Mode::kStopped;
  stand.stop_asked = true;
  tick();
  EXPECT_EQ(state().state, OperatingState::kDisabled);
  EXPECT_FALSE(pedal);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(ask(StateCommand::kEnable), ServoRefusal::kOperatorStop);
    EXPECT_EQ(state().state, OperatingState::kDisabled);
    EXPECT_FALSE(pedal);
  }
  EXPECT_EQ(ask(StateCommand::kDisable), ServoRefusal::kNone);
  stand.stop_asked = false;  // the operator cleared the stop
  mode = Mode::kPedalUp;
  enable();
  mode = Mode::kStopped;  // the robot stopped the arms, and starts again
  tick();
  EXPECT_EQ(ask(StateCommand::kEnable), ServoRefusal::kRobotStop);
}

TEST_F(ServoCommands, DoNotPressWhereAnotherModeBeganInTheSameTick) {
  in_tick = [this] { mode = Mode::kTrialHeld; };
  EXPECT_EQ(ask(StateCommand::kEnable), ServoRefusal::kNone);
  in_tick = nullptr;
  tick(3);
  EXPECT_FALSE(pedal);
  EXPECT_EQ(mode, Mode::kTrialHeld);
  EXPECT_EQ(state().state, OperatingState::kPaused);
}

TEST_F(ServoCommands, LetGoOfThePedalAfterTheirSilence) {
  enable();
  tick(900);
  EXPECT_EQ(askPose(ServoKind::kMovePose, {0.03, 0.0, 0.0}), ServoRefusal::kNone) << "the move takes 1.41 s";
  tick(1300);
  EXPECT_EQ(state().state, OperatingState::kEnabled);
  tick(1000);
  EXPECT_EQ(state().state, OperatingState::kEnabled) << "a second after the move's end";
  tick(200);
  EXPECT_EQ(state().state, OperatingState::kPaused);
  EXPECT_FALSE(pedal);
}

TEST_F(ServoCommands, ThatAreKeptBackAreNotSentTwice) {
  enable();
  delay = 20;
  stand.keeps_back = true;
  tick(25);
  EXPECT_EQ(askPose(ServoKind::kServoPose, {0.01, 0.0, 0.0}), ServoRefusal::kNone);
  double farthest = 0.0;
  const Vec3 from = tip();
  for (int i = 0; i < 400; ++i) {
    tick();
    farthest = std::max(farthest, tipsApart(tip(), from));
  }
  EXPECT_NEAR(farthest, 0.01, 1e-6) << "the tip must not overshoot";
  EXPECT_LT(tipsApart(tip(), goal.p), 1e-6);
}

TEST_F(ServoCommands, ThatTheMappingRefusesAreTakenBack) {
  enable();
  EXPECT_EQ(askPose(ServoKind::kServoPose, {0.01, 0.0, 0.0}), ServoRefusal::kNone);
  tick(20);
  is_far = true;
  const Vec3 here = tip();
  for (int i = 0; i < 300; ++i) {
    tick();
    const Pose asked = kinematics::forward(config.arms.geometry, Arm::kGold, mappers[0].desired());
    ASSERT_LT((mappers[0].desiredPose().p - asked.p).norm(), 3.1e-4)
        << "the commands would make a leap once the mapping accepts them";
  }
  EXPECT_LT(tipsApart(tip(), here), 1e-9);
  is_far = false;
  for (int i = 0; i < 200; ++i) {
    const Vec3 before = tip();
    tick();
    ASSERT_LT(tipsApart(tip(), before), 3.1e-4);
  }
  EXPECT_LT(tipsApart(tip(), goal.p), 1e-6) << "the tip then reaches its goal";
}

/** With a robot that friction holds off its set point, so that there is a trim. */
class ServoCommandsAtALimit : public ServoCommands {
 protected:
  ServoCommandsAtALimit() : ServoCommands(0.5) {
    stand.linked = stand.robot_there = stand.robot_homed = stand.robot_ready = true;
    in_tick = [this] {
      for (const Arm arm : kArms) {
        JointArray& q = at(stand.robot_q, arm) = at(mappers, arm).desired();
        for (std::size_t j = 0; j < control::ServoTrim::kJoints; ++j)
          q[j] += 0.6 * control::ServoTrim::kLimit[j];
      }
    };
  }
  ServoRefusal askJoints(ServoKind kind, Arm arm, const ServoJoints& joints) {
    ServoCommand command;
    command.kind = kind;
    command.arm = arm;
    command.joints = joints;
    return ask(command);
  }
  ServoRefusal askBack(ServoKind kind, Arm arm) {
    ServoCommand command;
    command.kind = kind;
    command.arm = arm;
    command.pose_B = at(state().arms, arm).setpoint_B;
    return ask(command);
  }
  /** With the pedal up; then the client resumes. */
  void placeNear(Arm arm, ServoJoints joints, std::size_t joint, double outwards) {
    ASSERT_EQ(ask(StateCommand::kPause), ServoRefusal::kNone);
    tick(2);
    joints[joint] -= outwards * 5e-3;
    at(mappers, arm).rebase(control::withServoJoints(config.arms.geometry.home, joints));
    ASSERT_EQ(ask(StateCommand::kResume), ServoRefusal::kNone);
    tick(2);
  }
  /** Sends what is published back, and moves by nothing. */
  void sendBack(Arm arm, const std::string& where) {
    for (const ServoKind kind : {ServoKind::kServoJoints, ServoKind::kMoveJoints}) {
      EXPECT_EQ(askJoints(kind, arm, at(state().arms, arm).setpoint_q), ServoRefusal::kNone) << where;
      tick(300);
    }
    for (const ServoKind kind : {ServoKind::kServoJointsBy, ServoKind::kMoveJointsBy}) {
      EXPECT_EQ(askJoints(kind, arm, {}), ServoRefusal::kNone) << where;
      tick(300);
    }
    for (const ServoKind kind : {ServoKind::kServoPose, ServoKind::kMovePose}) {
      EXPECT_EQ(askBack(kind, arm), ServoRefusal::kNone) << where;
      tick(300);
    }
    EXPECT_EQ(at(state().arms, arm).ended, 0U) << where;
  }
};

TEST_F(ServoCommandsAtALimit, ThatSendASetPointBackAreTaken) {
  enable();
  double beyond = 0.0;
  for (const Arm arm : kArms) {
    for (std::size_t j = 0; j < control::ServoTrim::kJoints; ++j) {
      for (const double outwards : {-1.0, 1.0}) {
        const double limit = (outwards < 0.0 ? config.arms.geometry.q_min : config.arms.geometry.q_max)[j];
        ServoJoints to{0.8, 1.6, 0.35, 0.3, 0.2, 0.1};
        to[j] = limit;
        placeNear(arm, to, j, outwards);
        ASSERT_EQ(askJoints(ServoKind::kMoveJoints, arm, to), ServoRefusal::kNone);
        tick(1000);
        ASSERT_EQ(at(state().arms, arm).is_busy, 0);
        beyond = std::max(beyond, outwards * (at(state().arms, arm).setpoint_q[j] - limit));
        sendBack(arm, std::string(name(arm)) + ", joint " + std::to_string(j) + " at " + std::to_string(limit));
      }
    }
  }
  EXPECT_GT(beyond, 1e-7) << "pose rounding takes set points beyond a limit";
  EXPECT_LT(beyond, control::kBeyondLimit);
}

TEST_F(ServoCommands, OfAMotionThatEndsEarlyAreCounted) {
  enable();
  for (const Arm arm : kArms) {
    EXPECT_EQ(at(state().arms, arm).ended, 0U);
    ServoCommand rates;
    rates.kind = ServoKind::kServoRates;
    rates.arm = arm;
    rates.joints[kWrist] = 1.9;
    for (int i = 0; i < 20; ++i) {
      EXPECT_EQ(ask(rates), ServoRefusal::kNone);
      tick(50);
      if (at(state().arms, arm).ended > 0) break;
    }
    EXPECT_EQ(at(state().arms, arm).ended, 1U) << name(arm);
    EXPECT_EQ(at(state().arms, arm).is_busy, 0);
    EXPECT_NEAR(at(state().arms, arm).setpoint_q[kWrist], config.arms.geometry.q_max[kWrist], 3e-3);
  }
}

TEST_F(ServoCommands, AreRefusedWhileTheModelGoesBackToTheRobot) {
  enable();
  mode = Mode::kReturning;
  pedal_before = pedal;
  tick();
  EXPECT_EQ(ask(StateCommand::kPause), ServoRefusal::kNone);
  EXPECT_EQ(ask(StateCommand::kResume), ServoRefusal::kNone) << "the pedal waits for the end of the return";
  EXPECT_EQ(askPose(ServoKind::kServoPose, {0.01, 0.0, 0.0}), ServoRefusal::kMode);
  EXPECT_EQ(askPose(ServoKind::kMovePose, {0.01, 0.0, 0.0}), ServoRefusal::kMode);
  EXPECT_EQ(ask(ServoCommand{}), ServoRefusal::kNone) << "a hold is accepted";
}

TEST_F(ServoCommands, EndWhenARobotComesThatTheModelMovedWithout) {
  enable();
  EXPECT_EQ(askPose(ServoKind::kMovePose, {0.03, 0.0, 0.0}), ServoRefusal::kNone);
  tick(100);
  EXPECT_EQ(state().alone, 0) << "no robot was there before";
  stand.robot_there = true;
  tick(10);
  EXPECT_EQ(state().state, OperatingState::kEnabled) << "the robot homes";
  stand.robot_ready = stand.robot_homed = true;
  tick();
  EXPECT_EQ(state().state, OperatingState::kPaused);
  EXPECT_FALSE(pedal);
  EXPECT_EQ(state().arms[0].is_busy, 0);
  EXPECT_EQ(ask(StateCommand::kResume), ServoRefusal::kNone);
  stand.linked = true;
  tick(5);
  EXPECT_EQ(state().state, OperatingState::kEnabled);
  EXPECT_EQ(state().alone, 0);
  stand.linked = stand.robot_there = false;
  tick();
  EXPECT_EQ(state().state, OperatingState::kPaused);
  EXPECT_EQ(ask(StateCommand::kResume), ServoRefusal::kNone);
  tick(5);
  EXPECT_EQ(state().alone, 1) << "the robot has left";
  stand.robot_there = true;
  tick();
  EXPECT_EQ(state().state, OperatingState::kPaused) << "the robot is back";
  EXPECT_EQ(state().alone, 0);
}

TEST_F(ServoCommands, OutlastTheCamerasPedalWithARobotToo) {
  stand.robot_there = stand.robot_ready = stand.robot_homed = stand.linked = true;
  enable();
  mode = Mode::kCameraMoving;
  stand.linked = false;
  tick(50);
  EXPECT_EQ(state().state, OperatingState::kEnabled);
  EXPECT_TRUE(pedal);
  mode = Mode::kTeleoperating;
  stand.linked = true;
  stand.applies = false;  // until the robot's pedal is down again
  tick(10);
  stand.applies = true;
  tick(10);
  EXPECT_EQ(state().state, OperatingState::kEnabled);
  EXPECT_EQ(askPose(ServoKind::kServoPose, {0.001, 0.0, 0.0}), ServoRefusal::kNone);
  mode = Mode::kCameraMoving;
  stand.linked = false;
  tick(50);
  mode = Mode::kTeleoperating;  // the robot was lost or disengaged meanwhile
  tick();
  EXPECT_EQ(state().state, OperatingState::kPaused);
}

TEST_F(ServoCommands, LetGoUntilThatIsSeen) {
  enable();
  lost_releases = 10;
  ServoCommand pause;
  pause.kind = ServoKind::kState;
  pause.state = StateCommand::kPause;
  ASSERT_TRUE(shared->servo_commands.tryPush(pause));
  for (int i = 0; i < 11; ++i) {
    EXPECT_TRUE(pedal) << i;
    tick(Heard::kNothing);
    EXPECT_TRUE(made);
  }
  EXPECT_FALSE(pedal);
  tick(Heard::kNothing);
  EXPECT_FALSE(made);
}

TEST_F(ServoCommands, PressAgainOnlyOnceTheReleaseIsSeen) {
  enable();
  lost_releases = 5;
  for (const StateCommand state : {StateCommand::kPause, StateCommand::kResume}) {
    ServoCommand command;
    command.kind = ServoKind::kState;
    command.state = state;
    ASSERT_TRUE(shared->servo_commands.tryPush(command));
  }
  int ticks_until_up = 0;
  for (; pedal && ticks_until_up < 100; ++ticks_until_up)
    tick(Heard::kNothing);
  EXPECT_EQ(ticks_until_up, 6);
  EXPECT_EQ(mode, Mode::kPedalUp);
  tick(2, Heard::kNothing);
  EXPECT_EQ(mode, Mode::kTeleoperating);
}

TEST_F(ServoCommands, ThatStopDoNotWaitBehindAFloodOfMotionsOfEitherArm) {
  enable();
  for (const Arm arm : kArms) {
    ServoCommand move, pause;
    move.kind = ServoKind::kMovePose;
    move.arm = arm;
    move.pose_B = at(state().arms, arm).setpoint_B;
    pause.kind = ServoKind::kState;
    pause.state = StateCommand::kPause;
    while (shared->servo_commands.tryPush(move))
      move.pose_B.p[0] += 1e-4;
    ASSERT_TRUE(shared->servo_commands.tryPush(pause)) << "a full queue of motions does not displace a pause";
    const std::uint64_t before = state().received;
    const Vec3 here = at(state().arms, arm).setpoint_B.p;
    tick();
    EXPECT_EQ(state().state, OperatingState::kPaused);
    EXPECT_FALSE(pedal);
    tick(20);
    EXPECT_EQ(state().received - before, ServoQueue::kMotions + 1);
    EXPECT_EQ(state().refused, 0U) << "the pause ended the moves without a refusal";
    EXPECT_EQ(ask(StateCommand::kResume), ServoRefusal::kNone);
    tick(100);
    EXPECT_EQ(at(state().arms, arm).is_busy, 0) << name(arm);
    EXPECT_LT(tipsApart(at(state().arms, arm).setpoint_B.p, here), 1e-9) << name(arm);
  }
}

TEST_F(ServoCommands, OfMotionBeforeAnEnableAreNotDoneAfterIt) {
  ServoCommand move, enabled;
  move.kind = ServoKind::kMovePose;
  move.pose_B = state().arms[0].setpoint_B;
  move.pose_B.p[0] += 0.01;
  enabled.kind = ServoKind::kState;
  enabled.state = StateCommand::kEnable;
  for (const ServoCommand& command : {move, enabled})
    ASSERT_TRUE(shared->servo_commands.tryPush(command));
  tick(5);
  EXPECT_EQ(refused.reason, ServoRefusal::kNotEnabled) << "the commands count in their order of arrival";
  EXPECT_EQ(state().refused, 1U);
  EXPECT_EQ(mode, Mode::kTeleoperating);
  EXPECT_EQ(state().arms[0].is_busy, 0);
}

TEST_F(ServoCommands, OfMotionBeforeAHoldOfTheirArmAreNotDoneAfterIt) {
  enable();
  for (const Arm arm : kArms) {
    const Arm other = otherArm(arm);
    const auto moveOf = [this](Arm which) {
      ServoCommand move;
      move.kind = ServoKind::kMovePose;
      move.arm = which;
      move.pose_B = at(state().arms, which).setpoint_B;
      move.pose_B.p[0] += 0.01;
      return move;
    };
    ServoCommand hold, hold_other;
    hold.arm = arm;
    hold_other.arm = other;
    for (const ServoCommand& command : {moveOf(arm), moveOf(other), moveOf(arm), hold})
      ASSERT_TRUE(shared->servo_commands.tryPush(command));
    tick(5);
    EXPECT_EQ(at(state().arms, arm).is_busy, 0) << "the hold must end the move of " << name(arm);
    EXPECT_EQ(at(state().arms, other).is_busy, 1) << "the other arm's move goes on";
    for (const ServoCommand& command : {hold, moveOf(arm)})
      ASSERT_TRUE(shared->servo_commands.tryPush(command));
    tick(5);
    EXPECT_EQ(at(state().arms, arm).is_busy, 1) << "the move after the hold must begin on " << name(arm);
    for (const ServoCommand& command : {hold, hold_other})
      ASSERT_TRUE(shared->servo_commands.tryPush(command));
    tick(5);
  }
  EXPECT_EQ(state().refused, 0U);
}

TEST_F(ServoCommands, OfEitherArmAreOverWithTheOrderThatLetsGo) {
  for (const Arm arm : kArms) {
    for (const StateCommand letting_go : {StateCommand::kPause, StateCommand::kDisable}) {
      EXPECT_EQ(ask(state().state == OperatingState::kPaused ? StateCommand::kResume : StateCommand::kEnable),
                ServoRefusal::kNone);
      tick(2);
      ServoCommand move, order;
      move.kind = ServoKind::kMovePose;
      move.arm = arm;
      move.pose_B = at(state().arms, arm).setpoint_B;
      order.kind = ServoKind::kState;
      order.state = letting_go;
      for (const ServoCommand& command : {move, order})
        ASSERT_TRUE(shared->servo_commands.tryPush(command));
      tick(5);
      EXPECT_NE(state().state, OperatingState::kEnabled) << name(arm);
      EXPECT_EQ(state().refused, 0U) << name(arm) << ": the move ended before it was judged";
    }
  }
}

TEST_F(ServoCommands, ThatAreRefusedAtOnceDoNotSlowTheRest) {
  enable();
  ServoCommand move;
  move.kind = ServoKind::kMovePose;
  move.pose_B = state().arms[0].setpoint_B;
  for (std::size_t i = 0; i < ServoQueue::kMotions; ++i)
    ASSERT_TRUE(shared->servo_commands.tryPush(move));
  tick(20);  // the first eight are accepted, the rest are refused at 32 a tick
  EXPECT_EQ(state().refused, ServoQueue::kMotions - control::ServoTarget::kMoves);
  EXPECT_EQ(refused.reason, ServoRefusal::kQueueFull);
}

TEST_F(ServoCommands, ToFreeAreRefusedAsTheStateTheyAmountTo) {
  ServoCommand let_go;
  let_go.kind = ServoKind::kFree;
  EXPECT_EQ(ask(let_go), ServoRefusal::kInvalid);
  EXPECT_EQ(refused.state, StateCommand::kPause);
  EXPECT_EQ(refused.kind, ServoKind::kFree);
}

/** Forces of zero are within any limit, and act like others. */
TEST_F(ServoCommands, OfForcesOnArmAndJawsEndEachAfterItsOwnTime) {
  enable();
  for (const Arm arm : kArms) {
    for (const bool is_arm_first : {true, false}) {
      ServoCommand once, again;
      once.arm = again.arm = arm;
      once.kind = is_arm_first ? ServoKind::kServoForces : ServoKind::kServoJawForce;
      again.kind = is_arm_first ? ServoKind::kServoJawForce : ServoKind::kServoForces;
      const std::uint32_t before = at(state().arms, arm).run_out, other = at(state().arms, otherArm(arm)).run_out;
      EXPECT_EQ(ask(once), ServoRefusal::kNone);
      for (int i = 0; i < 5; ++i) {
        EXPECT_EQ(ask(again), ServoRefusal::kNone);
        tick(30);
      }
      EXPECT_EQ(at(state().arms, arm).run_out, before + 1) << name(arm) << ": 0.1 s after the first";
      tick(100);
      EXPECT_EQ(at(state().arms, arm).run_out, before + 2) << name(arm);
      EXPECT_EQ(at(state().arms, otherArm(arm)).run_out, other) << name(arm);
    }
  }
}

TEST_F(ServoCommands, AreServedInOrderHoweverManyCome) {
  enable();
  ServoCommand command;
  command.kind = ServoKind::kServoPoseBy;
  command.pose_B.p = {5e-5, 0.0, 0.0};
  const double from = tip()[0];
  for (int i = 0; i < 100; ++i)
    ASSERT_TRUE(shared->servo_commands.tryPush(command));
  tick(300);
  EXPECT_NEAR(tip()[0] - from, 100 * 5e-5, 1e-6) << "every increment counts";
  EXPECT_EQ(state().refused, 0U);
}

class ServoCommandsBesideAForce : public ServoCommands, public ::testing::WithParamInterface<bool> {};

/** The force is sent once, or again and again, as clients do. */
TEST_P(ServoCommandsBesideAForce, OfTheJawsGoOn) {
  enable();
  for (const Arm arm : kArms) {
    ServoCommand force, jaws;
    force.arm = jaws.arm = arm;
    force.kind = ServoKind::kServoForces;
    jaws.kind = ServoKind::kMoveJaw;
    jaws.jaw = at(state().arms, arm).setpoint_jaw - 0.03;  // [rad] in 0.2 s, the shortest move
    EXPECT_EQ(ask(force), ServoRefusal::kNone);
    EXPECT_EQ(ask(jaws), ServoRefusal::kNone);
    for (int i = 0; i < 10; ++i) {
      if (GetParam()) EXPECT_EQ(ask(force), ServoRefusal::kNone);
      tick(22);
    }
    EXPECT_NEAR(at(state().arms, arm).setpoint_jaw, jaws.jaw, 0.6e-3) << name(arm);
    EXPECT_EQ(at(state().arms, arm).is_busy, 0) << name(arm);
  }
}

INSTANTIATE_TEST_SUITE_P(Renewed, ServoCommandsBesideAForce, ::testing::Bool());

TEST_F(ServoCommands, OfTheJawsEndWithAForceOnThem) {
  enable();
  for (const Arm arm : kArms) {
    ServoCommand force, jaws;
    force.arm = jaws.arm = arm;
    force.kind = ServoKind::kServoJawForce;
    jaws.kind = ServoKind::kMoveJaw;
    jaws.jaw = at(state().arms, arm).setpoint_jaw - 0.5;
    EXPECT_EQ(ask(jaws), ServoRefusal::kNone);
    tick(20);
    EXPECT_EQ(at(state().arms, arm).is_busy, 1) << name(arm);
    EXPECT_EQ(ask(force), ServoRefusal::kNone);
    tick();
    EXPECT_EQ(at(state().arms, arm).is_busy, 0) << name(arm);
  }
}

TEST_F(ServoCommands, APressRightBehindAClientsReleaseStaysDown) {
  enable();
  ServoCommand pause;
  pause.kind = ServoKind::kState;
  pause.state = StateCommand::kPause;
  ASSERT_TRUE(shared->servo_commands.tryPush(pause));
  tick(Heard::kNothing);
  for (int i = 0; i < 50; ++i) {
    tick(Heard::kDown);
    EXPECT_FALSE(made) << i;
    EXPECT_TRUE(pedal) << i;
  }
}

}  // namespace
}  // namespace raven2_trainer::loop
