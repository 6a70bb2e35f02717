#include "raven2_trainer/loop/physics_loop.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "raven2_trainer/core/fault_variables.h"
#include "raven2_trainer/core/pedals.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"
#include "support/rig.h"

// Tests the physics loop alone, with a robot that is wherever the test says. A rule for one arm, direction or attempt
// also holds for the other.

namespace raven2_trainer::loop {
namespace {

struct Models {
  Models() : config(raven2_trainer::testing::packagedConfig()) {
    config.hazard = "none";
    config.runtime.plan_at = -1.0;
    raven2_trainer::testing::useOde();
    raven = model::loadRavenModel(config);
    scene = model::loadSceneModel(config);
  }
  TrainerConfig config;
  model::RavenModel raven;
  model::SceneModel scene;
};

const Models& models() {
  static const Models shipped;
  return shipped;
}

double apart(const Vec3& a, const Vec3& b) {
  return (toEigen(a) - toEigen(b)).norm();
}

Fault byHand(FaultHost host, FaultVariable variable, FaultKind kind, double value) {
  Fault fault;
  fault.id = 7;
  fault.host = host;
  fault.site = infoOf(variable).site;
  fault.variable = variable;
  fault.kind = kind;
  fault.trigger = FaultTrigger::kHand;
  fault.value = fault.low = fault.high = value;
  return fault;
}

/** A command with the pedal down. */
MasterCommand pressed() {
  MasterCommand command;
  command.pedal = kSurgeonsPedal;
  return command;
}

class LoopBench : public ::testing::Test {
 protected:
  /** Starts with a homed robot and the pedal up. */
  void begin() {
    raven2_trainer::testing::useOde();
    shared = std::make_unique<SharedState>();
    loop = std::make_unique<PhysicsLoop>(config, models().raven, models().scene, shared.get());
    robot = RobotState{};
    robot.connected = robot.is_virtual = robot.homed = 1;
    robot.runlevel = RunLevel::kPedalUp;
    for (RobotArmState& arm : robot.arms)
      arm.q = config.arms.geometry.home;
    last_relay = RelayPacket{};
    follows = {true, true};
    rest(3);
    ASSERT_EQ(mode(), Mode::kPedalUp);
  }
  void SetUp() override { begin(); }

  void tick(MasterCommand command) {
    send(command);
    step();
  }
  void send(MasterCommand command) {
    command.sequence = ++sequence;
    ASSERT_TRUE(shared->master_commands.tryPush(command));
  }
  /** Runs one tick of the loop. */
  void step() {
    now_ns += kTickNanoseconds;
    if (has_robot) sayWhereTheRobotIs();
    loop->tick(now_ns);
    RelayPacket packet;
    while (shared->relay_packets.tryPop(&packet))
      last_relay = packet;
    shared->records.forEach([](RecordKind, auto& ring) { ring.release(ring.tail()); });
  }
  void rest(int ticks) { repeat(MasterCommand{}, ticks); }
  void press(int ticks) { repeat(pressed(), ticks); }
  void repeat(const MasterCommand& command, int ticks) {
    for (int i = 0; i < ticks; ++i)
      tick(command);
  }
  bool waitFor(Mode wanted, int limit = 3000) {
    for (int i = 0; i < limit && mode() != wanted; ++i)
      rest(1);
    return mode() == wanted;
  }

  /** Sends a request with the pedal up. */
  PlanningAnswer ask(RequestKind kind, const std::function<void(Request*)>& fill = {}) {
    return ask(kind, MasterCommand{}, fill);
  }
  PlanningAnswer ask(RequestKind kind, const MasterCommand& hand, const std::function<void(Request*)>& fill = {}) {
    Request request;
    request.kind = kind;
    request.id = ++last_id;
    if (fill) fill(&request);
    EXPECT_TRUE(shared->requests.tryPush(request));
    tick(hand);
    return model().planning.answered == last_id ? model().planning.answer : PlanningAnswer::kNone;
  }

  void fault(const Fault& row) {
    FaultPlan plan;
    plan.generation = ++generation;
    plan.count = 1;
    plan.faults[0] = row;
    shared->faults.store(plan);
  }

  /** Makes a plan for the gold arm, which the model then shows. */
  void plan() {
    ASSERT_EQ(ask(RequestKind::kPlan), PlanningAnswer::kAccepted);
    PlanRequest asked;
    ASSERT_TRUE(shared->plan_requests.tryPop(&asked));
    PlanResult answer;
    answer.id = asked.id;
    answer.status = PlanStatus::kSuccess;
    answer.waypoint_count = 2;
    answer.waypoints[0] = answer.waypoints[1] = asked.start;
    answer.waypoints[1][kShoulder] += 0.02;
    answer.arrival[1] = 0.2;
    answer.clearance = 0.05;
    answer.robot_follows = 1;
    ASSERT_TRUE(shared->plan_results.tryPush(answer));
    rest(1);
    ASSERT_EQ(mode(), Mode::kTracking);
  }

  /** Runs a trial of `ticks` such commands to its end. */
  void trial(const MasterCommand& command, int ticks) {
    ASSERT_EQ(ask(RequestKind::kBeginTrial), PlanningAnswer::kAccepted);
    repeat(command, ticks);
    rest(2);
    ASSERT_EQ(ask(RequestKind::kEndTrial), PlanningAnswer::kAccepted);
    ASSERT_EQ(mode(), Mode::kTrialReady);
  }

  /** Begins to repeat the trial on the robot, with the pedal down. */
  void beginRepeat() {
    ASSERT_EQ(ask(RequestKind::kRepeatTrial, [](Request* r) { r->on_robot = 1; }), PlanningAnswer::kAccepted);
    ASSERT_TRUE(waitFor(Mode::kArmed));
    press(1);
    ASSERT_EQ(mode(), Mode::kExecuting);
  }

  /** A plan on the robot, or a trial's repetition. */
  void execute(bool is_trial) {
    if (is_trial) {
      trial(pressed(), 5);
      beginRepeat();
    } else {
      plan();
      ASSERT_EQ(ask(RequestKind::kExecutePlan, [](Request* r) { r->on_robot = 1; }), PlanningAnswer::kAccepted);
      press(1);
    }
    ASSERT_EQ(mode(), Mode::kExecuting);
  }

  ModelState model() const { return shared->model.load(); }
  Mode mode() const { return model().mode; }
  const ArmState armState(Arm arm) const { return at(model().arms, arm); }
  double opening(Arm arm) const { return kinematics::jawOpening(armState(arm).q_d); }

  TrainerConfig config{models().config};
  std::unique_ptr<SharedState> shared;
  std::unique_ptr<PhysicsLoop> loop;
  RobotState robot;
  RelayPacket last_relay;
  PerArm<bool> follows{true, true};  ///< while it receives pedal-down, the robot's arm is where the model's is
  bool has_robot{true};
  bool obeys{true};  ///< its run level follows the pedal that it receives
  std::uint32_t sequence{0}, last_id{40};
  std::uint64_t generation{100};
  std::int64_t now_ns{0};

