#include "raven2_trainer/control/mode_table.h"

#include <gtest/gtest.h>

#include <map>
#include <set>
#include <utility>

namespace raven2_trainer::control {
namespace {

constexpr std::array<const char*, kEventCount> kEventNames{
    "robot_ready",     "pedal_pressed", "pedal_released",    "plan_requested",      "plan_ready",    "plan_failed",
    "emergency_stop",  "stop_cleared",  "time_slip",         "goal_wanted",         "plan_armed",    "plan_cancelled",
    "execution_ended", "trial_ended",   "simulation_wanted", "simulation_ended",    "trial_wanted",  "trial_done",
    "trial_discarded", "repeat_wanted", "repeat_armed",      "repeat_shown",        "return_wanted", "returned",
    "camera_pressed",  "camera_left",   "camera_left_alone", "camera_left_on_tape", "replay_wanted", "replay_ended"};

/** All changes of the table by the names of modes and events, as in doc/modes.md, except emergency stops. */
const std::multimap<std::string, std::pair<std::string, std::string>> kChanges{
    {"waiting", {"robot_ready", "pedal_up"}},
    {"waiting", {"pedal_pressed", "teleoperating"}},
    {"waiting", {"plan_requested", "planning"}},
    {"waiting", {"goal_wanted", "choosing"}},
    {"waiting", {"simulation_wanted", "simulation_held"}},
    {"waiting", {"trial_wanted", "trial_held"}},
    {"waiting", {"replay_wanted", "replaying"}},
    {"pedal_up", {"pedal_pressed", "teleoperating"}},
    {"pedal_up", {"plan_requested", "planning"}},
    {"pedal_up", {"goal_wanted", "choosing"}},
    {"pedal_up", {"plan_armed", "armed"}},
    {"pedal_up", {"simulation_wanted", "simulation_held"}},
    {"pedal_up", {"trial_wanted", "trial_held"}},
    {"pedal_up", {"replay_wanted", "replaying"}},
    {"pedal_up", {"return_wanted", "returning"}},
    {"pedal_up", {"camera_pressed", "camera_moving"}},
    {"teleoperating", {"pedal_released", "pedal_up"}},
    {"teleoperating", {"time_slip", "paused"}},
    {"teleoperating", {"camera_pressed", "camera_moving"}},
    {"planning", {"plan_ready", "tracking"}},
    {"planning", {"plan_failed", "pedal_up"}},
    {"planning", {"plan_cancelled", "pedal_up"}},
    {"planning", {"pedal_pressed", "teleoperating"}},
    {"planning", {"time_slip", "paused"}},
    {"planning", {"return_wanted", "returning"}},
    {"tracking", {"pedal_pressed", "teleoperating"}},
    {"tracking", {"plan_requested", "planning"}},
    {"tracking", {"goal_wanted", "choosing"}},
    {"tracking", {"plan_armed", "armed"}},
    {"tracking", {"time_slip", "paused"}},
    {"tracking", {"simulation_wanted", "simulation_held"}},
    {"tracking", {"return_wanted", "returning"}},
    {"stopped", {"stop_cleared", "pedal_up"}},
    {"paused", {"pedal_pressed", "teleoperating"}},
    {"paused", {"return_wanted", "returning"}},
    {"choosing", {"plan_requested", "planning"}},
    {"choosing", {"plan_cancelled", "pedal_up"}},
    {"choosing", {"time_slip", "paused"}},
    {"armed", {"pedal_pressed", "executing"}},
    {"armed", {"plan_requested", "planning"}},
    {"armed", {"goal_wanted", "choosing"}},
    {"armed", {"plan_cancelled", "pedal_up"}},
    {"armed", {"time_slip", "paused"}},
    {"executing", {"pedal_released", "pedal_up"}},
    {"executing", {"plan_cancelled", "pedal_up"}},
    {"executing", {"execution_ended", "pedal_up"}},
    {"executing", {"trial_ended", "tracking"}},
    {"executing", {"repeat_shown", "trial_ready"}},
    {"executing", {"time_slip", "paused"}},
    {"simulating", {"pedal_released", "simulation_held"}},
    {"simulating", {"time_slip", "simulation_held"}},
    {"simulating", {"camera_pressed", "camera_moving"}},
    {"simulation_held", {"pedal_pressed", "simulating"}},
    {"simulation_held", {"simulation_ended", "returning"}},
    {"simulation_held", {"camera_pressed", "camera_moving"}},
    {"trial", {"pedal_released", "trial_held"}},
    {"trial", {"time_slip", "trial_held"}},
    {"trial", {"trial_done", "trial_ready"}},
    {"trial", {"camera_pressed", "camera_moving"}},
    {"trial_held", {"pedal_pressed", "trial"}},
    {"trial_held", {"trial_done", "trial_ready"}},
    {"trial_held", {"trial_discarded", "returning"}},
    {"trial_held", {"camera_pressed", "camera_moving"}},
    {"trial_ready", {"trial_discarded", "returning"}},
    {"trial_ready", {"repeat_wanted", "returning"}},
    {"returning", {"returned", "pedal_up"}},
    {"returning", {"repeat_armed", "armed"}},
    {"camera_moving", {"camera_left", "pedal_up"}},
    {"camera_moving", {"camera_left_alone", "simulation_held"}},
    {"camera_moving", {"camera_left_on_tape", "trial_held"}},
    {"replaying", {"replay_ended", "pedal_up"}},
};

std::string expected(const std::string& mode, const std::string& event) {
  if (event == "emergency_stop") return "stopped";
  const auto [begin, end] = kChanges.equal_range(mode);
  for (auto row = begin; row != end; ++row) {
    if (row->second.first == event) return row->second.second;
  }
  return mode;
}

TEST(ModeTable, EveryModeMeetsEveryEvent) {
  std::size_t changes = 0;
  for (std::size_t m = 0; m < kModeCount; ++m) {
    for (std::size_t e = 0; e < kEventCount; ++e) {
      const auto mode = static_cast<Mode>(m), next = nextMode(mode, static_cast<Event>(e));
      EXPECT_EQ(kModeNames[static_cast<std::size_t>(next)], expected(kModeNames[m], kEventNames[e]))
          << kModeNames[m] << ", " << kEventNames[e];
      changes += next != mode ? 1 : 0;
    }
  }
  EXPECT_EQ(changes, kChanges.size() + kModeCount - 1) << "and every mode but one can be stopped";
}

/** Modes that `from` leads to, itself included. */
std::set<Mode> reachable(Mode from) {
  std::set<Mode> found{from};
  for (bool grew = true; grew;) {
    grew = false;
    for (const Mode mode : std::set<Mode>(found)) {
      for (std::size_t e = 0; e < kEventCount; ++e)
        grew = found.insert(nextMode(mode, static_cast<Event>(e))).second || grew;
    }
  }
  return found;
}

TEST(ModeTable, EveryModeIsReachedAndAllLeadBack) {
  EXPECT_EQ(reachable(Mode::kWaiting).size(), kModeCount);
  for (std::size_t m = 0; m < kModeCount; ++m)
    EXPECT_EQ(reachable(static_cast<Mode>(m)).count(Mode::kPedalUp), 1U) << kModeNames[m];
}

TEST(ModeTable, NothingButThePedalLeadsToAModeThatMovesTheRobotAndNeverWhereTheModelIsAlone) {
  const std::set<Mode> robot{Mode::kTeleoperating, Mode::kExecuting};
  const std::set<Mode> alone{Mode::kSimulating, Mode::kSimulationHeld, Mode::kTrial,    Mode::kTrialHeld,
                             Mode::kTrialReady, Mode::kReturning,      Mode::kReplaying};
  for (std::size_t m = 0; m < kModeCount; ++m) {
    for (std::size_t e = 0; e < kEventCount; ++e) {
      const auto mode = static_cast<Mode>(m);
      const auto event = static_cast<Event>(e);
      const Mode next = nextMode(mode, event);
      if (next == mode || robot.count(next) == 0) continue;
      EXPECT_EQ(event, Event::kPedalPressed) << kModeNames[m];
      EXPECT_EQ(alone.count(mode), 0U) << kModeNames[m];
    }
  }
}

TEST(ModeTable, LostTimeNeverTakesASimulationToTheRobot) {
  for (const Mode mode :
       {Mode::kSimulating, Mode::kSimulationHeld, Mode::kTrial, Mode::kTrialHeld, Mode::kTrialReady}) {
    const Mode next = nextMode(mode, Event::kTimeSlip);
    EXPECT_NE(next, Mode::kPaused);
    EXPECT_NE(nextMode(next, Event::kPedalPressed), Mode::kTeleoperating);
  }
}

TEST(ModeTable, EmergencyStopWinsFromEverywhere) {
  for (std::size_t m = 0; m < kModeCount; ++m) {
    EXPECT_EQ(nextMode(static_cast<Mode>(m), Event::kEmergencyStop), Mode::kStopped);
  }
}

TEST(ModeTable, OnlyTheClearedStopLeavesAStop) {
  for (const Event event : {Event::kRobotReady, Event::kPedalPressed, Event::kPedalReleased, Event::kPlanRequested,
                            Event::kPlanReady, Event::kPlanFailed, Event::kTimeSlip, Event::kGoalWanted,
                            Event::kPlanArmed, Event::kPlanCancelled, Event::kExecutionEnded, Event::kTrialEnded}) {
    EXPECT_EQ(nextMode(Mode::kStopped, event), Mode::kStopped);
  }
  EXPECT_EQ(nextMode(Mode::kStopped, Event::kStopCleared), Mode::kPedalUp);
}

TEST(ModeTable, ThePedalEndsPlanningAndTracking) {
  EXPECT_EQ(nextMode(Mode::kPlanning, Event::kPedalPressed), Mode::kTeleoperating);
  EXPECT_EQ(nextMode(Mode::kTracking, Event::kPedalPressed), Mode::kTeleoperating);
}

TEST(ModeTable, NoPlanWhileTheSurgeonMoves) {
  EXPECT_EQ(nextMode(Mode::kTeleoperating, Event::kPlanRequested), Mode::kTeleoperating);
}

TEST(ModeTable, ALateResultChangesNothing) {
  EXPECT_EQ(nextMode(Mode::kTeleoperating, Event::kPlanReady), Mode::kTeleoperating);
  EXPECT_EQ(nextMode(Mode::kPedalUp, Event::kPlanFailed), Mode::kPedalUp);
}

TEST(ModeTable, LostTimePausesWhateverMovesAndNothingElse) {
  for (const Mode moving :
       {Mode::kTeleoperating, Mode::kPlanning, Mode::kTracking, Mode::kChoosing, Mode::kArmed, Mode::kExecuting}) {
    EXPECT_EQ(nextMode(moving, Event::kTimeSlip), Mode::kPaused);
  }
  for (const Mode still :
       {Mode::kWaiting, Mode::kPedalUp, Mode::kStopped, Mode::kPaused, Mode::kReturning, Mode::kCameraMoving}) {
    EXPECT_EQ(nextMode(still, Event::kTimeSlip), still);
  }
}

TEST(ModeTable, OnlyANewPedalDownLeavesThePause) {
  for (const Event event : {Event::kRobotReady, Event::kPedalReleased, Event::kPlanRequested, Event::kPlanReady,
                            Event::kPlanFailed, Event::kStopCleared, Event::kTimeSlip, Event::kGoalWanted,
                            Event::kPlanArmed, Event::kPlanCancelled, Event::kExecutionEnded, Event::kTrialEnded}) {
    EXPECT_EQ(nextMode(Mode::kPaused, event), Mode::kPaused);
  }
  EXPECT_EQ(nextMode(Mode::kPaused, Event::kPedalPressed), Mode::kTeleoperating);
}

TEST(ModeTable, OnlyAnArmedPlanIsExecutedAndOnlyByThePedal) {
  for (std::size_t m = 0; m < kModeCount; ++m) {
    const auto mode = static_cast<Mode>(m);
    for (int e = 0; e <= static_cast<int>(Event::kTrialEnded); ++e) {
      const auto event = static_cast<Event>(e);
      if (mode == Mode::kExecuting || nextMode(mode, event) != Mode::kExecuting) continue;
      EXPECT_EQ(mode, Mode::kArmed);
      EXPECT_EQ(event, Event::kPedalPressed);
    }
  }
  EXPECT_EQ(nextMode(Mode::kArmed, Event::kPedalPressed), Mode::kExecuting);
}

TEST(ModeTable, ThePedalIsADeadMansSwitch) {
  EXPECT_EQ(nextMode(Mode::kExecuting, Event::kPedalReleased), Mode::kPedalUp);
}

TEST(ModeTable, ArmingTakesAPedalThatIsUp) {
  for (const Mode mode : {Mode::kPedalUp, Mode::kTracking})
    EXPECT_EQ(nextMode(mode, Event::kPlanArmed), Mode::kArmed);
  for (const Mode mode : {Mode::kWaiting, Mode::kTeleoperating, Mode::kPlanning, Mode::kStopped, Mode::kPaused,
                          Mode::kChoosing, Mode::kExecuting})
    EXPECT_EQ(nextMode(mode, Event::kPlanArmed), mode);
}

TEST(ModeTable, ThePedalMovesTheGoalAndNothingElseWhileItIsChosen) {
  EXPECT_EQ(nextMode(Mode::kChoosing, Event::kPedalPressed), Mode::kChoosing);
  EXPECT_EQ(nextMode(Mode::kChoosing, Event::kPedalReleased), Mode::kChoosing);
  EXPECT_EQ(nextMode(Mode::kChoosing, Event::kPlanRequested), Mode::kPlanning);
}

TEST(ModeTable, GivingUpLeavesEveryPartOfPlanningWithThePedalUp) {
  for (const Mode mode : {Mode::kChoosing, Mode::kPlanning, Mode::kArmed, Mode::kExecuting})
    EXPECT_EQ(nextMode(mode, Event::kPlanCancelled), Mode::kPedalUp);
  EXPECT_EQ(nextMode(Mode::kTeleoperating, Event::kPlanCancelled), Mode::kTeleoperating);
}

TEST(ModeTable, AfterATrialTheModelHoldsAfterTheRobotMovedItFollows) {
  EXPECT_EQ(nextMode(Mode::kExecuting, Event::kTrialEnded), Mode::kTracking);
  EXPECT_EQ(nextMode(Mode::kExecuting, Event::kExecutionEnded), Mode::kPedalUp);
}

TEST(ModeTable, NoPlanWhileOneIsExecuted) {
  EXPECT_EQ(nextMode(Mode::kExecuting, Event::kPlanRequested), Mode::kExecuting);
  EXPECT_EQ(nextMode(Mode::kExecuting, Event::kGoalWanted), Mode::kExecuting);
}

}  // namespace
}  // namespace raven2_trainer::control
