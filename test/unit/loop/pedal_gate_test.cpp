#include "raven2_trainer/loop/pedal_gate.h"

#include <gtest/gtest.h>

namespace raven2_trainer::loop {
namespace {

constexpr std::int64_t kMillisecond = 1000000;

class Gate : public ::testing::Test {
 protected:
  PedalRequests take(std::uint32_t held, Mode mode = Mode::kPedalUp, std::uint8_t view = 0) {
    now_ns += kMillisecond;
    return gate.take({++sequence, held}, now_ns, mode, view);
  }

  /** Presses and releases a pedal. @return the request of the press. */
  RequestKind pressOf(Pedal pedal, Mode mode) {
    const PedalRequests requests = take(bit(pedal), mode);
    EXPECT_EQ(requests.count, 1U);
    take(0, mode);
    return requests.items[0].kind;
  }

  PedalGate gate{0.2};
  std::int64_t now_ns{0};
  std::uint32_t sequence{0};
};

TEST_F(Gate, APressAsksOnceHoweverLongItIsHeld) {
  EXPECT_EQ(take(0).count, 0U);
  EXPECT_EQ(take(bit(Pedal::kToolChange)).count, 1U);
  for (int i = 0; i < 100; ++i)
    EXPECT_EQ(take(bit(Pedal::kToolChange)).count, 0U);
  EXPECT_EQ(take(0).count, 0U) << "a release asks for nothing";
  EXPECT_EQ(take(bit(Pedal::kToolChange)).items[0].kind, RequestKind::kToolChange);
}

TEST_F(Gate, WhatAPressMeansDependsOnWhatThereIs) {
  EXPECT_EQ(pressOf(Pedal::kPlanning, Mode::kPedalUp), RequestKind::kBeginPlanning);
  EXPECT_EQ(pressOf(Pedal::kPlanning, Mode::kChoosing), RequestKind::kRecordGoal);
  EXPECT_EQ(pressOf(Pedal::kPlanning, Mode::kPlanning), RequestKind::kCancelPlan);
  EXPECT_EQ(pressOf(Pedal::kPlanning, Mode::kTracking), RequestKind::kBeginPlanning);
  EXPECT_EQ(pressOf(Pedal::kSimulation, Mode::kPedalUp), RequestKind::kBeginSimulation);
  EXPECT_EQ(pressOf(Pedal::kSimulation, Mode::kSimulating), RequestKind::kEndSimulation);
  EXPECT_EQ(pressOf(Pedal::kSimulation, Mode::kSimulationHeld), RequestKind::kEndSimulation);
  EXPECT_EQ(pressOf(Pedal::kTrial, Mode::kPedalUp), RequestKind::kBeginTrial);
  EXPECT_EQ(pressOf(Pedal::kTrial, Mode::kTrialHeld), RequestKind::kEndTrial);
  EXPECT_EQ(pressOf(Pedal::kTrial, Mode::kTrial), RequestKind::kEndTrial);
}

TEST_F(Gate, AStopIsAStopWhateverThereIsAndComesFirst) {
  for (std::size_t m = 0; m < kModeCount; ++m)
    EXPECT_EQ(pressOf(Pedal::kStop, static_cast<Mode>(m)), RequestKind::kEmergencyStop);
  const PedalRequests all = take((1U << kPedalCount) - 1U);
  EXPECT_EQ(all.count, kPedalCount);
  EXPECT_EQ(all.items[0].kind, RequestKind::kEmergencyStop);
}

TEST_F(Gate, TheCamerasPedalAsksForBothAndTheViewChanges) {
  EXPECT_EQ(take(bit(Pedal::kCamera)).items[0].enabled, 1);
  const PedalRequests released = take(0, Mode::kCameraMoving);
  ASSERT_EQ(released.count, 1U);
  EXPECT_EQ(released.items[0].kind, RequestKind::kSetCameraPedal);
  EXPECT_EQ(released.items[0].enabled, 0);
  EXPECT_EQ(take(bit(Pedal::kView), Mode::kPedalUp, 0).items[0].enabled, 1);
  take(0);
  EXPECT_EQ(take(bit(Pedal::kView), Mode::kPedalUp, 1).items[0].enabled, 0);
}

TEST_F(Gate, LateAndDoubledPacketsAreNotHeard) {
  sequence = 10;
  take(bit(Pedal::kCamera));
  EXPECT_EQ(gate.take({11, 0}, now_ns, Mode::kCameraMoving, 0).count, 0U) << "the packet's number is the same again";
  EXPECT_EQ(gate.take({7, 0}, now_ns, Mode::kCameraMoving, 0).count, 0U);
  EXPECT_EQ(gate.check(11, now_ns), Reject::kDuplicate);
  EXPECT_EQ(gate.check(7, now_ns), Reject::kOutOfOrder);
  EXPECT_EQ(gate.check(7, now_ns + 201 * kMillisecond), Reject::kNone) << "after a silence any number is new";
  EXPECT_EQ(gate.held(), bit(Pedal::kCamera));
  EXPECT_EQ(take(0).count, 1U);
}

TEST_F(Gate, NumbersWrap) {
  sequence = 0xFFFFFFFEU;
  take(0);
  EXPECT_EQ(take(bit(Pedal::kStop)).count, 1U) << "this packet has number 0";
}

TEST_F(Gate, SilenceLetsGoAndWhoComesBackIsHeard) {
  take(bit(Pedal::kCamera) | bit(Pedal::kStop));
  EXPECT_EQ(gate.idle(now_ns + 199 * kMillisecond).count, 0U);
  const PedalRequests silent = gate.idle(now_ns + 201 * kMillisecond);
  ASSERT_EQ(silent.count, 1U) << "of the held pedals only the camera's makes a request when released";
  EXPECT_EQ(silent.items[0].kind, RequestKind::kSetCameraPedal);
  EXPECT_EQ(silent.items[0].enabled, static_cast<std::uint8_t>(CameraPedal::kSilent));
  EXPECT_EQ(gate.idle(now_ns + 300 * kMillisecond).count, 0U);
  sequence = 0;  // a master that started again
  now_ns += 400 * kMillisecond;
  EXPECT_EQ(take(bit(Pedal::kToolChange)).count, 1U);
}

TEST_F(Gate, WhatIsHeldThroughAnOutageWasNotPressedAgain) {
  const std::uint32_t held = bit(Pedal::kTrial) | bit(Pedal::kView) | bit(Pedal::kToolChange);
  EXPECT_EQ(take(held).count, 3U);
  now_ns += 500 * kMillisecond;
  EXPECT_EQ(gate.idle(now_ns).count, 0U);
  EXPECT_EQ(take(held, Mode::kTrialHeld).count, 0U) << "the pedal held through the outage does not end the trial";
  take(0);
  EXPECT_EQ(take(bit(Pedal::kTrial), Mode::kTrialHeld).count, 1U);
}

TEST_F(Gate, CameraAndStopAreAskedForAgainAfterAnOutage) {
  EXPECT_EQ(take(bit(Pedal::kCamera) | bit(Pedal::kStop)).count, 2U);
  now_ns += 500 * kMillisecond;
  EXPECT_EQ(gate.idle(now_ns).count, 1U);
  const PedalRequests again = take(bit(Pedal::kCamera) | bit(Pedal::kStop));
  ASSERT_EQ(again.count, 2U);
  EXPECT_EQ(again.items[0].kind, RequestKind::kEmergencyStop);
}

TEST_F(Gate, OfAMasterThatStartedAnewNothingIsKnown) {
  sequence = 100;
  take(bit(Pedal::kPlanning));
  now_ns += 500 * kMillisecond;
  gate.idle(now_ns);
  sequence = 0;
  EXPECT_EQ(take(bit(Pedal::kPlanning)).count, 1U);
}

}  // namespace
}  // namespace raven2_trainer::loop