 private:
  void sayWhereTheRobotIs() {
    ++robot.cycle;
    ++robot.frame;
    robot.received_ns = robot.time_ns = now_ns;
    const bool is_down = last_relay.command.pedal != 0;
    if (obeys) robot.runlevel = is_down ? RunLevel::kPedalDown : RunLevel::kPedalUp;
    for (const Arm arm : kArms) {
      RobotArmState& state = at(robot.arms, arm);
      if (is_down && at(follows, arm)) state.q = armState(arm).q;
      state.p_BT = toArray(kinematics::forward(config.arms.geometry, arm, state.q).p);
    }
    shared->robot.store(robot);
  }
};

class EitherArm : public LoopBench, public ::testing::WithParamInterface<Arm> {
 protected:
  Arm arm() const { return GetParam(); }
  Arm other() const { return otherArm(GetParam()); }
};

INSTANTIATE_TEST_SUITE_P(Arms, EitherArm, ::testing::ValuesIn(kArms), [](const auto& tested) {
  return std::string(name(tested.param));
});

// ---- where the robot is ------------------------------------------------------------------------------------------

TEST_P(EitherArm, OfARobotThatMovedDuringAReplayIsGoneBackTo) {
  std::uint32_t replays = 0;
  for (std::size_t j = 0; j < kGrasp1; ++j) {
    for (const double share : {-1.5, 0.5, 1.5}) {
      begin();
      ASSERT_EQ(ask(RequestKind::kBeginReplay, [&](Request* r) { r->plan = ++replays; }), PlanningAnswer::kAccepted);
      at(robot.arms, arm()).q[j] += share * config.execution.start_tolerance[j];
      ASSERT_EQ(ask(RequestKind::kEndReplay), PlanningAnswer::kAccepted);
      EXPECT_EQ(mode(), std::abs(share) > 1.0 ? Mode::kReturning : Mode::kPedalUp) << kJointNames[j] << " " << share;
    }
  }
}

TEST_P(EitherArm, OfARobotThatMovedOnTheWayBackIsGoneToAsSlowly) {
  for (const double shift : {-0.008, 0.008}) {
    begin();
    ASSERT_EQ(ask(RequestKind::kBeginSimulation), PlanningAnswer::kAccepted);
    press(3);
    rest(3);
    ASSERT_EQ(ask(RequestKind::kEndSimulation), PlanningAnswer::kAccepted);
    ASSERT_EQ(mode(), Mode::kReturning);
    at(robot.arms, arm()).q[kInsertion] += shift;
    double fastest = 0.0;
    Vec3 before = armState(arm()).p_BT;
    for (int i = 0; i < 3000 && (i < 30 || mode() != Mode::kPedalUp); ++i) {
      rest(1);
      fastest = std::max(fastest, apart(armState(arm()).p_BT, before));
      before = armState(arm()).p_BT;
    }
    EXPECT_NEAR(armState(arm()).q[kInsertion], at(robot.arms, arm()).q[kInsertion], 1e-4) << shift;
    EXPECT_LT(fastest, 0.2e-3) << "the arm jumps at a shift of " << shift;
  }
}

/** With the pedal up the model follows a robot within 0.15 rad of shoulder and elbow, 50 mm of insertion and 0.8 rad of
 *  roll and wrist. It does so at the speeds of hands. */
TEST_P(EitherArm, GoesToARobotThatIsNearAndIsPutToOneThatIsFarOnEitherSide) {
  constexpr std::array<double, kGrasp1> kReach{0.15, 0.15, 0.05, 0.8, 0.8}, kSpeed{0.5, 0.5, 0.1, 3.0, 3.0};
  for (std::size_t j = 0; j < kGrasp1; ++j) {
    for (const double share : {-1.5, -0.5, -0.02, 0.02, 0.5, 1.5}) {
      begin();
      const double aside = share * kReach[j];
      at(robot.arms, arm()).q[j] += aside;
      rest(1);
      const double missing = std::abs(at(robot.arms, arm()).q[j] - armState(arm()).q[j]);
      const double way = std::min(0.1 * std::abs(aside), kSpeed[j] * kTickSeconds);  // one of ten milliseconds
      const double expected = std::abs(share) > 1.0 ? 0.0 : std::abs(aside) - way;
      EXPECT_NEAR(missing, expected, 0.05 * way) << kJointNames[j] << " " << share;
    }
  }
}

TEST_P(EitherArm, ThatMovedSinceThePlanRefusesItsExecution) {
  plan();
  const PerArm<RobotArmState> stood = robot.arms;
  const auto answerWith = [&](const std::function<void(JointArray*)>& move) {
    robot.arms = stood;
    move(&at(robot.arms, arm()).q);
    return ask(RequestKind::kExecutePlan);
  };
  const JointArray& tolerance = config.execution.start_tolerance;
  for (const double share : {-1.5, 1.5}) {
    for (std::size_t j = 0; j < kGrasp1; ++j)
      EXPECT_EQ(answerWith([&](JointArray* q) { (*q)[j] += share * tolerance[j]; }), PlanningAnswer::kMoved)
          << kJointNames[j] << " " << share;
    const auto turnJaws = [&](JointArray* q) {
      kinematics::setJaws(kinematics::jawMidline(*q) + share * tolerance[kGrasp1], kinematics::jawOpening(*q), q);
    };
    EXPECT_EQ(answerWith(turnJaws), PlanningAnswer::kMoved) << "jaws " << share;
  }
  EXPECT_EQ(answerWith([](JointArray*) {}), PlanningAnswer::kAccepted);
}

TEST_P(EitherArm, ThatMovedSinceATrialRefusesItsRepetition) {
  trial(pressed(), 5);
  const PerArm<RobotArmState> stood = robot.arms;
  for (const double share : {-1.5, 1.5}) {
    for (std::size_t j = 0; j < kGrasp1; ++j) {
      robot.arms = stood;
      at(robot.arms, arm()).q[j] += share * config.execution.start_tolerance[j];
      EXPECT_EQ(ask(RequestKind::kRepeatTrial), PlanningAnswer::kMoved) << kJointNames[j] << " " << share;
    }
  }
  robot.arms = stood;
  at(robot.arms, arm()).q[kElbow] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(ask(RequestKind::kRepeatTrial), PlanningAnswer::kMoved) << "the elbow's angle is NaN";
  robot.arms = stood;
  ASSERT_EQ(ask(RequestKind::kRepeatTrial), PlanningAnswer::kAccepted);
  at(robot.arms, arm()).q[kElbow] -= 1.5 * config.execution.start_tolerance[kElbow];
  ASSERT_TRUE(waitFor(Mode::kPedalUp)) << "a robot that moves while the model goes back prevents arming";
  EXPECT_EQ(shared->last_execution.load().end, ExecutionEnd::kMoved);
}

TEST_P(EitherArm, OfARobotThatStillMovesAtTheEndHasNotFinishedARepetition) {
  for (const bool moves : {false, true}) {
    begin();
    trial(pressed(), 5);
    beginRepeat();
    at(robot.arms, arm()).v_BT = {moves ? -2.0 * config.execution.settle_speed : 0.0, 0.0, 0.0};
    for (int i = 0; i < 6000 && mode() == Mode::kExecuting; ++i)
      press(1);
    EXPECT_EQ(shared->last_execution.load().end, moves ? ExecutionEnd::kNotSettled : ExecutionEnd::kFinished);
  }
}

TEST_P(EitherArm, OfARobotThatStaysBehindEndsARepetition) {
  MasterCommand away = pressed();
  away.dp_I = {Vec3{60e-6, 0.0, -20e-6}, Vec3{60e-6, 0.0, -20e-6}};
  trial(away, 350);
  beginRepeat();
  at(follows, arm()) = false;
  for (int i = 0; i < 3000 && mode() == Mode::kExecuting; ++i)
    press(1);
  const ExecutionReport report = shared->last_execution.load();
  EXPECT_EQ(report.end, ExecutionEnd::kOffPath);
  EXPECT_NEAR(report.robot.largest, config.execution.deviation_limit, 1e-3);
  EXPECT_EQ(last_relay.command.pedal, 0);
}

TEST_P(EitherArm, OfARobotThatIsNoLongerAnywhereEndsARepetition) {
  trial(pressed(), 350);
  beginRepeat();
  press(5);
  ASSERT_EQ(mode(), Mode::kExecuting);
  at(follows, arm()) = false;
  at(robot.arms, arm()).q[kElbow] = std::numeric_limits<double>::quiet_NaN();
  press(5);
  EXPECT_NE(mode(), Mode::kExecuting);
  EXPECT_EQ(shared->last_execution.load().end, ExecutionEnd::kOffPath);
  EXPECT_EQ(last_relay.command.pedal, 0);
}

TEST_P(EitherArm, OfTheRobotRepeatsATrialFromItsOwnPlace) {
  at(robot.arms, arm()).q[kElbow] += 0.05;  // the arms are not alike
  rest(300);
  MasterCommand work = pressed();
  work.dp_I = {Vec3{20e-6, 0.0, -10e-6}, Vec3{-10e-6, 0.0, -20e-6}};
  trial(work, 100);
  beginRepeat();
  PerArm<Vector3> sent{toEigen(last_relay.command.dp_I[0]), toEigen(last_relay.command.dp_I[1])};
  for (int i = 0; i < 3000 && mode() == Mode::kExecuting; ++i) {
    press(1);
    for (const Arm each : kArms)
      at(sent, each) += toEigen(at(last_relay.command.dp_I, each));
  }
  EXPECT_EQ(shared->last_execution.load().end, ExecutionEnd::kFinished);
  for (const Arm each : kArms)
    EXPECT_LT((at(sent, each) - 100.0 * toEigen(at(work.dp_I, each))).norm(), 0.2e-3) << name(each);
}

// ---- jaws --------------------------------------------------------------------------------------------------------

TEST_P(EitherArm, ComesBackWithTheJawsWithWhichItLeft) {
  MasterCommand close = pressed();
  close.dgrasp = {0.004, 0.008};
  repeat(close, 50);
  rest(3);
  const double before = opening(arm());
  ASSERT_GT(std::abs(opening(Arm::kGold) - opening(Arm::kGreen)), 0.1) << "the arms' jaws must differ clearly";
  ASSERT_EQ(ask(RequestKind::kBeginSimulation), PlanningAnswer::kAccepted);
  close.dgrasp = {0.004, 0.004};
  repeat(close, 30);
  rest(3);
  ASSERT_LT(opening(arm()), before - 0.1);
  ASSERT_EQ(ask(RequestKind::kEndSimulation), PlanningAnswer::kAccepted);
  ASSERT_TRUE(waitFor(Mode::kPedalUp));
  EXPECT_NEAR(opening(arm()), before, 1e-9);
}

TEST_P(EitherArm, KeepsItsJawsAsTheyAreWhenItJoinsTheRobot) {
  MasterCommand close = pressed();
  at(close.dgrasp, arm()) = 0.01;
  repeat(close, 50);
  rest(100);
  const double held = kinematics::jawOpening(armState(arm()).q);
  kinematics::setJaws(0.0, held + 0.5, &at(robot.arms, arm()).q);  // the robot's jaws have opened
  rest(1);
  press(1);
  EXPECT_EQ(model().linked, 1);
  EXPECT_NEAR(kinematics::jawOpening(armState(arm()).q), held, 0.02);
}

TEST_P(EitherArm, OfTheRobotIsToldWhatItsOwnJawsDidInATrial) {
  MasterCommand close = pressed();
  close.dgrasp = {0.01, 0.006};
  repeat(close, 30);  // away from their stop, and not alike
  rest(3);
  MasterCommand work = pressed();
  work.dgrasp = {0.004, -0.002};
  trial(work, 40);
  beginRepeat();
  double told = at(last_relay.command.dgrasp, arm());
  for (int i = 0; i < 3000 && mode() == Mode::kExecuting; ++i) {
    press(1);
    told += at(last_relay.command.dgrasp, arm());
  }
  EXPECT_EQ(shared->last_execution.load().end, ExecutionEnd::kFinished);
  EXPECT_NEAR(told, 40 * at(work.dgrasp, arm()), 1e-3);
}

// ---- a goal ------------------------------------------------------------------------------------------------------

TEST_P(EitherArm, IsTheOneForWhichAGoalIsChosen) {
  const PerArm<ArmState> stood = model().arms;
  ASSERT_EQ(ask(RequestKind::kBeginPlanning, [this](Request* r) { r->arm = arm(); }), PlanningAnswer::kAccepted);
  MasterCommand move = pressed();
  move.dp_I = {Vec3{20e-6, 0.0, -20e-6}, Vec3{20e-6, 0.0, -20e-6}};
  move.dgrasp = {0.002, 0.002};
  repeat(move, 200);
  rest(2);
  const JointArray chosen = armState(arm()).q;
  EXPECT_GT(apart(armState(arm()).p_BT, at(stood, arm()).p_BT), 5e-3);
  EXPECT_LT(apart(armState(other()).p_BT, at(stood, other()).p_BT), 1e-6) << "the other arm does not move";
  EXPECT_NEAR(kinematics::jawOpening(chosen), kinematics::jawOpening(at(stood, arm()).q), 2e-3)
      << "the jaws keep their opening";
  ASSERT_EQ(ask(RequestKind::kRecordGoal), PlanningAnswer::kAccepted);
  PlanRequest asked;
  ASSERT_TRUE(shared->plan_requests.tryPop(&asked));
  EXPECT_EQ(asked.arm, arm());
  for (std::size_t j = 0; j < kGrasp1; ++j) {
    EXPECT_NEAR(asked.goal_q[j], chosen[j], 1e-9) << kJointNames[j];
    EXPECT_NEAR(asked.start[j], at(stood, arm()).q[j], 1e-4) << kJointNames[j];
    EXPECT_NEAR(asked.other[j], at(stood, other()).q[j], 1e-4) << kJointNames[j];
  }
  EXPECT_LT(apart(armState(arm()).p_BT, at(stood, arm()).p_BT), 0.1e-3) << "the arm is back at its start";
}

// ---- published state --------------------------------------------------------------------------------------------

TEST_P(EitherArm, MovesWithTheRatesThatItTells) {
  MasterCommand move = pressed();
  at(move.dp_I, arm()) = {20e-6, -10e-6, 15e-6};
  at(move.dq_I, arm()) = toArray(Quaternion(Eigen::AngleAxisd(0.001, Vector3::UnitY())));
  repeat(move, 60);
  const ArmState before = armState(arm());
  repeat(move, 1);
  const ArmState now = armState(arm());
  const Vector3 by_difference = (toEigen(now.p_BT) - toEigen(before.p_BT)) / kTickSeconds;
  ASSERT_GT(by_difference.norm(), 0.01) << "[m/s] the arm must move";
  EXPECT_LT((toEigen(now.v_BT) - by_difference).norm(), 0.05 * by_difference.norm());
  EXPECT_LT(toEigen(armState(other()).v_BT).norm(), 0.1 * by_difference.norm());
  const Matrix3 R = kinematics::forward(config.arms.geometry, arm(), now.q).R;
  EXPECT_LT((toEigen(now.q_BT).toRotationMatrix() - R).norm(), 1e-9);
}

TEST_P(EitherArm, AloneIsTheOneWhoseTorquesChange) {
  rest(50);
  const PerArm<ArmState> still = model().arms;
  MasterCommand push = pressed();
  at(push.dp_I, arm()) = {0.0, 0.0, 200e-6};
  repeat(push, 10);
  const auto change = [&](Arm which) {
    double largest = 0.0;
    for (std::size_t j = 0; j < kGrasp1; ++j)
      largest = std::max(largest, std::abs(armState(which).tau[j] - at(still, which).tau[j]));
    return largest;
  };
  EXPECT_GT(change(arm()), 10.0 * change(other()));
}

TEST_P(EitherArm, AtItsLimitIsToldSo) {
  MasterCommand back = pressed();
  at(back.dp_I, arm()) = {-100e-6, 0.0, 0.0};  // ITP x points forward
  for (int i = 0; i < 1000 && shared->ik_clamped.value() == 0; ++i)
    tick(back);
  EXPECT_GT(shared->ik_clamped.value(), 0U);
  EXPECT_EQ(armState(arm()).ik_status, static_cast<std::uint32_t>(kinematics::IkStatus::kClamped));
  EXPECT_EQ(armState(other()).ik_status, static_cast<std::uint32_t>(kinematics::IkStatus::kOk));
}

TEST_P(EitherArm, MeetsTheSceneUnlessItsOwnCollisionsAreOff) {
  for (const Arm passes : kArms) {
    begin();
    ask(RequestKind::kSetCollisions, [&](Request* r) { r->arm = passes, r->enabled = 0; });
    MasterCommand down = pressed();
    at(down.dp_I, arm()) = {0.0, 0.0, 80e-6};
    std::uint32_t own = 0, others = 0;
    for (int i = 0; i < 900 && own == 0; ++i) {
      tick(down);
      own += armState(arm()).contacts;
      others += armState(other()).contacts;
    }
    EXPECT_EQ(own > 0, passes != arm()) << "collisions are off for " << name(passes);
    EXPECT_EQ(others, 0U);
  }
}

TEST_P(EitherArm, OfTheHandIsCountedWhereverThePedalIsButForClients) {
  const Vec3 step{3e-6, -2e-6, 1e-6};
  MasterCommand move;
  at(move.dp_I, arm()) = step;
  const PerArm<Vec3> before = model().master_I;
  repeat(move, 4);
  move.pedal = kSurgeonsPedal;
  repeat(move, 4);
  for (std::size_t axis = 0; axis < 3; ++axis)
    EXPECT_NEAR(at(model().master_I, arm())[axis], at(before, arm())[axis] + 8 * step[axis], 1e-12);
  EXPECT_EQ(at(model().master_I, other()), at(before, other()));
  rest(3);
  const PerArm<Vec3> hands = model().master_I;
  move.pedal = kClientsPedal;
  repeat(move, 4);
  EXPECT_EQ(model().master_I, hands) << "a client moves the tips, but no hand";
}

// ---- more than one command in a tick -----------------------------------------------------------------------------

/** Queues commands and records how many of them each of the next ticks consumes. */
class Backlog : public EitherArm {
 protected:
  std::vector<std::uint32_t> taken(const MasterCommand& command, int count) {
    for (int i = 0; i < count; ++i)
      send(command);
    std::vector<std::uint32_t> all;
    for (int i = 0; i < 3; ++i) {
      step();
      all.push_back(model().commands_used);
      checkSize();
    }
    return all;
  }

