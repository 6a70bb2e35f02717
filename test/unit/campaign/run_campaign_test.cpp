#include "raven2_trainer/campaign/run_campaign.h"

#include <gtest/gtest.h>

#include <unistd.h>

#include <cmath>
#include <csignal>
#include <fstream>
#include <map>
#include <vector>

#include "raven2_trainer/console/make_motion.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/core/fault_variables.h"
#include "support/rig.h"

namespace raven2_trainer::campaign {
namespace {

std::string scenario(const std::string& name, const std::string& phase, const std::string& fault, int horizon = 400) {
  return "  - scenario: " + name +
         "\n    injection: 0\n    number: 0\n    observed: x\n    published: []\n    phase: " + phase +
         "\n    horizon_ticks: " + std::to_string(horizon) + "\n    repetitions: 1\n    faults:\n      - {" + fault +
         "}\n";
}

Campaign campaignOf(const std::string& scenarios) {
  const std::string head = R"(name: test
title: Test
source: none
plant: identified
homing: quick
arm_contacts: false
cpu_limit: 60
horizon_ticks: {homing: 400, pedal_down: 400}
limits: {masked: 0.0001, jump: 0.001, still: 0.0003, moved: 0.001, force: 0.05}
scenarios:
)";
  return readCampaign(head + scenarios, "test.yaml", 5, {});
}

/** Faults of every clock that there is in teleoperation. */
Campaign everyClock() {
  const std::string start = ", start: {trigger: pedal_down, first_tick: 300}, duration_ticks: 100";
  const std::string packets = ", start: {trigger: packet, first_tick: 300}, duration_ticks: 100";
  const std::string moved = ", site: network_layer, variable: increment, kind: add, arm: gold, channel: x, value: 20";
  return campaignOf(
      scenario("dac", "pedal_down",
               "host: robot, site: put_usb_packet, variable: dac, kind: stuck_at, arm: gold, channel: shoulder, value: "
               "3000" +
                   start) +
      scenario("random", "pedal_down",
               "host: robot, site: put_usb_packet, variable: dac, kind: random, arm: gold, channel: elbow, low: -3000, "
               "high: 3000" +
                   start) +
      scenario("robot_packets", "pedal_down", "host: robot" + moved + packets) +
      scenario("relay", "pedal_down", "host: relay" + moved + start, 520) +  // forks first, and ends last
      scenario("relay_packets", "pedal_down", "host: relay" + moved + packets) +
      scenario("master", "pedal_down", "host: master" + moved + start) +
      scenario("master_packets", "pedal_down", "host: master" + moved + packets) +
      scenario("crash", "pedal_down", "host: robot, site: process, variable: program, kind: crash" + start) +
      scenario(
          "power_on", "homing",
          "host: robot, site: put_usb_packet, variable: dac, kind: add, arm: green, channel: shoulder, value: 900, "
          "start: {trigger: power_on, first_tick: 100}, duration_ticks: 100"));
}

std::map<std::uint32_t, RunResult> resultsOf(const Campaign& campaign, std::size_t jobs) {
  raven2_trainer::testing::useOde();
  std::map<std::uint32_t, RunResult> results;
  makeRuns(configurationFor(campaign, raven2_trainer::testing::packagedConfig()), campaign, campaign.runs, jobs,
           [&](const CampaignRun& run, const RunResult& result) { results[run.number] = result; });
  return results;
}

/** Results of one job; only once. */
const std::map<std::uint32_t, RunResult>& resultsOfOneJob() {
  static const std::map<std::uint32_t, RunResult> results = resultsOf(everyClock(), 1);
  return results;
}

using GoldenSamples = std::map<std::uint64_t, std::vector<Sample>>;  ///< of each motion seed, from power-on

/** The same run without a fork: its fault is armed at power-on, and the golden run is simulated tick by tick. */
class Unforked {
 public:
  Unforked(const Campaign& campaign, const CampaignRun& run)
      : campaign_(campaign), config_(configured(campaign, run)), plan_(run.plan) {}

