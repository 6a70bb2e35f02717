#include <gtest/gtest.h>

#include <cmath>

#include "judge_support.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/core/random.h"

// Mistakes and failed attempts, from hand-made contacts and poses.

namespace raven2_trainer::training::testing {
namespace {

using K = PredicateKind;
using E = ExerciseEventKind;

constexpr auto kBroken = ExerciseFailure::kBrokeOff;

Bench watching(std::vector<WatchRule> rules) {
  return Bench(Bench::with({endless()}, std::move(rules)));
}

WatchRule wireRule(double force = 0.1, double gap = 0.05) {
  return touchRule(Mistake::kWireTouch, {"grasper1_L", "grasper2_L", "grasper1_R", "ring"}, {"wire"}, force, gap);
}

// ---- touches

TEST(JudgeTouch, CountsAtItsBeginningAndTellsItsLengthAndPeakAtItsEnd) {
  Bench bench = watching({wireRule()});
  bench.run(10);
  bench.touch(kJaw1L, kWire, 0.2);
  bench.run(30);
  EXPECT_EQ(bench.mistakes(Mistake::kWireTouch), 1U);
  EXPECT_EQ(bench.count(E::kTouchBegan), 1);
  EXPECT_EQ(bench.count(E::kMistake), 1);
  bench.contacts.contacts[0].f_W[1] += 0.6;  // 0.36 N more along the normal
  bench.run(10);
  bench.clearContacts();
  bench.run(50);
  EXPECT_EQ(bench.count(E::kTouchEnded), 0);
  bench.run(1);
  ASSERT_EQ(bench.count(E::kTouchEnded), 1);
  const ExerciseEvent& end = *bench.last(E::kTouchEnded);
  EXPECT_NEAR(end.value, 0.040, 1e-9);
  EXPECT_NEAR(end.force, 0.56, 1e-9);
  EXPECT_EQ(end.a, kJaw1L);
  EXPECT_EQ(end.b, kWire);
  EXPECT_EQ(end.mistake, Mistake::kWireTouch);
  EXPECT_EQ(bench.mistakes(Mistake::kWireTouch), 1U);
}

TEST(JudgeTouch, AShortGapDoesNotPartIt) {
  for (const int gap : {50, 51}) {
    Bench bench = watching({wireRule()});
    bench.run(1);
    for (int i = 0; i < 3; ++i) {
      bench.touch(kJaw1L, kWire, 0.2);
      bench.run(5);
      bench.clearContacts();
      bench.run(gap);
    }
    EXPECT_EQ(bench.mistakes(Mistake::kWireTouch), gap == 50 ? 1U : 3U);
  }
}

TEST(JudgeTouch, BelowItsForceItIsNone) {
  Bench bench = watching({wireRule(0.1)});
  bench.touch(kJaw1L, kWire, 0.049);
  bench.touch(kJaw1L, kWire, 0.049);
  bench.run(10);
  EXPECT_EQ(bench.mistakes(Mistake::kWireTouch), 0U);
  bench.touch(kJaw2L, kWire, 0.049);  // the arm's links together
  bench.run(1);
  EXPECT_EQ(bench.mistakes(Mistake::kWireTouch), 1U);
}

TEST(JudgeTouch, ArmsAndBodiesAreParties) {
  Bench bench = watching({wireRule()});
  bench.touch(kJaw1L, kWire, 0.2);
  bench.touch(kJaw2L, kWire, 0.2);  // the same arm
  bench.run(5);
  EXPECT_EQ(bench.mistakes(Mistake::kWireTouch), 1U);
  bench.touch(kJaw1R, kWire, 0.2);  // the other one
  bench.run(5);
  EXPECT_EQ(bench.mistakes(Mistake::kWireTouch), 2U);
  bench.touch(kRing, kWire, 0.2);  // and what is held; the wire has the lower number
  bench.run(5);
  EXPECT_EQ(bench.mistakes(Mistake::kWireTouch), 3U);
  EXPECT_EQ(bench.last(E::kTouchBegan)->a, kRing);
  EXPECT_EQ(bench.last(E::kTouchBegan)->b, kWire);
}

TEST(JudgeTouch, WhatIsNotNamedIsNotLookedAt) {
  Bench bench = watching({wireRule()});
  bench.touch(kJaw2R, kWire, 5.0);
  bench.touch(kBlock, kWire, 5.0);
  bench.touch(kJaw1L, kTowerA, 5.0);
  bench.touch(kJaw1L, kRing, 5.0);
  bench.run(100);
  EXPECT_EQ(bench.mistakes(Mistake::kWireTouch), 0U);
  EXPECT_EQ(bench.count(E::kTouchBegan), 0);
}

TEST(JudgeTouch, RulesOfOneKindAddUpAndKeepTheirOwnLimits) {
  WatchRule towers = touchRule(Mistake::kCollision, {"grasper1_L"}, {"tower_a", "tower_b"}, 0.1, 0.05);
  WatchRule arms = touchRule(Mistake::kCollision, {"grasper1_L"}, {"grasper1_R"}, 0.1, 0.05);
  towers.limit = 2;
  arms.limit = 1;
  Bench bench = watching({towers, arms});
  bench.touch(kJaw1L, kTowerA, 0.2);
  bench.touch(kJaw1L, kTowerB, 0.2);
  bench.touch(kJaw1L, kJaw1R, 0.2);
  bench.run(10);
  EXPECT_EQ(bench.mistakes(Mistake::kCollision), 3U);
  EXPECT_EQ(bench.state().status, ExerciseStatus::kRunning);
  bench.clearContacts();
  bench.run(60);
  bench.touch(kJaw1L, kJaw1R, 0.2);  // the second of one
  bench.run(1);
  EXPECT_EQ(bench.state().status, ExerciseStatus::kFailed);
  EXPECT_EQ(bench.state().failure, ExerciseFailure::kMistakes);
  EXPECT_EQ(bench.mistakes(Mistake::kCollision), 4U);
}

TEST(JudgeTouch, OneOfTheSameRuleOnBothSidesCountsOnce) {
  Bench bench =
      watching({touchRule(Mistake::kCollision, {"grasper1_L", "grasper1_R"}, {"grasper1_L", "grasper1_R"}, 0.1, 0.05)});
  bench.touch(kJaw1L, kJaw1R, 0.2);
  bench.run(10);
  EXPECT_EQ(bench.mistakes(Mistake::kCollision), 1U);
}

TEST(JudgeTouch, FailsAtOnceWhereTheRuleSaysSo) {
  WatchRule strict = wireRule();
  strict.fails = 1;
  Bench bench = watching({strict});
  bench.run(3);
  bench.touch(kJaw1L, kWire, 0.2);
  bench.run(10);
  EXPECT_EQ(bench.state().status, ExerciseStatus::kFailed);
  EXPECT_EQ(bench.state().failure, ExerciseFailure::kMistakes);
  EXPECT_EQ(bench.state().ended, 4);
  EXPECT_EQ(bench.count(E::kTouchEnded), 1);  // every touch has an end
  EXPECT_EQ(bench.count(E::kFailed), 1);
}

TEST(JudgeTouch, BeforeTheTimerItDoesNotCount) {
  Exercise exercise = Bench::with({endless()}, {wireRule()});
  exercise.begin = {held(Hand::kAny)};
  Bench bench(exercise);
  bench.touch(kJaw1L, kWire, 0.2);
  bench.run(100);
  EXPECT_EQ(bench.mistakes(Mistake::kWireTouch), 0U);
}

TEST(JudgeTouch, EndsWhereNothingIsJudged) {
  Bench bench = watching({wireRule()});
  bench.touch(kJaw1L, kWire, 0.2);
  bench.run(10);
  bench.model.mode = Mode::kReturning;
  bench.run(100);
  EXPECT_EQ(bench.count(E::kTouchEnded), 1);
  EXPECT_EQ(bench.mistakes(Mistake::kWireTouch), 1U);
}

TEST(JudgeTouch, MoreThanItsTableHoldsIsNotSeenAndHurtsNothing) {
  // twelve rules and every pair of four: more touches at once than there is room for
  std::vector<WatchRule> rules;
  for (int i = 0; i < 12; ++i)
    rules.push_back(
        touchRule(Mistake::kCollision, {"plate", "tower_a", "tower_b", "wire"}, {"ring", "block"}, 0.0, 0.0));
  Bench bench = watching(rules);
  for (const std::uint16_t a : {kPlate, kTowerA, kTowerB, kWire}) {
    bench.touch(a, kRing, 1.0);
    bench.touch(a, kBlock, 1.0);
  }
  bench.run(3);
  EXPECT_EQ(bench.mistakes(Mistake::kCollision), 32U);
  EXPECT_EQ(bench.events.size() + bench.judge->lostEvents(), 2U + 2U * 32U);  // started, began, touch and mistake each
  EXPECT_EQ(bench.judge->eventCount(), 0U);
}

TEST(JudgeTouch, EndingWithTheAttemptLeavesRoomForItsEnd) {
  // 16 touches that end with it: as many events as there are places
  std::vector<WatchRule> rules;
  for (int i = 0; i < 8; ++i)
    rules.push_back(touchRule(Mistake::kCollision, {"plate"}, {"ring", "block"}, 0.0, 10.0));
  Bench bench = watching(rules);
  bench.touch(kPlate, kRing, 1.0);
  bench.touch(kPlate, kBlock, 1.0);
  bench.run(3);
  ASSERT_EQ(bench.mistakes(Mistake::kCollision), 16U);
  bench.events.clear();
  bench.judge->giveUp();
  bench.run(1);
  EXPECT_EQ(bench.state().status, ExerciseStatus::kFailed);
  EXPECT_EQ(bench.judge->eventCount(), ExerciseJudge::kMaxEvents);
  EXPECT_EQ(bench.count(E::kTouchEnded), 15);
  ASSERT_EQ(bench.count(E::kFailed), 1) << "the end of the attempt is always reported";
}

// ---- drops

WatchRule dropRule(std::uint32_t limit = 0) {
  WatchRule r = rule(Mistake::kDrop, limit);
  r.grace = 0.3;
  return r;
}

/** Lifts the ring with gold for `ticks` and opens the jaws. */
void liftAndLetGo(Bench* bench, int ticks) {
  bench->grip(Arm::kGold);
  bench->run(20 + ticks);
  bench->clearContacts();
}

TEST(JudgeDrop, IsKnownAGraceAfterTheHoldEnded) {
  Bench bench = watching({dropRule()});
  liftAndLetGo(&bench, 200);
  bench.run(50 + 299);  // 50 until it counts as released
  EXPECT_EQ(bench.mistakes(Mistake::kDrop), 0U);
  bench.run(1);
  EXPECT_EQ(bench.mistakes(Mistake::kDrop), 1U);
  EXPECT_EQ(bench.last(E::kDropped)->a, kRing);
  bench.run(1000);
  EXPECT_EQ(bench.mistakes(Mistake::kDrop), 1U);
}

TEST(JudgeDrop, CaughtInTimeIsNone) {
  Bench bench = watching({dropRule()});
  liftAndLetGo(&bench, 200);
  bench.run(300);
  bench.grip(Arm::kGreen);
  bench.run(1000);
  EXPECT_EQ(bench.mistakes(Mistake::kDrop), 0U);
}

TEST(JudgeDrop, HandedOverIsNone) {
  Bench bench = watching({dropRule()});
  bench.grip(Arm::kGold);
  bench.run(300);
  bench.grip(Arm::kGreen);
  bench.run(100);
  bench.clearContacts();
  bench.grip(Arm::kGreen);
  bench.run(1000);
  EXPECT_EQ(bench.mistakes(Mistake::kDrop), 0U);
}

TEST(JudgeDrop, FumblingWhereItLiesIsNone) {
  Bench bench = watching({dropRule()});
  bench.grip(Arm::kGold);
  bench.touch(kRing, kPlate, 0.01);  // never off the ground
  bench.run(500);
  bench.clearContacts();
  bench.run(1000);
  EXPECT_EQ(bench.mistakes(Mistake::kDrop), 0U);
  liftAndLetGo(&bench, 50);  // lifted for less than 0.1 s
  bench.run(1000);
  EXPECT_EQ(bench.mistakes(Mistake::kDrop), 0U);
}

TEST(JudgeDrop, AroundATargetItIsWhereItBelongs) {
  for (const std::uint8_t peg : {kPegA, kPegB}) {
    Exercise exercise = Bench::with({endless()}, {dropRule()});
    exercise.targets = {kPegA};
    Bench bench(exercise);
    liftAndLetGo(&bench, 200);
    bench.put(kRingSlot, {peg == kPegA ? 0.03 : -0.03, 0.0, 0.01});
    bench.run(1000);
    EXPECT_EQ(bench.mistakes(Mistake::kDrop), peg == kPegA ? 0U : 1U);
  }
}

TEST(JudgeDrop, WhereItsStepWantsItLetGoItBelongs) {
  for (const bool is_there : {true, false}) {
    const ExerciseStep lay =
        step({when(K::kAt, kRingObject, 1, Hand::kAny, 0.01), when(K::kUntouched), when(K::kResting)}, 1.0);
    Bench bench(Bench::with({track({lay}), endless()}, {dropRule()}));
    liftAndLetGo(&bench, 200);
    for (int i = 0; i < 1000; ++i) {  // it rocks all the time
      bench.putTilted(kRingSlot, {is_there ? 0.05 : 0.02, 0.02, 0.01}, i % 40 < 20 ? 0.05 : 0.0);
      bench.tick();
    }
    EXPECT_EQ(bench.mistakes(Mistake::kDrop), is_there ? 0U : 1U);
  }
}

TEST(JudgeDrop, WhereTheStepBeforeWantedItLetGoItBelongs) {
  for (const bool is_there : {true, false}) {
    const ExerciseStep lay = step({when(K::kAt, kRingObject, 1, Hand::kAny, 0.01), when(K::kUntouched)});
    Bench bench(Bench::with({track({lay, step({held(Hand::kGreen)})})}, {dropRule()}));
    bench.put(kRingSlot, {is_there ? 0.05 : 0.02, 0.02, 0.01});
    liftAndLetGo(&bench, 200);
    bench.run(1000);  // its step is done before the grace of a drop ends
    EXPECT_EQ(bench.done(), is_there ? 1 : 0);
    EXPECT_EQ(bench.mistakes(Mistake::kDrop), is_there ? 0U : 1U);
  }
}

TEST(JudgeDrop, BeyondTheLimitTheAttemptFails) {
  Bench bench = watching({dropRule(2)});
  for (int i = 0; i < 2; ++i) {
    liftAndLetGo(&bench, 200);
    bench.run(400);
  }
  EXPECT_EQ(bench.state().status, ExerciseStatus::kRunning);
  liftAndLetGo(&bench, 200);
  bench.run(400);
  EXPECT_EQ(bench.mistakes(Mistake::kDrop), 3U);
  EXPECT_EQ(bench.state().failure, ExerciseFailure::kMistakes);
}

TEST(JudgeDrop, LettingGoWhereNothingIsJudgedIsNone) {
  Bench bench = watching({dropRule()});
  bench.grip(Arm::kGold);
  bench.run(300);
  bench.model.mode = Mode::kChoosing;
  bench.clearContacts();
  bench.run(1000);
  EXPECT_EQ(bench.count(E::kReleased), 1);
  EXPECT_EQ(bench.state().bodies[kRingSlot], 0);
  bench.model.mode = Mode::kTeleoperating;
  bench.run(1000);
  EXPECT_EQ(bench.mistakes(Mistake::kDrop), 0U);
}

// ---- parts that break off

TEST(JudgeBreak, FailsTheAttemptWhereTheRuleSaysSo) {
  Bench bench = watching({rule(Mistake::kBreakOff, 0, true)});
  bench.run(10);
  bench.broken.mask = 2;
  bench.run(1);
  EXPECT_EQ(bench.state().status, ExerciseStatus::kFailed);
  EXPECT_EQ(bench.state().failure, kBroken);
  EXPECT_EQ(bench.mistakes(Mistake::kBreakOff), 1U);
  EXPECT_EQ(bench.last(E::kBrokeOff)->a, kTowerB);
  EXPECT_EQ(bench.state().bodies[kTowerBSlot], kBodyBrokenOff);
  EXPECT_EQ(bench.state().bodies[kTowerASlot], 0);
  // WHEN the other one breaks off after the attempt
  bench.broken.mask = 3;
  bench.run(1);
  EXPECT_EQ(bench.state().bodies[kTowerASlot], kBodyBrokenOff) << "the part is still broken off";
  EXPECT_EQ(bench.mistakes(Mistake::kBreakOff), 1U);
  EXPECT_EQ(bench.count(E::kBrokeOff), 1);
}

TEST(JudgeBreak, CountsOnceForEachPartAndOnlyWhereLookedFor) {
  Bench bench = watching({rule(Mistake::kBreakOff)}), blind = watching({});
  for (Bench* each : {&bench, &blind}) {
    each->broken.mask = 1;
    each->run(10);
    each->broken.mask = 3;
    each->run(10);
    EXPECT_EQ(each->count(E::kBrokeOff), 2);
    EXPECT_EQ(each->state().status, ExerciseStatus::kRunning);
  }
  EXPECT_EQ(bench.mistakes(Mistake::kBreakOff), 2U);
  EXPECT_EQ(blind.mistakes(Mistake::kBreakOff), 0U);
}

// ---- order and arm

TEST(JudgeOrder, AStepBeforeItsTracksTurnIsAMistakeOnce) {
  Bench bench(Bench::with(
      {track({step({around(kPegA)})}), track({step({held(Hand::kGold, kBlockObject)}, 0.1)}, kBlockObject, 0)},
      {rule(Mistake::kOutOfOrder)}));
  bench.run(10);
  bench.grip(Arm::kGold, kBlock);
  bench.run(20 + 98);
  EXPECT_EQ(bench.mistakes(Mistake::kOutOfOrder), 0U);
  bench.run(1);
  EXPECT_EQ(bench.mistakes(Mistake::kOutOfOrder), 1U);
  EXPECT_EQ(bench.last(E::kMistake)->a, kBlock);
  bench.run(1000);
  EXPECT_EQ(bench.mistakes(Mistake::kOutOfOrder), 1U);
  bench.clearContacts();
  bench.run(100);
  bench.grip(Arm::kGold, kBlock);
  bench.run(200);
  EXPECT_EQ(bench.mistakes(Mistake::kOutOfOrder), 2U);
  EXPECT_EQ(bench.done(1), 0);
}

TEST(JudgeOrder, ThePlaceReachedWithAStepLeftOutIsAMistake) {
  const ExerciseTrack placing =
      track({step({held(Hand::kGold)}), step({held(Hand::kGreen)}), step({around(kPegA)}, 0.05)});
  Bench bench(Bench::with({placing}, {rule(Mistake::kOutOfOrder)}));
  bench.grip(Arm::kGold);
  bench.run(30);
  ASSERT_EQ(bench.done(), 1);
  bench.clearContacts();
  bench.put(kRingSlot, {0.03, 0.0, 0.002});
  bench.run(49);
  EXPECT_EQ(bench.mistakes(Mistake::kOutOfOrder), 0U);
  bench.run(1);
  EXPECT_EQ(bench.mistakes(Mistake::kOutOfOrder), 1U);
  EXPECT_EQ(bench.done(), 1);
}

TEST(JudgeOrder, WhatWasSoFromTheStartIsNone) {
  Bench bench(
      Bench::with({track({step({held(Hand::kGold)}), step({when(K::kUntouched)})})}, {rule(Mistake::kOutOfOrder)}));
  bench.run(1000);
  EXPECT_EQ(bench.mistakes(Mistake::kOutOfOrder), 0U);
}

TEST(JudgeOrder, WhatWasSoAsTheTurnOfItsTrackCameIsNone) {
  const ExerciseTrack second =
      track({step({held(Hand::kGold, kBlockObject)}), step({around(kPegB, kBlockObject)}, 0.1)}, kBlockObject, 0);
  Bench bench(Bench::with({track({step({around(kPegA)})}), second}, {rule(Mistake::kOutOfOrder)}));
  bench.put(kBlockSlot, {-0.03, 0.0, 0.002});
  bench.run(10);
  bench.put(kRingSlot, {0.03, 0.0, 0.002});
  bench.run(300);
  ASSERT_EQ(bench.done(0), 1);
  EXPECT_EQ(bench.mistakes(Mistake::kOutOfOrder), 0U);
  // WHEN the block is taken away and put there again
  bench.put(kBlockSlot, {0.0, 0.0, 0.1});
  bench.run(10);
  bench.put(kBlockSlot, {-0.03, 0.0, 0.002});
  bench.run(300);
  EXPECT_EQ(bench.mistakes(Mistake::kOutOfOrder), 1U);
}

TEST(JudgeOrder, WhatTheStepThatIsDoneAskedForIsNoMistakeAsTheNextBegins) {
  const ExerciseTrack track_of_three =
      track({step({when(K::kUntouched)}), step({held(Hand::kGreen)}), step({when(K::kUntouched)})});
  Bench bench(Bench::with({track_of_three}, {rule(Mistake::kOutOfOrder)}));
  bench.grip(Arm::kGold);
  bench.run(30);
  ASSERT_EQ(bench.done(), 0);
  // WHEN the ring is let go, as the first step asks and as the last one will
  bench.clearContacts();
  bench.run(100);
  EXPECT_EQ(bench.done(), 1);
  EXPECT_EQ(bench.mistakes(Mistake::kOutOfOrder), 0U);
}

TEST(JudgeArm, TakenByTheArmThatNoStepSoFarAsksForIsAMistake) {
  const ExerciseTrack handing =
      track({step({held(Hand::kGreen)}), step({when(K::kHeldAlone, kRingObject, kNobody, Hand::kGold)})});
  Bench bench(Bench::with({handing}, {rule(Mistake::kWrongArm)}));
  bench.grip(Arm::kGold);
  bench.run(100);
  EXPECT_EQ(bench.mistakes(Mistake::kWrongArm), 1U);
  EXPECT_EQ(bench.last(E::kMistake)->arm, Hand::kGold);
  EXPECT_EQ(bench.last(E::kMistake)->a, kRing);
  bench.clearContacts();
  bench.run(100);
  for (int i = 0; i < 2; ++i) {  // the giver may take it again
    bench.grip(Arm::kGreen);
    bench.run(100);
    bench.clearContacts();
    bench.run(100);
  }
  bench.grip(Arm::kGold);
  bench.run(100);
  EXPECT_EQ(bench.mistakes(Mistake::kWrongArm), 1U);
  EXPECT_EQ(bench.state().status, ExerciseStatus::kDone);
}

TEST(JudgeArm, TheHoldThatBeginsTheTimerCountsToo) {
  Exercise exercise = Bench::with({track({step({held(Hand::kGreen)})})}, {rule(Mistake::kWrongArm)});
  exercise.begin = {held(Hand::kAny)};
  Bench bench(exercise);
  bench.grip(Arm::kGold);
  bench.run(100);
  EXPECT_EQ(bench.state().began, 20);
  EXPECT_EQ(bench.mistakes(Mistake::kWrongArm), 1U);
}

TEST(JudgeArm, AnyArmMayWhereNoneIsNamed) {
  Bench bench(Bench::with({track({step({when(K::kLifted), around(kPegA)})}),
                           track({step({held(Hand::kAny, kBlockObject), around(kPegA, kBlockObject)})}, kBlockObject)},
                          {rule(Mistake::kWrongArm)}));
  bench.grip(Arm::kGold);
  bench.grip(Arm::kGreen, kBlock);
  bench.run(100);
  EXPECT_EQ(bench.count(E::kHeld), 2);
  EXPECT_EQ(bench.mistakes(Mistake::kWrongArm), 0U);
}

// ---- objects that are lost

TEST(JudgeLost, RestingOutOfReachOfBothArmsFails) {
  Bench bench = watching({});
  bench.run(10);
  bench.put(kRingSlot, {0.5, 0.5, 0.002});  // more than the arms' 0.56 - 0.47 m insertion beyond the remote centres
  bench.run(900);
  EXPECT_EQ(bench.state().status, ExerciseStatus::kRunning);
  bench.run(2000);
  EXPECT_EQ(bench.state().status, ExerciseStatus::kFailed);
  EXPECT_EQ(bench.state().failure, ExerciseFailure::kObjectLost);
}

TEST(JudgeLost, ElsewhereInReachIsNotLost) {
  Bench bench = watching({});
  bench.run(10);
  bench.put(kRingSlot, {0.01, 0.0, 0.016});  // middle of the scene, where both arms work
  bench.run(10000);
  EXPECT_EQ(bench.state().status, ExerciseStatus::kRunning);
}

TEST(JudgeLost, NeitherWhileItMovesNorWhileItIsTouched) {
  Bench moving = watching({}), touched = watching({});
  for (int i = 0; i < 5000; ++i) {
    moving.put(kRingSlot, {0.5 + 1e-5 * i, 0.5, 0.002});
    moving.tick();
  }
  EXPECT_EQ(moving.state().status, ExerciseStatus::kRunning);
  touched.run(1);
  touched.put(kRingSlot, {0.5, 0.5, 0.002});
  touched.touch(kShaftL, kRing, 0.1);
  touched.run(5000);
  EXPECT_EQ(touched.state().status, ExerciseStatus::kRunning);
}

TEST(JudgeLost, NotAfterATouchBeganWhileItWasBeingSearched) {
  for (const bool is_touched : {true, false}) {
    Bench bench = watching({});
    bench.run(10);
    bench.put(kRingSlot, {0.5, 0.5, 0.002});
    bench.run(1500);  // it rests, and the search for a way to it has begun
    ASSERT_EQ(bench.state().status, ExerciseStatus::kRunning);
    if (is_touched) bench.touch(kShaftL, kRing, 0.1);
    bench.run(3000);
    EXPECT_EQ(bench.state().status, is_touched ? ExerciseStatus::kRunning : ExerciseStatus::kFailed);
  }
}

TEST(JudgeLost, FallenOffTheTableIsLost) {
  Bench bench = watching({});
  bench.run(10);
  bench.put(kRingSlot, {0.0, 0.0, -0.51});
  bench.run(1);
  EXPECT_EQ(bench.state().failure, ExerciseFailure::kObjectLost);
}

// ---- set-up

std::string refusal(const Exercise& exercise, const SceneRoles& roles = testRoles()) {
  try {
    Bench bench(exercise, roles);
  } catch (const ConfigException& e) {
    return e.what();
  }
  return "";
}

TEST(JudgeSetUp, ARuleMustNameBodies) {
  const WatchRule wrong = touchRule(Mistake::kCollision, {"grasper1_L"}, {"tower_c"}, 0.1, 0.1);
  const std::string said = refusal(Bench::with({endless()}, {wrong}));
  EXPECT_NE(said.find("test.yaml:2: b names \"tower_c\", which is no body; there are: link1_L"), std::string::npos)
      << said;
}

TEST(JudgeSetUp, AnObjectMustBeAFreeBody) {
  SceneRoles roles = testRoles();
  roles.objects[0].link = "tower_a";
  EXPECT_NE(
      refusal(Bench::with({endless()}), roles).find("hand_made.yaml:1: object \"ring\": link \"tower_a\" is no free"),
      std::string::npos);
  roles.objects[0].link = "hoop";
  EXPECT_NE(refusal(Bench::with({endless()}), roles).find("\"hoop\", which is no body"), std::string::npos);
}

TEST(JudgeSetUp, TissueMustBeThereAndFixed) {
  SceneRoles roles = testRoles();
  roles.tissue = {"liver"};
  EXPECT_NE(refusal(Bench::with({endless()}), roles).find("hand_made.urdf:1: tissue \"liver\" is no link"),
            std::string::npos);
  roles.tissue = {"ring"};
  EXPECT_NE(refusal(Bench::with({endless()}), roles).find("hand_made.urdf:7: tissue \"ring\" moves"),
            std::string::npos);
}

// ---- random input

/** Random contacts and poses, some of them impossible. */
void disturb(Random* random, Bench* bench) {
  const auto pick = [&](std::uint32_t n) { return random->next() % n; };
  if (pick(20) == 0) bench->clearContacts();
  while (bench->contacts.count < kMaxContacts && pick(4) != 0)
    bench->touch(static_cast<std::uint16_t>(pick(25)), static_cast<std::uint16_t>(pick(25)),
                 random->uniform(-0.1, 0.5));
  const std::array<Vec3, 5> places{Vec3{0.03, 0.0, 0.002}, Vec3{-0.03, 0.0, 0.002}, Vec3{0.0, 0.0, 0.1},
                                   Vec3{0.0, 0.05, 0.01}, Vec3{0.5, 0.5, 0.0}};
  if (pick(10) == 0) bench->put(pick(2), places[pick(5)]);
  if (pick(500) == 0) bench->put(kRingSlot, {std::nan(""), 0.0, 0.0});
  if (pick(100) == 0) bench->model.mode = static_cast<Mode>(pick(kModeCount));
  if (pick(100) == 0) bench->broken.mask = static_cast<std::uint16_t>(bench->broken.mask | 1U << pick(2));
  if (pick(2000) == 0) bench->judge->start();
  if (pick(8000) == 0) bench->judge->giveUp();
}

TEST(JudgeAlways, NoSequenceOfContactsBreaksWhatMustHold) {
  int done = 0, failed = 0, mistakes = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    WatchRule drop = rule(Mistake::kDrop, 30);
    drop.grace = 0.01;
    Exercise exercise =
        Bench::with({track({step({held(Hand::kAny)}), step({around(kPegA)}, 0.01), step({around(kPegB)})}),
                     track({step({around(kPegA, kBlockObject)})}, kBlockObject, 0)},
                    {wireRule(0.05, 0.01), touchRule(Mistake::kCollision, {"grasper1_L"}, {"tower_a"}, 0.1, 0.0), drop,
                     rule(Mistake::kBreakOff), rule(Mistake::kOutOfOrder), rule(Mistake::kWrongArm)});
    exercise.time_limit = 1.5;
    Bench bench(exercise);
    Random random(seed);
    ExerciseState before = bench.state();
    std::array<std::uint32_t, kMistakeCount> told{};
    int open_touches = 0;
    for (int i = 0; i < 5000; ++i) {
      disturb(&random, &bench);
      const std::size_t events_before = bench.events.size();
      const std::uint64_t lost_before = bench.judge->lostEvents();
      bench.tick();
      const ExerciseState& now = bench.state();
      bool is_new = false;
      for (std::size_t e = events_before; e < bench.events.size(); ++e) {
        const ExerciseEvent& event = bench.events[e];
        if (event.kind == E::kStarted) {
          is_new = true;
          told = {};
          open_touches = 0;
        }
        if (event.kind == E::kMistake) ++told[static_cast<std::size_t>(event.mistake)];
        open_touches += event.kind == E::kTouchBegan ? 1 : event.kind == E::kTouchEnded ? -1 : 0;
        ASSERT_GE(open_touches, 0);
      }
      ASSERT_EQ(lost_before, bench.judge->lostEvents()) << "too many events for this test to add up";
      ASSERT_EQ(now.mistakes, told);
      ASSERT_LE(bench.judge->eventCount(), ExerciseJudge::kMaxEvents);
      ASSERT_EQ(now.step, 1U + now.done[0] + now.done[1]);
      ASSERT_TRUE(now.done[1] == 0 || now.done[0] == 3);
      ASSERT_GE(now.progress, 0.0);
      ASSERT_LE(now.progress, 1.0);
      const bool is_over = now.status == ExerciseStatus::kDone || now.status == ExerciseStatus::kFailed;
      ASSERT_EQ(is_over, now.ended >= 0);
      ASSERT_EQ(now.status == ExerciseStatus::kFailed, now.failure != ExerciseFailure::kNone);
      ASSERT_EQ(now.status == ExerciseStatus::kDone, now.done[0] == 3 && now.done[1] == 1);
      ASSERT_TRUE(now.ended < 0 || now.ended >= now.began);
      ASSERT_TRUE(!is_over || open_touches == 0);
      if (!is_new) {
        ASSERT_EQ(now.attempt, before.attempt);
        ASSERT_GE(now.done[0], before.done[0]);
        ASSERT_GE(now.done[1], before.done[1]);
        ASSERT_LE(now.done[0] - before.done[0], 1);
        ASSERT_TRUE(before.began < 0 || now.began == before.began);
        for (std::size_t k = 0; k < kMistakeCount; ++k)
          ASSERT_GE(now.mistakes[k], before.mistakes[k]);
      }
      done += before.status == ExerciseStatus::kRunning && now.status == ExerciseStatus::kDone ? 1 : 0;
      failed += before.status == ExerciseStatus::kRunning && now.status == ExerciseStatus::kFailed ? 1 : 0;
      before = now;
    }
    for (const std::uint32_t n : told)
      mistakes += static_cast<int>(n);
  }
  // the walk must have been somewhere
  EXPECT_GT(done, 3);
  EXPECT_GT(failed, 10);
  EXPECT_GT(mistakes, 100);
}

TEST(JudgeAlways, TheSameTicksGiveTheSameBits) {
  const auto run = [] {
    Bench bench(Bench::with({track({step({held(Hand::kAny)}), step({around(kPegA)})})}, {wireRule(0.05, 0.01)}));
    Random random(7);
    std::vector<double> all;
    for (int i = 0; i < 2000; ++i) {
      disturb(&random, &bench);
      bench.tick();
      all.push_back(bench.judge->signals().target_distance);
      all.push_back(static_cast<double>(bench.state().step));
    }
    for (const ExerciseEvent& event : bench.events)
      all.push_back(static_cast<double>(event.kind) + 100.0 * event.a + event.force);
    return all;
  };
  const std::vector<double> a = run(), b = run();
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i)
    ASSERT_TRUE(a[i] == b[i] || (std::isnan(a[i]) && std::isnan(b[i])));
}