  /** Checks that one packet to the robot holds no more motion than the robot accepts in one. */
  void checkSize() const {
    const MasterCommand& sent = last_relay.command;
    for (const Arm each : kArms) {
      for (const double dp : at(sent.dp_I, each))
        EXPECT_LE(std::abs(dp), 1e-6 * config.network.itp.max_increment_um + 1e-12);
      EXPECT_NEAR(toEigen(at(sent.dq_I, each)).norm(), 1.0, 1e-9);
      const double angle = toEigen(at(sent.dq_I, each)).angularDistance(Quaternion::Identity());
      EXPECT_LE(angle, config.network.itp.max_rotation + 1e-9);
    }
  }

  void SetUp() override {
    begin();
    press(3);
  }
};

INSTANTIATE_TEST_SUITE_P(Arms, Backlog, ::testing::ValuesIn(kArms), [](const auto& tested) {
  return std::string(name(tested.param));
});

using Ticks = std::vector<std::uint32_t>;

TEST_P(Backlog, IsTakenAsFastAsOnePacketMayMove) {
  const double most = 1e-6 * config.network.itp.max_increment_um;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const double sign : {-1.0, 1.0}) {
      MasterCommand command = pressed();
      at(command.dp_I, arm())[axis] = sign * 0.6 * most;
      EXPECT_EQ(taken(command, 3), (Ticks{1, 1, 1})) << axis << " " << sign;
      at(command.dp_I, arm())[axis] = -sign * 0.3 * most;
      EXPECT_EQ(taken(command, 3), (Ticks{3, 0, 0})) << axis << " " << sign;
    }
  }
}

