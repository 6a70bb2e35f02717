#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "raven2_trainer/console/make_motion.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"
#include "raven2_trainer/lockstep/lockstep_stack.h"
#include "raven2_trainer/studies/detector_study.h"
#include "support/rig.h"

// The detector as a guard in the emulated robot, with the whole stack in lockstep.

namespace raven2_trainer::lockstep {
namespace {

constexpr int kSettled = 4000;  // ms: homed, pedal down, the surgeon at work

struct Seen {
  std::vector<Vector3> tips;      ///< [m] true, gold
  std::vector<std::int32_t> dac;  ///< [counts] gold shoulder, as written
  raven::DetectorReport report;
  bool soft_stopped{};
};

Seen runWith(Mitigation mitigate, const FaultPlan& plan, int watched) {
  testing::useOde();
  TrainerConfig config = studies::studyConfig(testing::packagedConfig(), 4711);
  config.hazard = "none";
  config.detector.mitigate = mitigate;
  LockstepStack stack(config, console::makeMotion(config, "scripted"));
  Seen seen;
  for (int k = 0; k < kSettled + watched; ++k) {
    if (k == kSettled) stack.arm(plan);
    stack.tick();
    stack.discardRecords();
    if (k < kSettled) continue;
    seen.tips.push_back(kinematics::forward(config.arms.geometry, Arm::kGold, stack.trueJoints(Arm::kGold)).p);
    seen.dac.push_back(stack.robot().arms[0].dac[kShoulder]);
    seen.soft_stopped = seen.soft_stopped || stack.robot().soft_estopped != 0;
  }
  seen.report = stack.detectorReport();
  return seen;
}

/** A run without a fault; run once. */
const Seen& golden() {
  static const Seen seen = runWith(Mitigation::kOff, FaultPlan{}, 2000);
  return seen;
}

double departure(const Seen& run) {
  double largest = 0.0;
  for (std::size_t k = 0; k < run.tips.size(); ++k)
    largest = std::max(largest, (run.tips[k] - golden().tips[k]).norm());
  return largest;
}

FaultPlan torque(double counts, Tick length) {
  return studies::planOf({studies::StudyFault::Scenario::kTorque, FaultKind::kStuckAt, counts, length});
}

const Seen& unguarded() {
  static const Seen seen = runWith(Mitigation::kOff, torque(12000, 16), 300);
  return seen;
}

TEST(Mitigation, ChangesNothingWithoutFaults) {
  const Seen& off = golden();
  EXPECT_EQ(off.report.alarms, 0U);
  for (const Mitigation mode : {Mitigation::kHold, Mitigation::kStop}) {
    const Seen on = runWith(mode, FaultPlan{}, 2000);
    EXPECT_EQ(on.tips, off.tips);
    EXPECT_EQ(on.dac, off.dac);
    EXPECT_EQ(on.report.alarms, 0U);
    EXPECT_EQ(on.report.cycles_acted, 0U);
  }
}

TEST(Mitigation, HoldWritesTheLastSafeCommandWhileTheAlarmLasts) {
  const Seen& off = unguarded();
  const Seen hold = runWith(Mitigation::kHold, torque(12000, 16), 300);
  ASSERT_GT(departure(off), 0.001) << "[m] the fault has hardly an effect: the test shows nothing";
  EXPECT_LT(departure(hold), 0.5 * departure(off));
  EXPECT_GE(hold.report.alarms, 1U);
  EXPECT_FALSE(hold.soft_stopped);
  // Without the guard, all 16 ms of the fault write the fault's command; with it, at least one writes another.
  const auto written = [](const Seen& run) { return std::count(run.dac.begin(), run.dac.begin() + 16, 12000); };
  EXPECT_EQ(written(off), 16);
  EXPECT_LT(written(hold), 16);
}

TEST(Mitigation, HoldKeepsTheArmWhereAnInputFaultWouldThrowIt) {
  const FaultPlan plan =
      studies::planOf({studies::StudyFault::Scenario::kInputs, FaultKind::kAdd, 1500, 4});  // 6 mm in 4 ms
  const double off = departure(runWith(Mitigation::kOff, plan, 100));
  ASSERT_GT(off, 0.003);
  EXPECT_LT(departure(runWith(Mitigation::kHold, plan, 100)), 0.5 * off);
}

TEST(Mitigation, StopIsTheSoftwareEStop) {
  const Seen stop = runWith(Mitigation::kStop, torque(12000, 16), 300);
  EXPECT_TRUE(stop.soft_stopped);
  EXPECT_EQ(stop.report.alarms, 1U);
  EXPECT_EQ(stop.dac.back(), 0);
  EXPECT_FALSE(unguarded().soft_stopped);
}

}  // namespace
}  // namespace raven2_trainer::lockstep