  Figures figures(std::int64_t ticks, GoldenSamples* known) const {
    std::vector<Sample>& golden = (*known)[config_.seed];
    if (static_cast<std::int64_t>(golden.size()) <= ticks) golden = samples(FaultPlan{}, ticks);
    const std::vector<Sample> faulty = samples(plan_, ticks);
    Comparison comparison(campaign_.limits);
    for (std::size_t t = 0; t < faulty.size(); ++t)
      comparison.add(golden[t], faulty[t]);
    return comparison.figures();
  }

  /** [ticks] until the robot is in PEDAL_DN. */
  std::int64_t pedalDown() const {
    const auto stack = this->stack();
    std::int64_t ticks = 0;
    for (; stack->robot().runlevel != RunLevel::kPedalDown; ++ticks) {
      stack->tick();
      stack->discardRecords();
    }
    return ticks;
  }

 private:
  static TrainerConfig configured(const Campaign& campaign, const CampaignRun& run) {
    TrainerConfig config = configurationFor(campaign, raven2_trainer::testing::packagedConfig());
    config.seed = run.motion_seed;
    return config;
  }
  std::unique_ptr<lockstep::LockstepStack> stack() const {
    return std::make_unique<lockstep::LockstepStack>(config_, console::makeMotion(config_, "scripted"));
  }
  std::vector<Sample> samples(const FaultPlan& plan, std::int64_t ticks) const {
    const auto stack = this->stack();
    if (plan.count > 0) stack->arm(plan);
    std::vector<Sample> all{sampleOf(config_.arms, *stack)};
    for (std::int64_t t = 0; t < ticks; ++t) {
      stack->tick();
      stack->discardRecords();
      all.push_back(sampleOf(config_.arms, *stack));
    }
    return all;
  }

  const Campaign& campaign_;
  TrainerConfig config_;
  FaultPlan plan_;
};

TEST(MakeRuns, AGoldenRunThatStopsByItselfIsNoMeasure) {
  raven2_trainer::testing::useOde();
  const Campaign campaign = everyClock();
  TrainerConfig config = configurationFor(campaign, raven2_trainer::testing::packagedConfig());
  config.detector.mitigate = Mitigation::kStop;
  config.detector.factor = 0.01;  // each motion is an alarm
  int results = 0;
  try {
    makeRuns(config, campaign, campaign.runs, 2, [&](const CampaignRun&, const RunResult&) { ++results; });
    FAIL() << "it was accepted";
  } catch (const Exception& e) {
    EXPECT_NE(std::string(e.what()).find("without a fault"), std::string::npos) << e.what();
  }
  EXPECT_EQ(results, 0);
}

TEST(MakeRuns, AForkedRunIsTheRunWithItsFaultArmedFromPowerOn) {
  const Campaign campaign = everyClock();
  std::map<std::uint32_t, RunResult> results = resultsOf(campaign, 2);
  ASSERT_EQ(results.size(), campaign.runs.size());
  const std::int64_t pedal_down = Unforked(campaign, campaign.runs[0]).pedalDown();
  GoldenSamples golden;
  for (const CampaignRun& run : campaign.runs) {
    SCOPED_TRACE(campaign.experiments[run.experiment].name);
    const std::int64_t fork = run.phase == Phase::kHoming ? 0 : pedal_down + run.offset_ticks;
    const Figures forked = results.at(run.number).figures;
    const Figures whole = Unforked(campaign, run).figures(fork + run.horizon_ticks, &golden);
    EXPECT_EQ(results.at(run.number).ending, Ending::kComplete);
    EXPECT_EQ(whole.injected, fork + forked.injected);
    EXPECT_NE(forked.injected, kNever);
    EXPECT_EQ(whole.deviation, forked.deviation);
    EXPECT_EQ(whole.max_jump, forked.max_jump);
    EXPECT_EQ(whole.max_force, forked.max_force);
    EXPECT_EQ(whole.motion, forked.motion);
    EXPECT_EQ(whole.program, forked.program);
    EXPECT_EQ(whole.plc_stop, forked.plc_stop);
    EXPECT_GT(maxDeviation(forked), 0.0) << "it did something";
  }
}

TEST(MakeRuns, TheFirstFaultyTickIsTheOneNamed) {
  const Figures figures = resultsOfOneJob().at(1).figures;
  EXPECT_EQ(figures.injected, 1) << "forked at the last tick before the fault";
}

TEST(MakeRuns, ARunThatIsKilledFromOutsideIsNoOutcome) {
  raven2_trainer::testing::useOde();
  const Campaign campaign = everyClock();
  std::size_t results = 0;
  const auto killOthers = [&](const CampaignRun&, const RunResult&) {
    ++results;
    std::ifstream children("/proc/self/task/" + std::to_string(getpid()) + "/children");
    for (pid_t child = 0; children >> child;)
      ::kill(child, SIGKILL);
  };
  EXPECT_THROW(makeRuns(configurationFor(campaign, raven2_trainer::testing::packagedConfig()), campaign, campaign.runs,
                        2, killOthers),
               Exception);
  EXPECT_GE(results, 1U);
  EXPECT_LT(results, campaign.runs.size()) << "some runs ended before the first kill, but not all";
}

TEST(MakeRuns, JobsAndPartsChangeNothing) {
  const Campaign campaign = everyClock();
  const auto& one = resultsOfOneJob();
  std::map<std::uint32_t, RunResult> pieces;
  raven2_trainer::testing::useOde();
  for (const CampaignRun& run : campaign.runs) {
    if (run.number % 3 != 1) continue;
    makeRuns(configurationFor(campaign, raven2_trainer::testing::packagedConfig()), campaign, {run}, 3,
             [&](const CampaignRun& r, const RunResult& result) { pieces[r.number] = result; });
  }
  ASSERT_EQ(pieces.size(), 3u);
  for (const auto& [number, result] : pieces) {
    const CampaignRun& run = campaign.runs[number - 1];
    EXPECT_EQ(row(campaign, run, result), row(campaign, run, one.at(number)));
  }
}

/** A stack, and faults of any host in it. */
class Sampled : public ::testing::Test {
 protected:
  Sampled() {
    raven2_trainer::testing::useOde();
    config_ = configurationFor(everyClock(), raven2_trainer::testing::packagedConfig());
    stack_ = std::make_unique<lockstep::LockstepStack>(config_, console::makeMotion(config_, "scripted"));
  }