TEST(JudgeLost, ItIsFoundThoughAnotherObjectIsHeldMeanwhile) {
  Bench bench = watching({});
  bench.grip(Arm::kGold, kBlock);
  bench.run(10);
  bench.put(kRingSlot, {0.5, 0.5, 0.002});
  bench.run(3000);
  EXPECT_EQ(bench.state().failure, ExerciseFailure::kObjectLost);
}

TEST(JudgeLost, AnAttemptDoesNotFailByWhatTheOneBeforeWasAskingFor) {
  Bench bench = watching({});
  bench.run(10);
  bench.put(kRingSlot, {0.5, 0.5, 0.002});
  bench.run(1500);  // it rests, and is being asked for
  ASSERT_EQ(bench.state().status, ExerciseStatus::kRunning);
  bench.put(kRingSlot, {0.0, 0.0, 0.1});
  bench.model.pedal = 0;
  bench.model.mode = Mode::kPedalUp;
  bench.judge->start();
  bench.run(100);
  ASSERT_EQ(bench.state().status, ExerciseStatus::kWaiting);
  bench.model.pedal = 1;
  bench.model.mode = Mode::kTeleoperating;
  bench.run(2000);
  EXPECT_EQ(bench.state().status, ExerciseStatus::kRunning);
}

TEST(JudgeLost, WhatIsAroundItsTargetIsNotLostWhereverThatIs) {
  SceneRoles roles = testRoles();
  roles.pegs[kPegA].base_W = {0.5, 0.5, 0.0};
  Exercise exercise = Bench::with({endless()});
  exercise.targets = {kPegA};
  Bench bench(exercise, roles);
  bench.run(10);
  bench.put(kRingSlot, {0.5, 0.5, 0.010});
  bench.run(3000);
  EXPECT_EQ(bench.state().status, ExerciseStatus::kRunning);
}