TEST_P(Backlog, IsTakenAsFastAsOnePacketMayTurnWhicheverSignItsQuaternionsHave) {
  const double most = config.network.itp.max_rotation;
  const auto turn = [](double angle, double sign) {
    const Quaternion q(Eigen::AngleAxisd(angle, Vector3(0.6, 0.0, 0.8)));
    return Quat{sign * q.x(), sign * q.y(), sign * q.z(), sign * q.w()};
  };
  for (const double direction : {-1.0, 1.0}) {
    for (const double sign : {-1.0, 1.0}) {  // q and -q are the same rotation
      MasterCommand command = pressed();
      at(command.dq_I, arm()) = turn(direction * 0.6 * most, sign);
      EXPECT_EQ(taken(command, 3), (Ticks{1, 1, 1})) << direction << " " << sign;
      at(command.dq_I, arm()) = turn(-direction * 0.3 * most, sign);
      EXPECT_EQ(taken(command, 3), (Ticks{3, 0, 0})) << direction << " " << sign;
    }
  }
}

TEST_P(Backlog, OfRotationsIsTheirProductInTheirOrder) {
  const Quaternion first(Eigen::AngleAxisd(0.04, Vector3::UnitX())), second(Eigen::AngleAxisd(0.04, Vector3::UnitY()));
  MasterCommand command = pressed();
  at(command.dq_I, arm()) = toArray(first);
  send(command);
  at(command.dq_I, arm()) = toArray(second);
  send(command);
  step();
  ASSERT_EQ(model().commands_used, 2U);
  const Quaternion told = toEigen(at(last_relay.command.dq_I, arm()));
  EXPECT_LT(told.angularDistance(second * first), 1e-9) << "both rotations are about the console's axes";
  EXPECT_EQ(at(last_relay.command.dq_I, other()), kIdentityQuat);
}

