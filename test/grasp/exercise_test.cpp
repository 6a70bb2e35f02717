#include <gtest/gtest.h>

#include <cstdio>

#include "grasp/ring_judge.h"
#include "grasp/ring_task.h"
#include "raven2_trainer/config/load_exercise.h"
#include "raven2_trainer/training/exercise_judge.h"
#include "support/frs_roles.h"

// The exercise pick_hand_over_place in the physics. The simulated surgeon does not know the judge; contacts are those
// of the shipped scene. RingJudge judges the same ticks.

namespace raven2_trainer::testing {
namespace {

class Examination {
 public:
  explicit Examination(std::uint64_t seed)
      : hands(trainerConfig()),
        ring(hands),
        task(&hands, seed),
        exercise(
            config::loadExercise(RAVEN2_TRAINER_SOURCE_DIR "/config/exercises/pick_hand_over_place.yaml", frsRoles())),
        judge(exercise,
              frsRoles(),
              hands.scene(),
              hands.config().arms,
              hands.config().render.cameras.at(0),
              hands.world().bodyNames()) {
    judge.start();
    hands.setObserver([this](const Hands& h) { observe(h); });
  }

  std::uint32_t mistakes(Mistake kind) const { return judge.state().mistakes[static_cast<std::size_t>(kind)]; }
  int count(ExerciseEventKind kind) const { return counts[static_cast<std::size_t>(kind)]; }

  Hands hands;
  RingJudge ring;
  RingTask task;
  Exercise exercise;
  training::ExerciseJudge judge;
  std::array<int, kExerciseEventKindCount> counts{};
  double nearest_target{1.0};  ///< [m]

 private:
  void observe(const Hands& h) {
    ring.observe(h);
    model_.tick = h.ticks();
    model_.mode = Mode::kTeleoperating;
    model_.pedal = 1;
    for (const Arm arm : kArms) {
      ArmState& state = at(model_.arms, arm);
      h.world().jointState(arm, &state.q, &state.dq);
      const Pose X_BT = kinematics::forward(h.geometry(), arm, state.q);
      state.p_BT = toArray(X_BT.p);
      state.q_BT = toArray(Quaternion(X_BT.R));
    }
    h.world().bodyPoses(&model_.bodies);
    h.world().contactList(&contacts_);
    judge.tick(model_, contacts_, {});
    for (std::size_t i = 0; i < judge.eventCount(); ++i)
      ++counts[static_cast<std::size_t>(judge.event(i).kind)];
    nearest_target = std::min(nearest_target, judge.signals().target_distance);
  }

  ModelState model_{};
  ContactList contacts_{};
};

class ExaminedSeeds : public ::testing::TestWithParam<int> {};

TEST_P(ExaminedSeeds, PickingHandingOverAndPlacingIsDoneStepByStep) {
  Examination e(static_cast<std::uint64_t>(GetParam()));
  EXPECT_EQ(e.judge.state().status, ExerciseStatus::kNone);
  e.task.pickUp();
  EXPECT_EQ(e.judge.state().status, ExerciseStatus::kRunning);
  EXPECT_EQ(e.judge.state().step, 2U) << "lifted";
  EXPECT_EQ(e.judge.state().bodies[0], kHeldByGold);
  e.task.handOver();
  EXPECT_EQ(e.judge.state().step, 3U) << "handed over";
  EXPECT_EQ(e.judge.state().bodies[0], kHeldByGreen);
  e.task.putOver(kTower);
  e.hands.hold(0.5);
  EXPECT_EQ(e.judge.state().status, ExerciseStatus::kDone);
  EXPECT_TRUE(e.ring.isAround(kTower, kTowerHeight));
  EXPECT_EQ(e.count(ExerciseEventKind::kHeld), 2);
  EXPECT_EQ(e.count(ExerciseEventKind::kReleased), 2);
  for (const Mistake kind : {Mistake::kDrop, Mistake::kOutOfOrder, Mistake::kWrongArm, Mistake::kWireTouch})
    EXPECT_EQ(e.mistakes(kind), 0U) << kMistakeNames[static_cast<std::size_t>(kind)];
  EXPECT_LT(e.nearest_target, 0.015) << "[m] from a tip to the ring's target";
  std::printf("  seed %d: done in %.1f s, %u collisions\n", GetParam(),
              static_cast<double>(e.judge.state().ended - e.judge.state().began) * kTickSeconds,
              e.mistakes(Mistake::kCollision));
}

INSTANTIATE_TEST_SUITE_P(Three, ExaminedSeeds, ::testing::Range(0, 3));

TEST(Examined, LettingGoInTheAirIsADrop) {
  Examination e(1);
  e.task.pickUp();
  ASSERT_EQ(e.judge.state().bodies[0], kHeldByGold);
  e.hands.open(Arm::kGold, RingTask::kReady);
  e.hands.hold(1.0);
  EXPECT_EQ(e.mistakes(Mistake::kDrop), 1U);
  EXPECT_EQ(e.count(ExerciseEventKind::kDropped), 1);
  EXPECT_EQ(e.judge.state().status, ExerciseStatus::kRunning);
}

TEST(Examined, PlacingWithoutHandingOverIsOutOfOrderAndNotDone) {
  Examination e(2);
  // green takes the ring from the stand: the wrong arm; the ring reaches the tower before that step is due
  e.task.grip(Arm::kGreen);
  e.task.carry(Arm::kGreen, level({0.010, 0.0, 0.045}));
  e.task.putOver(kTower);
  e.hands.hold(1.5);
  EXPECT_EQ(e.mistakes(Mistake::kWrongArm), 1U);
  EXPECT_EQ(e.mistakes(Mistake::kOutOfOrder), 1U);
  EXPECT_EQ(e.judge.state().step, 1U);
  EXPECT_EQ(e.judge.state().status, ExerciseStatus::kRunning);
}

}  // namespace
}  // namespace raven2_trainer::testing