  void ticks(int count) {
    for (int i = 0; i < count; ++i) {
      stack_->tick();
      stack_->discardRecords();
    }
  }
  Sample sample() const { return sampleOf(config_.arms, *stack_); }

  void arm(FaultHost host, FaultVariable variable, FaultKind kind, double value, Arm arm, int channel) {
    FaultPlan plan;
    plan.count = 1;
    Fault& fault = plan.faults[0];
    fault.id = 1;
    fault.arming = ++armings_;
    fault.host = host;
    fault.site = infoOf(variable).site;
    fault.variable = variable;
    fault.kind = kind;
    fault.trigger = FaultTrigger::kHand;
    fault.value = value;
    fault.arm = infoOf(variable).per_arm ? static_cast<std::int8_t>(index(arm)) : std::int8_t{-1};
    fault.channel = static_cast<std::int8_t>(channel);
    stack_->arm(plan);
  }

  void expectFaultsOfAnyHostSeen() {
    const std::map<FaultHost, FaultVariable> faults{{FaultHost::kRobot, FaultVariable::kDac},
                                                    {FaultHost::kRelay, FaultVariable::kIncrement},
                                                    {FaultHost::kMaster, FaultVariable::kIncrement},
                                                    {FaultHost::kConsole, FaultVariable::kForceGain}};
    for (const auto& [host, variable] : faults) {
      EXPECT_EQ(sample().faulted, 0) << kFaultHostNames[static_cast<std::size_t>(host)];
      arm(host, variable, FaultKind::kAdd, 1, Arm::kGold, 0);
      ticks(3);
      EXPECT_EQ(sample().faulted, 1) << kFaultHostNames[static_cast<std::size_t>(host)];
      stack_->arm(FaultPlan{});
      ticks(5);
    }
  }