// ---- faults ------------------------------------------------------------------------------------------------------

TEST_P(EitherArm, IsNotTurnedByAQuaternionThatAFaultLeftWithoutADirection) {
  for (const double factor : {0.0, 1e200, std::numeric_limits<double>::quiet_NaN()}) {
    begin();
    MasterCommand turning = pressed();
    turning.dq_I.fill(toArray(Quaternion(Eigen::AngleAxisd(0.01, Vector3::UnitY()))));
    repeat(turning, 3);
    Fault scaled = byHand(FaultHost::kMaster, FaultVariable::kQuaternion, FaultKind::kScale, factor);
    scaled.arm = static_cast<std::int8_t>(index(arm()));
    fault(scaled);
    repeat(turning, 3);
    EXPECT_EQ(model().faults.active, scaled.id) << "the fault of the master's stream is active";
    EXPECT_EQ(at(last_relay.command.dq_I, arm()), kIdentityQuat) << factor;
    EXPECT_LT(toEigen(at(last_relay.command.dq_I, other())).angularDistance(toEigen(turning.dq_I[0])), 1e-9);
    for (const double q : armState(arm()).q)
      EXPECT_TRUE(std::isfinite(q)) << factor;
  }
}

TEST_P(EitherArm, HasItsOwnFaultsOfTheForce) {
  Fault gain = byHand(FaultHost::kConsole, FaultVariable::kForceGain, FaultKind::kStuckAt, -2.0);
  gain.arm = static_cast<std::int8_t>(index(arm()));
  fault(gain);
  rest(2);
  EXPECT_EQ(at(model().faults.force_gain, arm()), -2.0);
  EXPECT_EQ(at(model().faults.force_gain, other()), 1.0);
  EXPECT_EQ(model().faults.active, gain.id) << "the fault of the console is active";
  Fault offset = byHand(FaultHost::kConsole, FaultVariable::kForceOffset, FaultKind::kAdd, 1.5);
  offset.arm = gain.arm;
  offset.channel = 2;
  fault(offset);
  rest(2);
  EXPECT_EQ(at(model().faults.force_offset_B, arm()), (Vec3{0.0, 0.0, 1.5}));
  EXPECT_EQ(at(model().faults.force_offset_B, other()), Vec3{});
  EXPECT_EQ(at(model().faults.force_gain, arm()), 1.0) << "the fault before has ended";
}

TEST_F(LoopBench, APictureFaultIsOneThatThereIs) {
  const auto shown = [this](FaultVariable variable, double value) {
    fault(byHand(FaultHost::kConsole, variable, FaultKind::kStuckAt, value));
    rest(2);
    return model().faults;
  };
  EXPECT_EQ(shown(FaultVariable::kPicture, 2).picture, 2);
  EXPECT_EQ(shown(FaultVariable::kPicture, 200).picture, kPictureFaultCount - 1);
  EXPECT_EQ(shown(FaultVariable::kPicture, -3).picture, 0);
  EXPECT_EQ(shown(FaultVariable::kPictureDelay, 300).picture_delay_ms, 300U);
  EXPECT_EQ(shown(FaultVariable::kPictureDelay, 1e6).picture_delay_ms, 5000U);
  EXPECT_EQ(shown(FaultVariable::kPictureDelay, -300).picture_delay_ms, 0U);
}

TEST_F(LoopBench, WhatAFaultHeldBackOfAVirtualRobotsMotionIsNotForARealOne) {
  MasterCommand move = pressed();
  move.dp_I[0] = {50e-6, 0.0, 0.0};
  press(3);
  fault(byHand(FaultHost::kMaster, FaultVariable::kPacket, FaultKind::kDelay, 40));
  repeat(move, 20);
  robot.is_virtual = 0;
  for (int i = 0; i < 60; ++i) {
    press(1);
    EXPECT_EQ(last_relay.command.dp_I[0], Vec3{}) << i;
  }
}

TEST_F(LoopBench, ACommandThatAFaultHoldsBackIsNotUsedYet) {
  press(3);
  EXPECT_EQ(loop->newestCommand(), sequence);
  fault(byHand(FaultHost::kMaster, FaultVariable::kPacket, FaultKind::kDelay, 40));
  press(20);
  EXPECT_LT(loop->newestCommand(), sequence - 10);
  press(40);
  EXPECT_EQ(loop->newestCommand(), sequence - 40);
}

TEST_F(LoopBench, NorIsWhatAFaultHeldBackOfItsOwnPackets) {
  MasterCommand move = pressed();
  move.dp_I[0] = {50e-6, 0.0, 0.0};
  press(3);
  fault(byHand(FaultHost::kRelay, FaultVariable::kPacket, FaultKind::kDelay, 40));
  repeat(move, 20);
  robot.is_virtual = 0;
  for (int i = 0; i < 60; ++i) {
    press(1);
    EXPECT_EQ(last_relay.command.dp_I[0], Vec3{}) << i;
  }
}