/** The block begins 0.14 m from the nearer remote centre; an arm reaches 0.11 m. */
TEST(JudgeLost, WhatLiesWhereTheAttemptBeganIsNotAskedForBehindAPause) {
  Bench bench = watching({});
  bench.run(10);
  bench.model.mode = Mode::kPaused;
  bench.run(10);
  bench.model.mode = Mode::kTeleoperating;
  bench.run(5000);
  EXPECT_EQ(bench.state().status, ExerciseStatus::kRunning);
}

TEST(JudgeOrder, WhatCameAboutWhileNothingWasJudgedIsNone) {
  const ExerciseTrack placing = track({step({held(Hand::kGold)}), step({around(kPegA)}, 0.05)});
  Bench bench(Bench::with({placing}, {rule(Mistake::kOutOfOrder)}));
  bench.run(10);
  bench.model.mode = Mode::kChoosing;
  bench.put(kRingSlot, {0.03, 0.0, 0.002});
  bench.run(10);
  bench.model.mode = Mode::kTeleoperating;
  bench.run(200);
  EXPECT_EQ(bench.mistakes(Mistake::kOutOfOrder), 0U);
}

TEST(JudgeArm, BeforeTheTurnOfItsTrackNoArmIsWrong) {
  const ExerciseTrack second = track({step({held(Hand::kGold, kBlockObject)}, 10.0)}, kBlockObject, 0);
  Bench bench(Bench::with({track({step({around(kPegA)})}), second}, {rule(Mistake::kWrongArm)}));
  bench.run(1);
  bench.grip(Arm::kGreen, kBlock);
  bench.run(50);
  ASSERT_EQ(bench.state().bodies[kBlockSlot], kHeldByGreen);
  EXPECT_EQ(bench.mistakes(Mistake::kWrongArm), 0U);
}

}  // namespace
}  // namespace raven2_trainer::training::testing
