#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <vector>

#include "raven2_trainer/console/make_motion.h"
#include "raven2_trainer/core/fault_variables.h"
#include "raven2_trainer/core/random.h"
#include "raven2_trainer/faults/arming.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"
#include "raven2_trainer/lockstep/lockstep_stack.h"
#include "support/effort.h"
#include "support/rig.h"

// Faults in the whole system: console, daemon and robot in lockstep.

namespace raven2_trainer::lockstep {
namespace {

using raven2_trainer::testing::effort;

TrainerConfig faultConfig() {
  TrainerConfig config = raven2_trainer::testing::packagedConfig();
  config.hazard = "none";
  config.runtime.plan_at = -1.0;
  config.virtual_raven.homing_time = 0.1;
  return config;
}

struct Whole {
  Whole() : config(faultConfig()) {
    raven2_trainer::testing::useOde();
    stack = std::make_unique<LockstepStack>(config, console::makeMotion(config, "scripted"));
  }

  void ticks(int n) {
    for (int i = 0; i < n; ++i) {
      stack->tick();
      stack->discardRecords();
    }
  }
  /** @return false if the surgeon never pressed the pedal. */
  bool engage() {
    for (int i = 0; i < 10000 && stack->view().model.session_tick < 0; ++i)
      ticks(1);
    return stack->view().model.session_tick >= 0;
  }
  void arm(const Fault& fault) {
    FaultPlan plan;
    plan.generation = ++generation;
    plan.count = 1;
    plan.faults[0] = fault;
    stack->arm(plan);
  }
  void clear() {
    FaultPlan plan;
    plan.generation = ++generation;
    stack->arm(plan);
  }
  Vector3 tip(Arm which) const { return kinematics::forward(config.arms.geometry, which, stack->trueJoints(which)).p; }