  /** A fault adds to the motion of the green hand; model and robot both follow it. */
  void expectTipsOfEachArm() {
    arm(FaultHost::kMaster, FaultVariable::kIncrement, FaultKind::kAdd, 100, Arm::kGreen, 1);
    ticks(200);
    const Sample now = sample();
    const RobotState robot = stack_->view().robot;
    ASSERT_GT((toEigen(robot.arms[0].p_BT) - toEigen(robot.arms[1].p_BT)).norm(), 0.005) << "[m] arms too close";
    for (const Arm each : kArms)  // from the true joints, and from those that the encoders show
      EXPECT_LT((toEigen(at(now.p_BT, each)) - toEigen(at(robot.arms, each).p_BT)).norm(), 0.002) << name(each);
  }

  /** The fault changes only the increments that the robot's green arm receives. */
  void expectForcesOfEachArm() {
    arm(FaultHost::kRelay, FaultVariable::kIncrement, FaultKind::kAdd, 100, Arm::kGreen, 0);
    ticks(200);
    const Sample now = sample();
    EXPECT_GT(at(now.force, Arm::kGreen), 0.5);
    EXPECT_LT(at(now.force, Arm::kGold), 0.1);
    const Vec3& force = at(stack_->view().haptic.force_B, Arm::kGreen);
    EXPECT_NEAR(at(now.force, Arm::kGreen), std::hypot(force[0], force[1], force[2]), 1e-12);
  }

  void expectTheRobotsOwnStopSeen() {
    arm(FaultHost::kRobot, FaultVariable::kCurrentCmd, FaultKind::kStuckAt, 1e5, Arm::kGreen, kShoulder);
    bool was_seen = false;
    for (int i = 0; i < 50; ++i) {
      ticks(1);
      EXPECT_EQ(sample().soft_estopped, stack_->robot().soft_estopped);
      was_seen = was_seen || sample().soft_estopped != 0;
    }
    EXPECT_TRUE(was_seen);
  }

  TrainerConfig config_;
  std::unique_ptr<lockstep::LockstepStack> stack_;
  std::uint32_t armings_{0};
};

TEST_F(Sampled, IsWhatEachArmAndHostDid) {
  for (int i = 0; i < 10000 && stack_->robot().runlevel != RunLevel::kPedalDown; ++i)
    ticks(1);
  ASSERT_EQ(stack_->robot().runlevel, RunLevel::kPedalDown);
  ticks(100);
  expectFaultsOfAnyHostSeen();
  expectTipsOfEachArm();
  expectForcesOfEachArm();
  expectTheRobotsOwnStopSeen();
}

TEST_F(Sampled, WhatThePlcIsInIsNotWhatTheProgramBelieves) {
  ticks(200);
  const RunLevel level = stack_->robot().runlevel;
  ASSERT_EQ(level, RunLevel::kInit);
  arm(FaultHost::kRobot, FaultVariable::kProgram, FaultKind::kHang, 0, Arm::kGold, -1);
  ticks(300);
  EXPECT_EQ(sample().plc, RunLevel::kEStop) << "its watchdog stopped";
  EXPECT_EQ(sample().software, level);
  EXPECT_EQ(sample().program, ProgramState::kHung);
}

TEST(ConfigurationFor, IsTheCampaignsWithNothingElseArmed) {
  Campaign campaign = everyClock();
  for (const bool on : {false, true}) {
    campaign.full_homing = campaign.arm_contacts = on;
    TrainerConfig config = raven2_trainer::testing::packagedConfig();
    config.hazard = "sudden_jump";
    config.runtime.plan_at = 2.0;
    config.virtual_raven.full_homing = !on;
    config.model.arm_contacts = {!on, !on};
    const TrainerConfig made = configurationFor(campaign, config);
    EXPECT_EQ(made.hazard, "none");
    EXPECT_LT(made.runtime.plan_at, 0.0);
    EXPECT_EQ(made.virtual_raven.full_homing, on);
    EXPECT_EQ(made.model.arm_contacts, (PerArm<bool>{on, on}));
    config.injection.enable = false;
    EXPECT_THROW(configurationFor(campaign, config), ConfigException);
  }
}

TEST(ConfigurationFor, HasThePlantOfTheCampaign) {
  Campaign campaign = everyClock();
  campaign.plant = "worn_tool";
  const TrainerConfig made = configurationFor(campaign, raven2_trainer::testing::packagedConfig());
  EXPECT_EQ(made.virtual_raven.plant_name, "worn_tool");
}

}  // namespace
}  // namespace raven2_trainer::campaign
