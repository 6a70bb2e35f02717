#include "raven2_trainer/campaign/run_campaign.h"

#include <gtest/gtest.h>

#include <unistd.h>

#include <csignal>
#include <fstream>
#include <map>

#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/runtime/motion.h"
#include "support/rig.h"

namespace raven2_trainer::campaign {
namespace {

std::string scenario(const std::string& name, const std::string& phase, const std::string& fault) {
  return "  - scenario: " + name +
         "\n    injection: 0\n    number: 0\n    observed: x\n    published: []\n    phase: " + phase +
         "\n    repetitions: 1\n    faults:\n      - {" + fault + "}\n";
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
      scenario("relay", "pedal_down", "host: relay" + moved + start) +
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

/** The same run made another way: with its fault armed from power-on, and a golden one beside it, tick by tick. */
class Unforked {
 public:
  Unforked(const Campaign& campaign, const CampaignRun& run)
      : campaign_(campaign), config_(configured(campaign, run)), golden_(stack()), faulty_(stack()) {
    faulty_->arm(run.plan);
  }

  Figures figures(std::int64_t ticks) {
    Comparison comparison(campaign_.limits);
    comparison.add(sampleOf(config_.arms, *golden_), sampleOf(config_.arms, *faulty_));
    for (std::int64_t t = 0; t < ticks; ++t) {
      for (auto* stack : {golden_.get(), faulty_.get()}) {
        stack->tick();
        stack->discardRecords();
      }
      comparison.add(sampleOf(config_.arms, *golden_), sampleOf(config_.arms, *faulty_));
    }
    return comparison.figures();
  }

  /** [ticks] until the robot is in PEDAL_DN. */
  std::int64_t pedalDown() {
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
  std::unique_ptr<runtime::LockstepStack> stack() const {
    return std::make_unique<runtime::LockstepStack>(config_, runtime::makeMotion(config_, "scripted"));
  }

  const Campaign& campaign_;
  TrainerConfig config_;
  std::unique_ptr<runtime::LockstepStack> golden_, faulty_;
};

TEST(MakeRuns, AForkedRunIsTheRunWithItsFaultArmedFromPowerOn) {
  const Campaign campaign = everyClock();
  std::map<std::uint32_t, RunResult> results = resultsOf(campaign, 2);
  ASSERT_EQ(results.size(), campaign.runs.size());
  const std::int64_t pedal_down = Unforked(campaign, campaign.runs[0]).pedalDown();
  for (const CampaignRun& run : campaign.runs) {
    SCOPED_TRACE(campaign.experiments[run.experiment].name);
    const std::int64_t fork = run.phase == Phase::kHoming ? 0 : pedal_down + run.offset_ticks;
    const Figures forked = results.at(run.number).figures;
    const Figures whole = Unforked(campaign, run).figures(fork + run.horizon_ticks);
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
  const Campaign campaign = everyClock();
  const Figures figures = resultsOf(campaign, 1).at(1).figures;
  EXPECT_EQ(figures.injected, 1) << "forked at the last tick before it";
}

TEST(MakeRuns, ARunThatIsKilledFromOutsideIsNoOutcome) {
  raven2_trainer::testing::useOde();
  const Campaign campaign = everyClock();
  int told = 0;
  const auto killOthers = [&](const CampaignRun&, const RunResult&) {
    ++told;
    std::ifstream children("/proc/self/task/" + std::to_string(getpid()) + "/children");
    for (pid_t child = 0; children >> child;)
      ::kill(child, SIGKILL);
  };
  EXPECT_THROW(makeRuns(configurationFor(campaign, raven2_trainer::testing::packagedConfig()), campaign, campaign.runs,
                        2, killOthers),
               Exception);
  EXPECT_EQ(told, 1);
}

TEST(MakeRuns, JobsAndPartsChangeNothing) {
  const Campaign campaign = everyClock();
  const auto one = resultsOf(campaign, 1);
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

}  // namespace
}  // namespace raven2_trainer::campaign