// ---- another robot, another attempt ------------------------------------------------------------------------------

TEST_F(LoopBench, TheRelaysNumbersGoOnFromThoseThatTheRobotKnows) {
  press(20);
  for (const std::uint32_t known : {5U, 70000U}) {
    robot.connected = 0;
    rest(5);
    robot.connected = 1;
    robot.cycle = 0;  // another robot
    robot.last_sequence = known;
    rest(1);
    EXPECT_EQ(last_relay.command.sequence, known + 1);
    rest(1);
    EXPECT_EQ(last_relay.command.sequence, known + 2);
  }
}

TEST_F(LoopBench, ARobotThatRestartedBetweenTwoTicksIsLetGoUntilTheNextPress) {
  press(20);
  ASSERT_EQ(model().linked, 1);
  robot.cycle = 0;  // homed, its pedal down like the robot's before
  press(1);
  EXPECT_EQ(model().linked, 0);
  press(5);
  EXPECT_EQ(model().linked, 0);
  EXPECT_EQ(last_relay.command.pedal, 0) << "it needs a new pedal-down";
}

TEST_F(LoopBench, APlanArmedAgainWaitsForThePedalAsLongAsTheFirst) {
  config.execution.pedal_timeout = 0.05;
  begin();
  for (int attempt = 0; attempt < 3; ++attempt) {
    plan();
    ASSERT_EQ(ask(RequestKind::kExecutePlan), PlanningAnswer::kAccepted);
    rest(40);
    EXPECT_EQ(mode(), Mode::kArmed) << attempt;
    if (attempt < 2) ask(RequestKind::kCancelPlan);
  }
  rest(20);
  EXPECT_EQ(shared->last_execution.load().end, ExecutionEnd::kNoPedal);
}

TEST_F(LoopBench, APlanForTheRobotThatNobodyPressedForIsKept) {
  config.execution.pedal_timeout = 0.05;
  begin();
  plan();
  for (int attempt = 0; attempt < 2; ++attempt) {
    ASSERT_EQ(ask(RequestKind::kExecutePlan, [](Request* r) { r->on_robot = 1; }), PlanningAnswer::kAccepted);
    rest(60);
    EXPECT_EQ(shared->last_execution.load().end, ExecutionEnd::kNoPedal);
    EXPECT_EQ(model().planning.status, PlanningStatus::kReady) << "the robot has not moved";
  }
}

TEST_F(LoopBench, APlanIsNotFinishedBeforeTheRobotRests) {
  for (const bool moves : {false, true}) {
    begin();
    plan();
    ASSERT_EQ(ask(RequestKind::kExecutePlan, [](Request* r) { r->on_robot = 1; }), PlanningAnswer::kAccepted);
    robot.arms[0].v_BT = {0.0, moves ? 2.0 * config.execution.settle_speed : 0.0, 0.0};
    press(1);
    for (int i = 0; i < 6000 && mode() == Mode::kExecuting; ++i)
      press(1);
    EXPECT_EQ(shared->last_execution.load().end, moves ? ExecutionEnd::kNotSettled : ExecutionEnd::kFinished);
  }
}

TEST_F(LoopBench, PlansThatWereAnsweredAreNotCountedAsUnderWay) {
  for (int i = 0; i < 100; ++i)
    ASSERT_NO_FATAL_FAILURE(plan()) << i;
}

TEST_F(LoopBench, TheSessionsClockStartsWithTheFirstPedalDownThatMovesAnything) {
  for (const RequestKind kind : {RequestKind::kNone, RequestKind::kBeginSimulation, RequestKind::kBeginTrial}) {
    begin();
    if (kind != RequestKind::kNone) ASSERT_EQ(ask(kind), PlanningAnswer::kAccepted);
    rest(5);
    EXPECT_EQ(model().session_tick, -1);
    press(4);
    EXPECT_EQ(model().session_tick, 3) << static_cast<int>(kind);
  }
}

TEST_F(LoopBench, ATrialArmedAgainWaitsForThePedalAsLongAsTheFirst) {
  config.execution.pedal_timeout = 0.05;
  begin();
  for (int attempt = 0; attempt < 3; ++attempt) {
    trial(pressed(), 5);
    ASSERT_EQ(ask(RequestKind::kRepeatTrial), PlanningAnswer::kAccepted);
    ASSERT_TRUE(waitFor(Mode::kArmed));
    rest(40);
    EXPECT_EQ(mode(), Mode::kArmed) << attempt;
    if (attempt == 2) break;
    ask(RequestKind::kCancelPlan);
    ASSERT_TRUE(waitFor(Mode::kPedalUp));
  }
  rest(20);
  EXPECT_EQ(shared->last_execution.load().end, ExecutionEnd::kNoPedal);
}

TEST_F(LoopBench, ATrialHoldsNothingOfTheOneBefore) {
  for (const int ticks : {30, 10, 20}) {
    trial(pressed(), ticks);
    EXPECT_EQ(model().trial_ticks, static_cast<std::uint32_t>(ticks));
    ASSERT_EQ(ask(RequestKind::kDiscardTrial), PlanningAnswer::kAccepted);
    ASSERT_TRUE(waitFor(Mode::kPedalUp));
    EXPECT_EQ(model().trial_ticks, 0U);
  }
}

TEST_F(LoopBench, AReplayBeginsWithWhatThereIsAndEndsWithIt) {
  has_robot = false;
  robot.connected = 0;
  shared->robot.store(robot);
  rest(3);
  const ModelState before = model();
  const auto beginReplay = [&](std::uint32_t number) {
    return ask(RequestKind::kBeginReplay, [&](Request* r) { r->plan = number; });
  };
  ReplayFrame frame;
  frame.replay = 1;
  frame.bodies_W = before.bodies;
  frame.bodies_W[0].p[0] += 0.1;
  for (const Arm arm : kArms) {
    at(frame.q, arm) = at(before.arms, arm).q;
    at(frame.q, arm)[kElbow] += 0.2;
  }
  ASSERT_TRUE(shared->replay_frames.tryPush(frame));
  ASSERT_EQ(beginReplay(1), PlanningAnswer::kAccepted);
  rest(2);
  EXPECT_EQ(model().bodies[0].p, frame.bodies_W[0].p);
  const auto expectStood = [&](const char* when) {
    for (const Arm arm : kArms)
      EXPECT_NEAR(armState(arm).q[kElbow], at(before.arms, arm).q[kElbow], 1e-3) << name(arm) << " " << when;
    EXPECT_LT(apart(model().bodies[0].p, before.bodies[0].p), 1e-3) << when;
  };
  ASSERT_EQ(ask(RequestKind::kEndReplay), PlanningAnswer::kAccepted);
  expectStood("once it is over");
  ASSERT_EQ(beginReplay(2), PlanningAnswer::kAccepted);
  ASSERT_EQ(mode(), Mode::kReplaying);
  expectStood("until the first frame of the next one comes");
}

