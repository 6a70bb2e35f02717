#include <gtest/gtest.h>

#include <cstdio>

#include "support/mode_driver.h"

// Goes from every mode to every other one, or to a refusal, while no hand moves: nothing may jump.

namespace raven2_trainer::loop {
namespace {

using raven2_trainer::testing::apart;
using raven2_trainer::testing::ModeDriver;

constexpr std::array<Mode, 17> kLed{Mode::kPedalUp,        Mode::kTeleoperating, Mode::kPlanning,  Mode::kTracking,
                                    Mode::kStopped,        Mode::kPaused,        Mode::kChoosing,  Mode::kArmed,
                                    Mode::kExecuting,      Mode::kSimulating,    Mode::kTrial,     Mode::kTrialHeld,
                                    Mode::kSimulationHeld, Mode::kTrialReady,    Mode::kReturning, Mode::kCameraMoving,
                                    Mode::kReplaying};

class ModePairs : public ::testing::TestWithParam<Mode> {
 protected:
  void SetUp() override {
    raven2_trainer::testing::useOde();
    d = std::make_unique<ModeDriver>();
    ASSERT_TRUE(d->begin());
  }

  void ask(RequestKind kind, std::uint8_t enabled = 0) { d->ask(kind, pedal, 0, enabled); }

  void press(bool down, int ticks = 5) {
    pedal = down;
    d->rest(down, ticks);
  }

  /** Presses the pedal. If `moves`, the hand moves the tip by 2 mm. */
  void move(bool moves) {
    if (!pedal) press(true);
    if (moves) d->stroke(80, away = -away);
    d->rest(pedal, 60);
  }

  void plan() {
    ask(RequestKind::kPlan);
    d->answerPlan(pedal);
  }

  /** Does what a surgeon would do to reach `mode` from any other mode. */
  void lead(Mode mode, bool moves) {
    switch (mode) {
      case Mode::kTeleoperating:
        return move(moves);
      case Mode::kPlanning:
        return ask(RequestKind::kPlan);
      case Mode::kTracking:
        plan();
        return d->rest(pedal, 420);  // until the path was shown to its end
      case Mode::kStopped:
        if (moves) lead(Mode::kSimulating, moves);  // away from the robot
        return ask(RequestKind::kEmergencyStop);
      case Mode::kPaused:
        if (moves) move(moves);
        d->rig.physics.timeSlip();
        return d->rest(pedal, 1);
      case Mode::kChoosing:
        ask(RequestKind::kBeginPlanning);
        return move(moves);
      case Mode::kArmed:
        plan();
        return ask(RequestKind::kExecutePlan);
      case Mode::kExecuting:
        lead(Mode::kArmed, moves);
        return press(true, 150);
      case Mode::kSimulating:
      case Mode::kSimulationHeld:
        ask(RequestKind::kBeginSimulation);
        move(moves);
        return mode == Mode::kSimulationHeld ? press(false) : void();
      case Mode::kTrial:
      case Mode::kTrialHeld:
      case Mode::kTrialReady:
        ask(RequestKind::kBeginTrial);
        move(moves);
        if (mode != Mode::kTrial) press(false);
        return mode == Mode::kTrialReady ? ask(RequestKind::kEndTrial) : void();
      case Mode::kReturning:
        lead(Mode::kSimulationHeld, moves);
        return ask(RequestKind::kEndSimulation);
      case Mode::kCameraMoving:
        return ask(RequestKind::kSetCameraPedal, 1);
      case Mode::kReplaying:  // the replay moves the model 8 mm from the robot and then holds
        d->beginReplay(150, /*ends=*/false, pedal);
        return d->rest(pedal, 160);
      default:
        return press(false);
    }
  }

  /** Goes back to teleoperation with the pedal up, from any mode. */
  void giveUp() {
    press(false);
    ask(RequestKind::kSetCameraPedal, 0);
    ask(RequestKind::kClearStop);
    ask(RequestKind::kCancelPlan);
    ask(RequestKind::kEndSimulation);
    ask(RequestKind::kDiscardTrial);
    ask(RequestKind::kEndReplay);
    for (int i = 0; i < 4; ++i)  // at most four plans can be under way
      d->answerPlan();
    for (int i = 0; i < 3000 && d->mode() != Mode::kPedalUp; ++i) {
      const bool waits = d->mode() == Mode::kPaused || d->mode() == Mode::kTracking;
      press(waits, 1);
    }
    press(false, 20);
  }