  TrainerConfig config;
  std::unique_ptr<LockstepStack> stack;
  std::uint64_t generation{1000};
};

Fault byHand(FaultHost host, FaultVariable variable, FaultKind kind, double value) {
  Fault fault;
  fault.id = 1;
  fault.host = host;
  fault.site = infoOf(variable).site;
  fault.variable = variable;
  fault.kind = kind;
  fault.trigger = FaultTrigger::kHand;
  fault.value = value;
  fault.low = value;
  fault.high = value;
  return fault;
}

/** [m] Largest distance of the tips of model and robot over some ticks. */
double parted(Whole* run, int ticks) {
  double largest = 0.0;
  for (int i = 0; i < ticks; ++i) {
    run->ticks(1);
    for (const Arm arm : kArms)
      largest = std::max(largest, at(run->stack->view().haptic.error, arm));
  }
  return largest;
}

TEST(FaultRuns, TheRelayDeceivesTheRobotAloneAndTheMastersStreamBoth) {
  for (const FaultHost host : {FaultHost::kRelay, FaultHost::kMaster}) {
    Whole run;
    ASSERT_TRUE(run.engage());
    run.ticks(200);
    Fault fault = byHand(host, FaultVariable::kIncrement, FaultKind::kAdd, 100);
    fault.channel = 2;
    fault.duration_ticks = 60;
    run.arm(fault);
    const double distance = parted(&run, 300);
    const ModelState model = run.stack->view().model;
    if (host == FaultHost::kRelay) {
      EXPECT_GT(distance, 4e-3) << "6 mm that only the robot received";
    } else {
      EXPECT_LT(distance, 2e-3) << "both went";
    }
    EXPECT_EQ(model.faults.active, 0U) << "it is over";
  }
}

TEST(FaultRuns, ADelayedStreamArrivesLateAndWhole) {
  Whole run;
  ASSERT_TRUE(run.engage());
  run.ticks(300);
  Fault late = byHand(FaultHost::kRelay, FaultVariable::kPacket, FaultKind::kDelay, 100);
  run.arm(late);
  parted(&run, 1500);
  run.clear();
  run.ticks(400);
  const LinkCounts itp = run.stack->robot().itp;
  EXPECT_TRUE(itp.addsUp());
  EXPECT_EQ(itp.applied, itp.received) << "none was lost or came out of order";
}

TEST(FaultRuns, ABadNetworkBetweenDaemonAndRobotIsFeltAndEnds) {
  Whole run;
  ASSERT_TRUE(run.engage());
  run.ticks(300);
  const auto names = run.config.impairment_names;
  const auto preset = std::find(names.begin(), names.end(), "net_delay_2") - names.begin();
  run.arm(byHand(FaultHost::kRelay, FaultVariable::kPacket, FaultKind::kImpair, static_cast<double>(preset)));
  const std::uint64_t before = run.stack->robot().itp.received;
  run.ticks(200);
  EXPECT_LT(run.stack->robot().itp.received - before, 10U) << "210 ms at least";
  run.ticks(2000);
  EXPECT_GT(run.stack->robot().itp.received - before, 1000U);
  run.clear();
  run.ticks(10);
  const std::uint64_t cleared = run.stack->robot().itp.received;
  run.ticks(100);
  EXPECT_GE(run.stack->robot().itp.received - cleared, 100U);
}

TEST(FaultRuns, ALostProgramLeavesTheDaemonAliveAndTheHandUnloaded) {
  for (const FaultKind kind : {FaultKind::kCrash, FaultKind::kHang}) {
    Whole run;
    ASSERT_TRUE(run.engage());
    run.ticks(500);
    run.arm(byHand(FaultHost::kRobot, FaultVariable::kProgram, kind, 0));
    run.ticks(1000);
    EXPECT_NE(run.stack->robot().program, ProgramState::kRunning);
    EXPECT_EQ(run.stack->view().model.robot_fresh, 0);
    for (const Vec3& force : run.stack->view().haptic.force_B)
      EXPECT_EQ(force, Vec3{});
    EXPECT_EQ(run.stack->plcLevel(), RunLevel::kEStop) << "the watchdog stopped";
  }
}

TEST(FaultRuns, TriggersOnSignalsFireInRobotAndDaemon) {
  for (const FaultHost host : {FaultHost::kRobot, FaultHost::kRelay}) {
    Whole run;
    ASSERT_TRUE(run.engage());
    Fault fault = byHand(host, FaultVariable::kIncrement, FaultKind::kAdd, 1);
    fault.trigger = FaultTrigger::kTissueDistance;
    fault.threshold = 0.005;
    fault.channel = 0;
    run.arm(fault);
    FaultSignals signals;
    signals.tissue_distance = 0.006;
    run.stack->setSignals(signals);
    run.ticks(100);
    const auto acts = [&] {
      return host == FaultHost::kRobot ? run.stack->robot().fault_mask : run.stack->view().model.faults.relay;
    };
    EXPECT_EQ(acts(), 0);
    signals.tissue_distance = 0.004;
    run.stack->setSignals(signals);
    run.ticks(host == FaultHost::kRobot ? 3 : 1);  // the link's delay
    EXPECT_EQ(acts(), 1) << kFaultHostNames[static_cast<std::size_t>(host)];
  }
}

TEST(FaultRuns, ARealRobotsStreamStaysCleanWithoutTheSecondKey) {
  for (const bool key : {false, true}) {
    TrainerConfig config = faultConfig();
    config.injection.real_robot = key;
    raven2_trainer::testing::Rig rig(config);
    ASSERT_TRUE(rig.home());
    rig.link.disconnected();
    rig.link.connected();
    std::array<std::uint8_t, wire::kMaxFrame> hello{};
    rig.link.receive(hello.data(), wire::encodeHello(1, /*is_virtual=*/false, hello.data()), 0);
    for (int i = 0; i < 100; ++i)
      rig.tick(false);
    for (int i = 0; i < 100; ++i)
      rig.tick(true);
    FaultPlan plan;
    plan.generation = 99;
    plan.count = 1;
    plan.faults[0] = byHand(FaultHost::kRelay, FaultVariable::kIncrement, FaultKind::kStuckAt, 25);
    rig.shared->faults.store(plan);
    for (int i = 0; i < 5; ++i)
      rig.tick(true);
    EXPECT_EQ(rig.last_relay.command.dp_I[0][0] != 0.0, key);
    EXPECT_EQ(rig.model().faults.relay != 0, key);
    // Its link is lost: our packets may still reach it.
    plan.generation = 100;
    plan.faults[0] = byHand(FaultHost::kRelay, FaultVariable::kPedal, FaultKind::kStuckAt, 1);
    rig.shared->faults.store(plan);
    rig.link.disconnected();
    rig.robot_connected = false;
    for (int i = 0; i < 5; ++i)
      rig.tick(false);
    EXPECT_EQ(rig.last_relay.command.pedal != 0, key);
  }
}

TEST(FaultRuns, AScenarioReachesARealRobotOnlyWithBothKeys) {
  for (const bool enable : {false, true}) {
    for (const bool real_robot : {false, true}) {
      TrainerConfig config = faultConfig();
      config.injection = {enable, real_robot};
      config.hazard = "surgeon_cmd_clean_sim";
      Fault& fault = raven2_trainer::testing::onlyFaultOf(&config, config.hazard);
      fault.first_tick = 20;
      const double wanted = enable && real_robot ? fault.value * 1e-6 : 0.0;
      raven2_trainer::testing::Rig rig(config);
      ASSERT_TRUE(rig.home());
      rig.link.disconnected();
      rig.link.connected();
      std::array<std::uint8_t, wire::kMaxFrame> hello{};
      rig.link.receive(hello.data(), wire::encodeHello(1, /*is_virtual=*/false, hello.data()), 0);
      for (int i = 0; i < 100; ++i)
        rig.tick(false);
      for (int i = 0; i < 100; ++i)
        rig.tick(true);
      EXPECT_NEAR(rig.last_relay.command.dp_I[0][1], wanted, 1e-12) << enable << real_robot;
    }
  }
}

TEST(FaultRuns, NoLostLinkHeldPacketOrConsoleFaultGoesAroundTheSecondKey) {
  TrainerConfig config = faultConfig();
  raven2_trainer::testing::Rig rig(config);
  ASSERT_TRUE(rig.home());
  const auto arm = [&](const Fault& fault, std::uint64_t generation) {
    FaultPlan plan;
    plan.generation = generation;
    plan.count = 1;
    plan.faults[0] = fault;
    rig.shared->faults.store(plan);
  };
  Fault late = byHand(FaultHost::kRelay, FaultVariable::kPacket, FaultKind::kDelay, 0);
  late.low = late.high = 50;
  arm(late, 98);  // of the virtual robot: packets are held back
  for (int i = 0; i < 100; ++i)
    rig.tick(true);
  ASSERT_NE(rig.model().faults.relay, 0);
  // WHEN a real one takes its place
  rig.link.disconnected();
  rig.link.connected();
  std::array<std::uint8_t, wire::kMaxFrame> hello{};
  rig.link.receive(hello.data(), wire::encodeHello(1, /*is_virtual=*/false, hello.data()), 0);
  std::uint32_t before = 0;
  for (int i = 0; i < 60; ++i) {
    rig.tick(false);
    if (i > 2) {
      EXPECT_EQ(rig.last_relay.command.sequence, before + 1) << "late packets";
    }
    before = rig.last_relay.command.sequence;
  }
  EXPECT_EQ(rig.model().faults.relay, 0);
  // and its link is lost, with a pedal stuck down
  arm(byHand(FaultHost::kRelay, FaultVariable::kPedal, FaultKind::kStuckAt, 1), 99);
  rig.link.disconnected();
  rig.robot_connected = false;
  for (int i = 0; i < 20; ++i)
    rig.tick(false);
  EXPECT_EQ(rig.last_relay.command.pedal, 0) << "our packets may still reach it";
  arm(byHand(FaultHost::kConsole, FaultVariable::kPicture, FaultKind::kStuckAt, 1), 100);
  for (int i = 0; i < 5; ++i)
    rig.tick(false);
  EXPECT_EQ(rig.model().faults.picture, 0);
  EXPECT_EQ(rig.model().faults.console, 0);
}

TEST(FaultRuns, OnceTheVirtualRobotIsGoneNothingIsForgedForWhoeverTakesItsPlace) {
  raven2_trainer::testing::Rig rig(faultConfig());
  ASSERT_TRUE(rig.home());
  FaultPlan plan;
  plan.generation = 98;
  plan.count = 1;
  plan.faults[0] = byHand(FaultHost::kRelay, FaultVariable::kPedal, FaultKind::kStuckAt, 1);
  rig.shared->faults.store(plan);
  for (int i = 0; i < 5; ++i)
    rig.tick(false);
  ASSERT_EQ(rig.last_relay.command.pedal, 1) << "the virtual one is deceived";
  rig.link.disconnected();
  rig.robot_connected = false;
  for (int i = 0; i < 20; ++i) {
    rig.tick(false);
    EXPECT_EQ(rig.last_relay.command.pedal, 0) << i;
    EXPECT_EQ(rig.last_relay.is_held, 1) << i;
  }
}

/** As over sockets: the system closes the connection of a process that died, but not of one that hangs. */
TEST(FaultRuns, ARobotWhoseProgramCrashedIsDisconnectedAndOneThatHangsIsNot) {
  for (const FaultKind kind : {FaultKind::kCrash, FaultKind::kHang}) {
    Whole whole;
    ASSERT_TRUE(whole.engage());
    whole.ticks(500);
    ASSERT_EQ(whole.stack->view().robot.connected, 1);
    whole.arm(byHand(FaultHost::kRobot, FaultVariable::kProgram, kind, 0.0));
    whole.ticks(200);
    const bool crashes = kind == FaultKind::kCrash;
    EXPECT_EQ(whole.stack->view().robot.connected, crashes ? 0 : 1);
    EXPECT_EQ(whole.stack->view().model.linked, crashes ? 0 : 1);
    EXPECT_GT(whole.stack->view().robot.frame, 0U) << "its last state is kept";
    whole.ticks(500);
    EXPECT_EQ(whole.stack->view().model.linked, 0) << "silent for 0.5 s";
  }
}

TEST(FaultRuns, PacketsThatTheSessionsOwnHazardLosesAreCounted) {
  TrainerConfig config = faultConfig();
  config.hazard = "sudden_jump";
  Fault& lost = raven2_trainer::testing::onlyFaultOf(&config, "sudden_jump");
  const std::uint32_t id = lost.id;
  lost = byHand(FaultHost::kRelay, FaultVariable::kPacket, FaultKind::kDrop, 1.0);
  lost.id = id;
  lost.trigger = FaultTrigger::kPowerOn;
  lost.first_tick = 100;
  lost.duration_ticks = 50;
  raven2_trainer::testing::Rig rig(config);
  for (int i = 0; i < 300; ++i)
    rig.tick(false);
  EXPECT_EQ(rig.counts().relay_faults.lost, 50U);
}

TEST(FaultRuns, WhatIsArmedAnewComesAnew) {
  TrainerConfig config = faultConfig();
  Fault& jump = raven2_trainer::testing::onlyFaultOf(&config, "sudden_jump");
  jump.trigger = FaultTrigger::kHand;
  jump.first_tick = 0;
  jump.duration_ticks = 5;
  jump.period_ticks = 0;
  raven2_trainer::testing::Rig rig(config);
  ASSERT_TRUE(rig.home());
  const std::uint32_t id = config::faultId(config, "sudden_jump");
  for (int times = 0; times < 3; ++times) {
    ASSERT_TRUE(rig.shared->fault_requests.tryPush({FaultOrder::kArm, id}));
    int acted = 0;
    for (int i = 0; i < 30; ++i) {
      rig.tick(false);
      acted += rig.robot().active_fault == id ? 1 : 0;
    }
    EXPECT_EQ(acted, 5) << times;
  }
}

TEST(FaultRuns, AScenarioThatFindsNoRoomChangesNothing) {
  raven2_trainer::testing::Rig rig(faultConfig());
  const TrainerConfig& config = rig.config;
  std::size_t rows = 0;
  for (const char* name : {"intent_reorder_delay", "master_sluggish", "net_delay_1", "net_delay_2", "net_delay_3"}) {
    const FaultPlan before = rig.shared->faults.load();
    const FaultPlan wanted = faults::planFor(config, config::faultId(config, name), 0);
    const bool fits = loop::FaultDirector::fits(before, wanted);
    ASSERT_TRUE(rig.shared->fault_requests.tryPush({FaultOrder::kArm, config::faultId(config, name)}));
    rig.tick(false);
    rig.tick(false);
    EXPECT_EQ(rig.shared->faults.load().count, before.count + (fits ? wanted.count : 0)) << name;
    rows += fits ? wanted.count : 0;
    if (!fits) return;
  }
  FAIL() << rows << " rows fitted: no scenario was refused";
}

TEST(FaultRuns, WhateverIsDoneToTheRobotTheDaemonGoesOn) {
  Random random(11);
  const int runs = static_cast<int>(effort(12, 200));
  int dead = 0;
  for (int n = 0; n < runs; ++n) {
    Whole run;
    ASSERT_TRUE(run.engage());
    Fault fault;
    do {
      const FaultVariableInfo& info = kFaultVariables[1 + random.next() % (kFaultVariableCount - 1)];
      fault = byHand(FaultHost::kRobot, info.variable, static_cast<FaultKind>(random.next() % kFaultKindCount),
                     random.uniform(-3.0, 3.0) * std::pow(10.0, random.uniform(0.0, 8.0)));
      fault.low = -std::abs(fault.value);
      fault.high = std::abs(fault.value);
      fault.half_period_ticks = random.next() % 2 == 0 ? 0 : 1 + random.next() % 50;
      fault.seed = random.next();
    } while (!isSound(fault));
    run.arm(fault);
    run.ticks(300);
    const ModelState model = run.stack->view().model;
    for (const Arm arm : kArms) {
      for (const double q : at(model.arms, arm).q)
        ASSERT_TRUE(std::isfinite(q)) << infoOf(fault.variable).name;
      for (const double f : at(run.stack->view().haptic.force_I, arm))
        ASSERT_LE(std::abs(f), run.config.haptics.max_force);
    }
    ASSERT_TRUE(run.stack->robot().itp.addsUp());
    dead += run.stack->robot().program != ProgramState::kRunning ? 1 : 0;
  }
  std::printf("%d runs, %d of them ended the robot's program\n", runs, dead);
}

TEST(FaultRuns, SecondsAfterASuddenJumpAllIsAsWithoutIt) {
  Whole golden, faulty;
  ASSERT_TRUE(golden.engage());
  ASSERT_TRUE(faulty.engage());
  golden.ticks(1000);
  faulty.ticks(1000);
  Fault jump = byHand(FaultHost::kRobot, FaultVariable::kDac, FaultKind::kStuckAt, 800);
  jump.arm = 0;
  jump.channel = kShoulder;
  jump.duration_ticks = 300;
  faulty.arm(jump);
  double largest = 0.0;
  const auto after = static_cast<int>(effort(2000, 10000));
  for (int i = 0; i < 300 + after; ++i) {
    golden.ticks(1);
    faulty.ticks(1);
    largest = std::max(largest, (golden.tip(Arm::kGold) - faulty.tip(Arm::kGold)).norm());
  }
  EXPECT_GT(largest, 2e-3) << "without a jump the test shows nothing";
  // The force pushed the hand, so the two surgeons need not be at the same place: model and robot must be together.
  EXPECT_LT(at(faulty.stack->view().haptic.error, Arm::kGold), 1.5e-3);
  EXPECT_EQ(faulty.stack->robot().runlevel, golden.stack->robot().runlevel);
}

TEST(FaultRuns, WhateverWasFrozenIsFreeAgainOnceCleared) {
  std::vector<FaultVariable> variables;
  for (const FaultVariableInfo& info : kFaultVariables) {
    if (serves(FaultHost::kRobot, info.site) && takes(info.variable, FaultKind::kHoldLast))
      variables.push_back(info.variable);
  }
  ASSERT_GT(variables.size(), 30U);
  Random random(12);
  const auto after = static_cast<int>(effort(1500, 10000));
  const auto runs = static_cast<std::size_t>(effort(6, static_cast<std::int64_t>(variables.size())));
  for (std::size_t n = 0; n < runs; ++n) {
    const FaultVariable variable = variables[raven2_trainer::testing::isFull() ? n : random.next() % variables.size()];
    Whole run;
    ASSERT_TRUE(run.engage());
    run.ticks(300);
    Fault frozen = byHand(FaultHost::kRobot, variable, FaultKind::kHoldLast, 0);
    frozen.duration_ticks = 5;
    run.arm(frozen);
    run.ticks(10);
    run.clear();
    run.ticks(after);
    for (const Arm arm : kArms)
      EXPECT_LT(at(run.stack->view().haptic.error, arm), 1.5e-3) << infoOf(variable).name;
    EXPECT_GE(run.stack->robot().runlevel, RunLevel::kPedalUp) << infoOf(variable).name;
    EXPECT_EQ(run.stack->robot().fault_mask, 0) << infoOf(variable).name;
  }
}

/** The changes of faults in a run, from its records. */
std::vector<FaultChangeRecord> changesOver(Whole* run, int ticks) {
  std::vector<FaultChangeRecord> changes;
  for (int i = 0; i < ticks; ++i) {
    run->stack->tick();
    FaultChangeRecord record;
    while (run->stack->shared()->change_records.tryPop(&record))
      changes.push_back(record);
    run->stack->discardRecords();
  }
  return changes;
}

TEST(FaultRuns, TheDaemonKnowsToTheCycleWhatItsFramesDoNotShow) {
  Whole run;
  ASSERT_TRUE(run.engage());
  run.ticks(200);
  Fault lost = byHand(FaultHost::kRobot, FaultVariable::kFrame, FaultKind::kDrop, 1.0);
  lost.duration_ticks = 300;
  run.arm(lost);
  const std::uint64_t cycle = run.stack->robot().cycle;
  const std::vector<FaultChangeRecord> changes = changesOver(&run, 400);
  ASSERT_EQ(changes.size(), 2U);
  EXPECT_EQ(changes[0].change.cycle, cycle + 1);
  EXPECT_EQ(changes[1].change.cycle, cycle + 301);
  EXPECT_EQ(changes[1].tick - changes[0].tick, 300);
}

TEST(FaultRuns, AFaultOfOneCycleIsKnownOnEveryHost) {
  for (const FaultHost host : {FaultHost::kRobot, FaultHost::kRelay, FaultHost::kMaster, FaultHost::kConsole}) {
    Whole run;
    ASSERT_TRUE(run.engage());
    const FaultVariable variable = host == FaultHost::kRobot     ? FaultVariable::kDac
                                   : host == FaultHost::kConsole ? FaultVariable::kForceGain
                                                                 : FaultVariable::kIncrement;
    Fault once = byHand(host, variable, FaultKind::kAdd, 1);
    once.duration_ticks = 1;
    once.row = 2;
    run.arm(once);
    const std::vector<FaultChangeRecord> changes = changesOver(&run, 50);
    const char* name = kFaultHostNames[static_cast<std::size_t>(host)];
    ASSERT_EQ(changes.size(), 2U) << name;
    EXPECT_EQ(changes[0].change.host, host) << name;
    EXPECT_EQ(changes[0].change.row, 2) << name;
    EXPECT_EQ(changes[0].change.acts, 1) << name;
    EXPECT_EQ(changes[1].change.acts, 0) << name;
    EXPECT_EQ(changes[1].change.cycle, changes[0].change.cycle + 1) << name;
  }
}

TEST(FaultRuns, EveryPacketIsAccountedForThoughFaultsLoseDoubleAndHoldThem) {
  Whole run;
  ASSERT_TRUE(run.engage());
  const auto names = run.config.impairment_names;
  const auto preset = std::find(names.begin(), names.end(), "wifi") - names.begin();
  FaultPlan plan;
  plan.count = 4;
  plan.faults[0] = byHand(FaultHost::kMaster, FaultVariable::kPacket, FaultKind::kDuplicate, 2);
  plan.faults[1] = byHand(FaultHost::kRelay, FaultVariable::kPacket, FaultKind::kDrop, 0.3);
  plan.faults[2] = byHand(FaultHost::kRelay, FaultVariable::kPacket, FaultKind::kDelay, 40);
  plan.faults[3] = byHand(FaultHost::kRelay, FaultVariable::kPacket, FaultKind::kImpair, static_cast<double>(preset));
  run.stack->arm(plan);
  run.ticks(2000);
  const SessionCounts counts = run.stack->counts();
  EXPECT_EQ(wrongSum(counts), nullptr) << wrongSum(counts);
  EXPECT_EQ(counts.master_faults.added, 2 * 2000U);
  EXPECT_NEAR(static_cast<double>(counts.relay_faults.lost), 600.0, 100.0);
  EXPECT_GE(counts.relay_faults.held, 20U);
  EXPECT_GT(counts.relay_network.lost + counts.relay_network.held, 0U);
}

TEST(FaultRuns, WhatTriggersLookAtIsThereWithThePlan) {
  Whole run;
  ASSERT_TRUE(run.engage());
  FaultSignals signals;
  signals.tissue_distance = 0.001;
  run.stack->setSignals(signals);
  run.ticks(5);
  signals.tissue_distance = 0.100;  // away again, before anything is armed
  run.stack->setSignals(signals);
  run.ticks(1);
  Fault fault = byHand(FaultHost::kRobot, FaultVariable::kIncrement, FaultKind::kAdd, 1);
  fault.trigger = FaultTrigger::kTissueDistance;
  fault.threshold = 0.005;
  run.arm(fault);
  run.ticks(20);
  EXPECT_EQ(run.stack->robot().fault_mask, 0) << "it was near once";
}

TEST(FaultRuns, WhatWasNearDuringTheFormerPlanIsNotNearForTheNext) {
  Whole run;
  ASSERT_TRUE(run.engage());
  Fault fault = byHand(FaultHost::kRobot, FaultVariable::kIncrement, FaultKind::kAdd, 1);
  fault.trigger = FaultTrigger::kTissueDistance;
  fault.threshold = 0.005;
  FaultSignals signals;
  signals.tissue_distance = 0.001;
  run.stack->setSignals(signals);
  run.arm(fault);
  run.ticks(5);
  EXPECT_EQ(run.stack->robot().fault_mask, 1);
  run.clear();
  signals.tissue_distance = 0.100;
  run.stack->setSignals(signals);
  run.ticks(5);
  fault.arming = 1;
  run.arm(fault);
  run.ticks(20);
  EXPECT_EQ(run.stack->robot().fault_mask, 0);
}

TEST(FaultRuns, TheSameFaultAndSeedGiveTheSameRun) {
  const auto digest = [](std::uint64_t seed) {
    Whole run;
    EXPECT_TRUE(run.engage());
    Fault noise = byHand(FaultHost::kRobot, FaultVariable::kDac, FaultKind::kRandom, 0);
    noise.low = -1500;
    noise.high = 1500;
    noise.seed = seed;
    noise.duration_ticks = 200;
    run.arm(noise);
    run.ticks(600);
    return std::make_pair(run.stack->trueJoints(Arm::kGold), run.stack->view().model.arms[0].q);
  };
  EXPECT_EQ(digest(1), digest(1));
  EXPECT_NE(digest(1), digest(2));
}

}  // namespace
}  // namespace raven2_trainer::lockstep