// ---- a robot that comes while the model is away ------------------------------------------------------------------

TEST_P(EitherArm, OfTheModelGoesBackBeforeAPressDuringAPlanCounts) {
  robot.connected = 0;
  MasterCommand forward = pressed();
  at(forward.dp_I, arm()) = {20e-6, 0.0, -10e-6};
  repeat(forward, 400);  // the model alone
  rest(100);
  ASSERT_EQ(ask(RequestKind::kPlan), PlanningAnswer::kAccepted);
  robot.connected = 1;
  rest(3);
  ASSERT_EQ(mode(), Mode::kPlanning);
  Vec3 before = armState(arm()).p_BT;
  ASSERT_GT(apart(before, at(robot.arms, arm()).p_BT), 5e-3);
  double largest = 0.0;
  for (int i = 0; i < 3000 && mode() != Mode::kTeleoperating; ++i) {
    press(1);
    largest = std::max(largest, apart(armState(arm()).p_BT, before));
    before = armState(arm()).p_BT;
  }
  EXPECT_EQ(mode(), Mode::kTeleoperating);
  EXPECT_EQ(model().linked, 1);
  EXPECT_LT(largest, 0.5e-3) << "the model does not jump";
  EXPECT_EQ(model().planning.status, PlanningStatus::kIdle) << "the pedal gave the plan up";
}

TEST_P(EitherArm, OfTheModelGoesBackBeforeATrialBegins) {
  robot.connected = 0;
  MasterCommand forward = pressed();
  at(forward.dp_I, arm()) = {20e-6, 0.0, -10e-6};
  repeat(forward, 400);  // the model alone
  rest(100);
  ASSERT_EQ(mode(), Mode::kPedalUp);
  robot.connected = 1;
  EXPECT_EQ(ask(RequestKind::kBeginTrial), PlanningAnswer::kNotNow) << "in the very tick in which the robot comes";
  EXPECT_EQ(mode(), Mode::kReturning);
  ASSERT_TRUE(waitFor(Mode::kPedalUp));
  EXPECT_EQ(ask(RequestKind::kBeginTrial), PlanningAnswer::kAccepted);
}

TEST_P(EitherArm, PassesThroughTheSceneWithARobotThatHomesWhateverTheMode) {
  for (const bool moves_camera : {false, true}) {
    begin();
    obeys = true;
    robot.connected = 0;
    MasterCommand down = pressed();
    at(down.dp_I, arm()) = {0.0, 0.0, 80e-6};
    for (int i = 0; i < 900 && armState(arm()).contacts == 0; ++i)
      tick(down);
    ASSERT_GT(armState(arm()).contacts, 0U);
    repeat(down, 50);
    const JointArray deep = armState(arm()).q_d;
    rest(3);
    ASSERT_EQ(mode(), Mode::kPedalUp);
    // another robot, which searches its stops where the scene is
    obeys = false;
    robot.connected = 1;
    robot.homed = 0;
    robot.runlevel = RunLevel::kInit;
    at(robot.arms, arm()).q = deep;
    rest(1);
    std::uint32_t touched = armState(arm()).contacts;
    if (moves_camera) ask(RequestKind::kSetCameraPedal, [](Request* r) { r->enabled = 1; });
    ASSERT_EQ(mode(), moves_camera ? Mode::kCameraMoving : Mode::kPedalUp);
    for (int i = 0; i < 100; ++i) {
      rest(1);
      touched += armState(arm()).contacts;
    }
    EXPECT_EQ(touched, 0U);
    // homed, it is met again
    robot.homed = 1;
    robot.runlevel = RunLevel::kPedalUp;
    for (int i = 0; i < 20; ++i) {
      rest(1);
      touched += armState(arm()).contacts;
    }
    EXPECT_GT(touched, 0U);
  }
}

// ---- stops and homing --------------------------------------------------------------------------------------------

TEST_F(LoopBench, TwoStopsAreClearedOneByOneInEitherOrder) {
  for (const bool operator_first : {true, false}) {
    begin();
    obeys = false;
    robot.runlevel = RunLevel::kEStop;
    rest(2);
    ASSERT_EQ(mode(), Mode::kStopped);
    ASSERT_EQ(ask(RequestKind::kEmergencyStop), PlanningAnswer::kAccepted);
    const auto operatorClears = [this] { EXPECT_EQ(ask(RequestKind::kClearStop), PlanningAnswer::kAccepted); };
    const auto robotClears = [this] {
      robot.runlevel = RunLevel::kPedalUp;
      rest(2);
    };
    operator_first ? operatorClears() : robotClears();
    EXPECT_EQ(mode(), Mode::kStopped) << "the other stop remains";
    operator_first ? robotClears() : operatorClears();
    EXPECT_EQ(mode(), Mode::kPedalUp);
    obeys = true;
  }
}

TEST_F(LoopBench, AStopOfTheRobotThatCameBehindOursIsNotClearedWithOurs) {
  begin();
  ASSERT_EQ(ask(RequestKind::kEmergencyStop), PlanningAnswer::kAccepted);
  obeys = false;
  robot.runlevel = RunLevel::kEStop;
  rest(2);
  EXPECT_EQ(ask(RequestKind::kClearStop), PlanningAnswer::kAccepted);
  EXPECT_EQ(mode(), Mode::kStopped) << "in this tick, too";
  rest(2);
  EXPECT_EQ(mode(), Mode::kStopped);
  robot.runlevel = RunLevel::kPedalUp;
  rest(2);
  EXPECT_EQ(mode(), Mode::kPedalUp);
}

TEST_F(LoopBench, AStopWhileTheRobotHomesLeavesNothingBehind) {
  shared->model.store(ModelState{});
  loop = std::make_unique<PhysicsLoop>(config, models().raven, models().scene, shared.get());
  obeys = false;
  robot.homed = 0;
  for (const RunLevel level : {RunLevel::kEStop, RunLevel::kInit, RunLevel::kEStop, RunLevel::kInit}) {
    robot.runlevel = level;
    for (int i = 0; i < 5; ++i) {
      tick(i < 3 ? pressed() : MasterCommand{});
      EXPECT_EQ(mode(), Mode::kWaiting);
      EXPECT_EQ(last_relay.command.pedal, 0);
    }
  }
  robot.homed = 1;
  robot.runlevel = RunLevel::kPedalUp;
  rest(1);
  EXPECT_EQ(mode(), Mode::kPedalUp);
  obeys = true;
  press(2);
  EXPECT_EQ(mode(), Mode::kTeleoperating);
  EXPECT_EQ(model().linked, 1);
}