  /** @return whether this change of mode may move the model at once. With the pedal up the model returns at once from a
   *  goal or a path that it showed. A session that it shows comes and goes at once. No other change moves it so. */
  static bool putsBack(Mode before, Mode now) {
    if (before == Mode::kReplaying || now == Mode::kReplaying) return true;
    if (before == Mode::kChoosing) return now != Mode::kChoosing;
    return before == Mode::kTracking && (now == Mode::kPlanning || now == Mode::kChoosing || now == Mode::kArmed);
  }

  void look() {
    const ModelState model = d->rig.model();
    for (const Arm arm : kArms) {
      const double step = apart(at(model.arms, arm).p_BT, at(before.arms, arm).p_BT);
      if (!putsBack(before.mode, model.mode)) largest = std::max(largest, step);
      strayed = std::max(strayed, apart(d->robotTip(arm), at(stood, arm)));
      const MasterCommand& sent = d->rig.last_relay.command;
      sends =
          sends || at(sent.dp_I, arm) != Vec3{} || at(sent.dgrasp, arm) != 0.0 || at(sent.dq_I, arm) != kIdentityQuat;
      pushes = pushes || at(d->rig.force().force_B, arm) != Vec3{};
    }
    before = model;
  }

  std::unique_ptr<ModeDriver> d;
  bool pedal{false};
  double away{1.0};
  ModelState before{};
  PerArm<Vec3> stood{};
  double largest{0.0}, strayed{0.0};
  bool sends{false}, pushes{false};
};

TEST_P(ModePairs, LeadToEveryOtherModeWithoutAJump) {
  // A model that is linked, or that a pause has put back, still catches up with its lag.
  const bool follows_hands = GetParam() == Mode::kTeleoperating || GetParam() == Mode::kPaused;
  double worst_step = 0.0, worst_stray = 0.0, worst_error = 0.0;
  int changes = 0;
  for (const Mode next : kLed) {
    SCOPED_TRACE(kModeNames[static_cast<std::size_t>(next)]);
    lead(GetParam(), true);
    ASSERT_EQ(d->mode(), GetParam());
    if (GetParam() != Mode::kReturning) d->rest(pedal, GetParam() == Mode::kExecuting ? 20 : 100);  // hands at rest
    ASSERT_EQ(d->mode(), GetParam());
    before = d->rig.model();
    stood = {d->robotTip(Arm::kGold), d->robotTip(Arm::kGreen)};
    largest = strayed = 0.0;
    sends = pushes = false;
    d->watch = [this] { look(); };
    lead(next, false);
    changes += d->mode() != GetParam() ? 1 : 0;
    d->rest(pedal, 100);
    giveUp();
    ASSERT_EQ(d->mode(), Mode::kPedalUp);
    press(true, 40);
    ASSERT_EQ(d->mode(), Mode::kTeleoperating);
    ASSERT_EQ(d->rig.model().linked, 1);
    const double error = std::max(d->rig.error(Arm::kGold), d->rig.error(Arm::kGreen));
    d->watch = nullptr;
    press(false, 20);
    EXPECT_FALSE(sends) << "no hand moved";
    EXPECT_FALSE(pushes);
    EXPECT_LT(strayed, 0.5e-3) << "the robot does not move";
    EXPECT_LT(largest, follows_hands ? 0.5e-3 : 0.1e-3) << "the model does not jump";
    EXPECT_LT(error, 0.5e-3);
    worst_step = std::max(worst_step, largest);
    worst_stray = std::max(worst_stray, strayed);
    worst_error = std::max(worst_error, error);
  }
  EXPECT_GE(changes, GetParam() == Mode::kStopped ? 0 : 1);  // only the end of a stop leaves it
  std::printf("from %s: model at most %.3f mm a tick, robot %.3f mm, error at pedal-down %.3f mm\n",
              kModeNames[static_cast<std::size_t>(GetParam())], worst_step * 1e3, worst_stray * 1e3, worst_error * 1e3);
}

INSTANTIATE_TEST_SUITE_P(From, ModePairs, ::testing::ValuesIn(kLed), [](const ::testing::TestParamInfo<Mode>& tested) {
  return std::string(kModeNames[static_cast<std::size_t>(tested.param)]);
});

}  // namespace
}  // namespace raven2_trainer::loop