TEST_F(LoopBench, ARobotThatIsNoLongerHomedIsNotMovedBeforeItIsAgain) {
  obeys = false;
  robot.homed = 0;
  robot.runlevel = RunLevel::kInit;
  rest(3);
  press(3);
  EXPECT_EQ(model().pedal, 0) << "the pedal-down waits for the homing";
  EXPECT_EQ(last_relay.command.pedal, 0);
  robot.homed = 1;
  robot.runlevel = RunLevel::kPedalUp;
  rest(3);
  press(1);
  EXPECT_EQ(model().linked, 1);
}

TEST_F(LoopBench, NothingBeginsWhileTheRobotHomes) {
  obeys = false;
  robot.homed = 0;
  robot.runlevel = RunLevel::kInit;
  rest(3);
  for (const RequestKind kind : {RequestKind::kBeginSimulation, RequestKind::kBeginTrial, RequestKind::kBeginPlanning,
                                 RequestKind::kBeginReplay}) {
    EXPECT_EQ(ask(kind, [](Request* r) { r->plan = 1; }), PlanningAnswer::kNotNow) << static_cast<int>(kind);
    EXPECT_EQ(mode(), Mode::kPedalUp) << static_cast<int>(kind);
  }
}

TEST_F(LoopBench, ARobotThatFallsBelowPedalUpIsLetGoUntilTheNextPress) {
  press(5);
  ASSERT_EQ(model().linked, 1);
  obeys = false;
  robot.runlevel = RunLevel::kInit;
  press(1);
  EXPECT_EQ(model().linked, 0);
  EXPECT_EQ(last_relay.command.pedal, 0);
  robot.runlevel = RunLevel::kPedalDown;
  press(5);
  EXPECT_EQ(last_relay.command.pedal, 0) << "it needs a new pedal-down";
}

TEST_F(LoopBench, AnInstrumentIsChangedWithThePedalUpAlone) {
  press(5);
  EXPECT_EQ(ask(RequestKind::kToolChange, pressed()), PlanningAnswer::kNotNow);
  rest(5);
  EXPECT_EQ(model().faults.signals.tool_changes, 0U);
  EXPECT_EQ(ask(RequestKind::kToolChange), PlanningAnswer::kAccepted);
  rest(2);
  EXPECT_EQ(model().faults.signals.tool_changes, 1U);
}

// ---- the camera --------------------------------------------------------------------------------------------------

TEST_F(LoopBench, EachHandMovesTheCameraHalfAsFarAsBoth) {
  const auto eyeMovedBy = [this](double gold, double green) {
    begin();
    ask(RequestKind::kSetCameraPedal, [](Request* r) { r->enabled = 1; });
    EXPECT_EQ(mode(), Mode::kCameraMoving);
    const Vec3 before = model().camera.eye_W;
    MasterCommand move;
    move.dp_I = {Vec3{0.0, gold, 0.0}, Vec3{0.0, green, 0.0}};
    repeat(move, 50);
    return apart(model().camera.eye_W, before);
  };
  const double both = eyeMovedBy(20e-6, 20e-6);
  ASSERT_GT(both, 1e-3);
  EXPECT_NEAR(eyeMovedBy(20e-6, 0.0), both / 2.0, 0.01 * both);
  EXPECT_NEAR(eyeMovedBy(0.0, 20e-6), both / 2.0, 0.01 * both);
  EXPECT_NEAR(eyeMovedBy(20e-6, -20e-6), 0.0, 1e-9) << "hands in opposite directions hold the camera";
}

TEST_F(LoopBench, TheCamerasPedalGoesBackToWhatItCameFrom) {
  const auto camera = [this](bool down, const MasterCommand& hand) {
    ask(RequestKind::kSetCameraPedal, hand, [&](Request* r) { r->enabled = down ? 1 : 0; });
  };
  const std::map<RequestKind, std::pair<Mode, Mode>> alone{
      {RequestKind::kBeginSimulation, {Mode::kSimulationHeld, Mode::kSimulating}},
      {RequestKind::kBeginTrial, {Mode::kTrialHeld, Mode::kTrial}}};
  for (const auto& [kind, modes] : alone) {
    for (const bool is_down : {false, true}) {
      begin();
      ASSERT_EQ(ask(kind), PlanningAnswer::kAccepted);
      const MasterCommand hand = is_down ? pressed() : MasterCommand{};
      repeat(hand, 2);
      const Mode before = is_down ? modes.second : modes.first;
      ASSERT_EQ(mode(), before);
      camera(true, hand);
      ASSERT_EQ(mode(), Mode::kCameraMoving);
      repeat(hand, 3);
      camera(false, hand);
      EXPECT_EQ(mode(), before) << kModeNames[static_cast<std::size_t>(before)];
    }
  }
}

/** The robot is there, and never goes to PEDAL_DN. */
TEST_F(LoopBench, WhatIsExecutedIsGivenUpWhereTheRobotDoesNotTakeThePedal) {
  config.execution.robot_timeout = 0.2;
  for (const bool is_trial : {false, true}) {
    obeys = true;
    begin();
    execute(is_trial);
    obeys = false;
    press(190);
    EXPECT_EQ(mode(), Mode::kExecuting) << is_trial;
    press(20);
    EXPECT_NE(mode(), Mode::kExecuting) << is_trial;
    EXPECT_EQ(shared->last_execution.load().end, ExecutionEnd::kRobotLost) << is_trial;
  }
}

TEST_F(LoopBench, ARobotThatDoesNotSettleIsWaitedForAsLongAsTheFileSays) {
  for (const bool is_trial : {false, true}) {
    std::array<int, 2> ticks{};
    for (std::size_t i = 0; i < ticks.size(); ++i) {
      config.execution.settle_time = i == 0 ? 0.3 : 0.8;
      begin();
      execute(is_trial);
      robot.arms[0].v_BT = {0.0, 2.0 * config.execution.settle_speed, 0.0};
      for (; ticks[i] < 6000 && mode() == Mode::kExecuting; ++ticks[i])
        press(1);
      EXPECT_EQ(shared->last_execution.load().end, ExecutionEnd::kNotSettled) << is_trial;
    }
    EXPECT_NEAR(ticks[1] - ticks[0], 500, 2) << is_trial;
  }
}

TEST_F(LoopBench, ChangesOfFaultsForWhichThereWasNoRoomAreCountedOnce) {
  press(3);
  Fault blinking = byHand(FaultHost::kMaster, FaultVariable::kPacket, FaultKind::kDrop, 0.0);  // drops none
  blinking.trigger = FaultTrigger::kPacket;
  blinking.duration_ticks = 1;
  blinking.period_ticks = 2;
  fault(blinking);
  for (int i = 0; i < 200; ++i)
    send(MasterCommand{});  // with the pedal up one tick takes them all
  step();
  const std::uint64_t lost = shared->fault_changes_unreported.value();
  EXPECT_GT(lost, 100U);
  rest(10);
  EXPECT_EQ(shared->fault_changes_unreported.value(), lost);
}

}  // namespace
}  // namespace raven2_trainer::loop
