#include <gtest/gtest.h>

#include <cmath>

#include "judge_support.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"

// The conditions of steps, from hand-made contacts and poses.

namespace raven2_trainer::training::testing {
namespace {

using K = PredicateKind;

/** One step that waits for one thing, without dwell. */
Bench waitingFor(const Predicate& predicate, double dwell = 0.0) {
  return Bench(Bench::with({track({step({predicate}, dwell)})}));
}

/** Whether the step is done within `ticks`. */
bool isDone(Bench* bench, int ticks = 1) {
  bench->run(ticks);
  return bench->state().status == ExerciseStatus::kDone;
}

// ---- holding

TEST(JudgeHold, TakesTwentyTicksOfBothJaws) {
  Bench bench = waitingFor(held(Hand::kGold));
  bench.grip(Arm::kGold);
  EXPECT_FALSE(isDone(&bench, 19));
  EXPECT_TRUE(isDone(&bench));
  EXPECT_EQ(bench.state().bodies[kRingSlot], kHeldByGold);
  ASSERT_NE(bench.last(ExerciseEventKind::kHeld), nullptr);
  EXPECT_EQ(bench.last(ExerciseEventKind::kHeld)->a, kRing);
  EXPECT_EQ(bench.last(ExerciseEventKind::kHeld)->arm, Hand::kGold);
}

TEST(JudgeHold, OneTickWithoutPressBeginsAnew) {
  Bench bench = waitingFor(held(Hand::kGold));
  bench.grip(Arm::kGold);
  bench.run(19);
  bench.clearContacts();
  bench.run(1);
  bench.grip(Arm::kGold);
  EXPECT_FALSE(isDone(&bench, 19));
  EXPECT_TRUE(isDone(&bench));
}

TEST(JudgeHold, OneJawIsNotEnough) {
  Bench bench = waitingFor(held(Hand::kAny));
  bench.touch(kJaw1L, kRing, 1.0);
  bench.touch(kShaftL, kRing, 1.0);
  EXPECT_FALSE(isDone(&bench, 200));
}

TEST(JudgeHold, JawsOfTwoArmsAreNoGrip) {
  Bench bench = waitingFor(held(Hand::kAny));
  bench.touch(kJaw1L, kRing, 1.0);
  bench.touch(kJaw2R, kRing, 1.0);
  EXPECT_FALSE(isDone(&bench, 200));
}

TEST(JudgeHold, PressIsTheSumOfAJawsContactsAndMustPassFiftyMillinewton) {
  Bench weak = waitingFor(held(Hand::kGold)), strong = waitingFor(held(Hand::kGold));
  for (Bench* bench : {&weak, &strong}) {
    const double force = bench == &weak ? 0.024 : 0.026;
    for (int i = 0; i < 2; ++i) {
      bench->touch(kJaw1L, kRing, force);
      bench->touch(kJaw2L, kRing, force);
    }
  }
  EXPECT_FALSE(isDone(&weak, 100));
  EXPECT_TRUE(isDone(&strong, 20));
}

TEST(JudgeHold, PullingIsNoPress) {
  Bench bench = waitingFor(held(Hand::kGold));
  bench.grip(Arm::kGold, kRing, -0.2);
  EXPECT_FALSE(isDone(&bench, 100));
}

TEST(JudgeHold, LastsFiftyTicksBeyondTheLastPress) {
  Bench bench(Bench::with({endless()}));
  bench.grip(Arm::kGreen);
  bench.run(30);
  bench.clearContacts();
  bench.run(49);
  EXPECT_EQ(bench.state().bodies[kRingSlot], kHeldByGreen);
  EXPECT_EQ(bench.count(ExerciseEventKind::kReleased), 0);
  bench.run(1);
  EXPECT_EQ(bench.state().bodies[kRingSlot], 0);
  EXPECT_EQ(bench.count(ExerciseEventKind::kReleased), 1);
  EXPECT_EQ(bench.last(ExerciseEventKind::kReleased)->arm, Hand::kGreen);
}

TEST(JudgeHold, IsOfTheArmThatIsAskedFor) {
  const struct {
    Hand hand;
    bool by_gold, by_green, by_both;
  } cases[] = {{Hand::kGold, true, false, true},
               {Hand::kGreen, false, true, true},
               {Hand::kAny, true, true, true},
               {Hand::kBoth, false, false, true}};
  for (const auto& c : cases) {
    Bench gold = waitingFor(held(c.hand)), green = waitingFor(held(c.hand)), both = waitingFor(held(c.hand));
    gold.grip(Arm::kGold);
    green.grip(Arm::kGreen);
    both.grip(Arm::kGold);
    both.grip(Arm::kGreen);
    EXPECT_EQ(isDone(&gold, 25), c.by_gold) << static_cast<int>(c.hand);
    EXPECT_EQ(isDone(&green, 25), c.by_green) << static_cast<int>(c.hand);
    EXPECT_EQ(isDone(&both, 25), c.by_both) << static_cast<int>(c.hand);
  }
}

TEST(JudgeHold, AnotherObjectIsAnother) {
  Bench bench = waitingFor(held(Hand::kGold));
  bench.grip(Arm::kGold, kBlock);
  EXPECT_FALSE(isDone(&bench, 100));
  EXPECT_EQ(bench.state().bodies[kBlockSlot], kHeldByGold);
}

TEST(JudgeHeldAlone, NothingElseMayTouch) {
  const struct {
    std::uint16_t other;
    Hand hand;
    bool alone;
  } cases[] = {{kPlate, Hand::kGold, false},  {kTowerA, Hand::kAny, false}, {kBlock, Hand::kGold, false},
               {kShaftR, Hand::kGold, false}, {kShaftL, Hand::kGold, true}, {kShaftL, Hand::kAny, true}};
  for (const auto& c : cases) {
    Bench bench = waitingFor(when(K::kHeldAlone, kRingObject, kNobody, c.hand));
    bench.grip(Arm::kGold);
    bench.touch(kRing, c.other, 0.01);
    EXPECT_EQ(isDone(&bench, 100), c.alone) << c.other;
  }
}

TEST(JudgeHeldAlone, HandingOverEndsWhenTheGiverIsOff) {
  Bench bench = waitingFor(when(K::kHeldAlone, kRingObject, kNobody, Hand::kGreen));
  bench.grip(Arm::kGold);
  bench.grip(Arm::kGreen);
  EXPECT_FALSE(isDone(&bench, 100));
  bench.clearContacts();
  bench.grip(Arm::kGreen);
  EXPECT_TRUE(isDone(&bench));
}

TEST(JudgeHeldAlone, ByBothMeansBothAndNothingElse) {
  Bench bench = waitingFor(when(K::kHeldAlone, kRingObject, kNobody, Hand::kBoth));
  bench.grip(Arm::kGold);
  bench.grip(Arm::kGreen);
  bench.touch(kRing, kPlate, 0.01);
  EXPECT_FALSE(isDone(&bench, 100));
  bench.contacts.count -= 1;
  EXPECT_TRUE(isDone(&bench));
}

TEST(JudgeHeldAlone, ByBothIsNotByOneOfThem) {
  for (const Arm arm : kArms) {
    Bench bench = waitingFor(when(K::kHeldAlone, kRingObject, kNobody, Hand::kBoth));
    bench.grip(arm);
    EXPECT_FALSE(isDone(&bench, 100)) << name(arm);
    bench.grip(otherArm(arm));
    EXPECT_TRUE(isDone(&bench, 25)) << name(arm);
  }
}

TEST(JudgeUntouched, NoArmPresses) {
  Bench bench = waitingFor(when(K::kUntouched));
  bench.touch(kShaftR, kRing, 0.001);
  EXPECT_FALSE(isDone(&bench, 10));
  bench.clearContacts();
  bench.touch(kRing, kPlate, 1.0);
  EXPECT_TRUE(isDone(&bench));
}

// ---- places of objects

TEST(JudgeAround, ThePegsAxisGoesThroughTheOpening) {
  const struct {
    Vec3 p;
    double tilt;
    bool around;
  } cases[] = {
      {{0.03, 0.0, 0.002}, 0.0, true},      // on the plate
      {{0.0379, 0.0, 0.002}, 0.0, true},    // 7.9 mm aside: the opening has 8
      {{0.0381, 0.0, 0.002}, 0.0, false},   //
      {{0.036, 0.006, 0.002}, 0.0, false},  // 8.5 mm aside, inside of a square of that half edge
      {{0.03, 0.0, 0.0199}, 0.0, true},     // just below the top, and just above
      {{0.03, 0.0, 0.0201}, 0.0, false},    //
      {{0.03, 0.0, -0.001}, 0.0, false},    // below the foot
      {{0.03, 0.0, 0.01}, 1.2, true},       // steep: 69 degrees
      {{0.03, 0.0, 0.01}, 1.3, false},      // on its edge: 74 degrees
      {{-0.03, 0.0, 0.002}, 0.0, false},    // the other peg
  };
  for (const auto& c : cases) {
    Bench bench = waitingFor(around(kPegA));
    bench.putTilted(kRingSlot, c.p, c.tilt);
    EXPECT_EQ(isDone(&bench), c.around) << c.p[0] << " " << c.p[1] << " " << c.p[2] << " " << c.tilt;
  }
}

TEST(JudgeAround, ATiltedRingMeetsTheAxisElsewhere) {
  // 45 degrees about x: over the peg's axis the plane is 5 mm higher than the middle that is 5 mm off in y
  Bench in = waitingFor(around(kPegA)), out = waitingFor(around(kPegA));
  in.putTilted(kRingSlot, {0.03, -0.005, 0.010}, kPi / 4);   // meets at z = 15 mm, 7.1 mm from the middle
  out.putTilted(kRingSlot, {0.03, -0.006, 0.010}, kPi / 4);  // 8.5 mm from the middle
  EXPECT_TRUE(isDone(&in));
  EXPECT_FALSE(isDone(&out));
}

TEST(JudgeAround, ASquareOpeningHasCorners) {
  const Predicate predicate = around(kPegA, kBlockObject);
  Bench in = waitingFor(predicate), out = waitingFor(predicate);
  in.put(kBlockSlot, {0.0355, 0.0055, 0.002});
  out.put(kBlockSlot, {0.0365, 0.0, 0.002});
  EXPECT_TRUE(isDone(&in));
  EXPECT_FALSE(isDone(&out));
}

TEST(JudgeAround, NegatedIsLeaving) {
  Bench bench = waitingFor(unless(around(kPegA)));
  bench.put(kRingSlot, {0.03, 0.0, 0.002});
  EXPECT_FALSE(isDone(&bench, 10));
  bench.put(kRingSlot, {0.03, 0.0, 0.03});
  EXPECT_TRUE(isDone(&bench));
}

TEST(JudgeLifted, IsFreeOfPegsAndOfWhatIsFixed) {
  Bench bench = waitingFor(when(K::kLifted));
  bench.put(kRingSlot, {0.03, 0.0, 0.015});  // around a peg, touching nothing
  EXPECT_FALSE(isDone(&bench, 5));
  bench.put(kRingSlot, {0.0, 0.0, 0.002});
  bench.touch(kRing, kPlate, 0.008);
  EXPECT_FALSE(isDone(&bench, 5));
  bench.clearContacts();
  bench.touch(kRing, kJaw1L, 1.0);
  bench.touch(kRing, kBlock, 1.0);
  EXPECT_TRUE(isDone(&bench));
}

TEST(JudgeResting, IsSlowerThanAMillimetreASecond) {
  Bench slow = waitingFor(when(K::kResting)), fast = waitingFor(when(K::kResting));
  for (int i = 0; i < 100; ++i) {
    slow.put(kRingSlot, {0.9e-6 * i, 0.0, 0.002});
    fast.put(kRingSlot, {1.1e-6 * i, 0.0, 0.002});
    slow.tick();
    fast.tick();
  }
  EXPECT_EQ(slow.state().status, ExerciseStatus::kDone);
  EXPECT_EQ(fast.state().status, ExerciseStatus::kRunning);
}

TEST(JudgeResting, TurnsSlowerThanATwentiethRadianASecond) {
  Bench slow = waitingFor(when(K::kResting)), fast = waitingFor(when(K::kResting));
  for (int i = 0; i < 100; ++i) {
    slow.putTilted(kRingSlot, {0, 0, 0.002}, 0.045e-3 * i);
    fast.putTilted(kRingSlot, {0, 0, 0.002}, 0.055e-3 * i);
    slow.tick();
    fast.tick();
  }
  EXPECT_EQ(slow.state().status, ExerciseStatus::kDone);
  EXPECT_EQ(fast.state().status, ExerciseStatus::kRunning);
}

/** The judge looks at the object every 20 ms, and the sine of half a revolution is zero. */
TEST(JudgeResting, AnObjectThatTurnsOverBetweenTwoLooksDoesNotRest) {
  Bench bench = waitingFor(when(K::kResting));
  for (int i = 0; i < 1000; ++i) {
    bench.putTilted(kRingSlot, {0, 0, 0.002}, i / 20 % 2 == 0 ? 0.0 : kPi);
    bench.tick();
  }
  EXPECT_EQ(bench.done(), 0);
}

TEST(JudgeResting, TremblingInPlaceIsRest) {
  Bench bench = waitingFor(when(K::kResting));
  for (int i = 0; i < 60; ++i) {
    bench.put(kRingSlot, {i % 2 == 0 ? 2e-6 : -2e-6, 0.0, 0.002});  // 4 mm/s from tick to tick
    bench.tick();
  }
  EXPECT_EQ(bench.state().status, ExerciseStatus::kDone);
}

TEST(JudgeAt, IsWithinSoFarOfAPoint) {
  Bench near = waitingFor(when(K::kAt, kRingObject, 0, Hand::kAny, 0.005));
  Bench far = waitingFor(when(K::kAt, kRingObject, 0, Hand::kAny, 0.005));
  near.put(kRingSlot, {0.003, 0.0, 0.0439});  // 4.92 mm off
  far.put(kRingSlot, {0.003, 0.0, 0.0441});   // 5.08 mm off
  EXPECT_TRUE(isDone(&near));
  EXPECT_FALSE(isDone(&far));
}

// ---- tips

TEST(JudgeTips, NearAPoint) {
  const struct {
    Hand hand;
    bool gold_alone, green_alone, both;
  } cases[] = {{Hand::kGold, true, false, true},
               {Hand::kGreen, false, true, true},
               {Hand::kAny, true, true, true},
               {Hand::kBoth, false, false, true}};
  for (const auto& c : cases) {
    Bench bench = waitingFor(when(K::kTipNear, kNobody, 0, c.hand, 0.002));
    bench.tip(Arm::kGold, {0.0, 0.0019, 0.04});
    EXPECT_EQ(isDone(&bench), c.gold_alone);
    Bench green = waitingFor(when(K::kTipNear, kNobody, 0, c.hand, 0.002));
    green.tip(Arm::kGreen, {0.0, 0.0019, 0.04});
    EXPECT_EQ(isDone(&green), c.green_alone);
    Bench two = waitingFor(when(K::kTipNear, kNobody, 0, c.hand, 0.002));
    two.tip(Arm::kGold, {0.0, 0.0019, 0.04});
    two.tip(Arm::kGreen, {0.0, -0.0019, 0.04});
    EXPECT_EQ(isDone(&two), c.both);
  }
  Bench far = waitingFor(when(K::kTipNear, kNobody, 0, Hand::kAny, 0.002));
  far.tip(Arm::kGold, {0.0, 0.0021, 0.04});
  EXPECT_FALSE(isDone(&far));
}

TEST(JudgeTips, InsideAndOutsideARegion) {
  const Predicate inside = when(K::kTipInside, kNobody, 0, Hand::kGreen);
  const Predicate outside = when(K::kTipOutside, kNobody, 0, Hand::kGreen);
  for (const bool is_in : {true, false}) {
    Bench in = waitingFor(inside), out = waitingFor(outside);
    for (Bench* bench : {&in, &out}) {
      bench->tip(Arm::kGold, {0.0, 0.0, is_in ? 0.03 : 0.01});  // the other arm does not count
      bench->tip(Arm::kGreen, {0.0099, 0.0, is_in ? 0.01 : 0.0201});
    }
    EXPECT_EQ(isDone(&in), is_in);
    EXPECT_EQ(isDone(&out), !is_in);
  }
}

TEST(JudgeTips, BothOutsideMeansBoth) {
  Bench bench = waitingFor(when(K::kTipOutside, kNobody, 0, Hand::kBoth));
  bench.tip(Arm::kGold, {0.0, 0.0, 0.01});
  EXPECT_FALSE(isDone(&bench, 3));
  bench.tip(Arm::kGold, {0.0, 0.02, 0.01});
  EXPECT_TRUE(isDone(&bench));
}

// ---- wires: up from (0, 50, 0) mm to z = 20 mm, then 10 mm along x

/** The ring's middle on the wire, its plane across it: `along` [m] of 30 mm. */
void thread(Bench* bench, double along) {
  if (along < 0.020) {
    bench->put(kRingSlot, {0.002, 0.05, along});
  } else {
    const double h = std::sqrt(0.5);  // normal along x
    bench->put(kRingSlot, {along - 0.020, 0.05, 0.018}, {0.0, h, 0.0, h});
  }
}

TEST(JudgeAlong, IsLedFromItsStartToTheShareThatIsAskedFor) {
  Bench bench = waitingFor(when(K::kAlong, kRingObject, 0, Hand::kAny, 0.8));
  for (double along = 0.0012; along < 0.0239; along += 0.0005) {
    thread(&bench, along);
    bench.tick();
    ASSERT_EQ(bench.done(), 0) << along;
    EXPECT_NEAR(bench.state().progress, along / 0.030, 1e-9);
  }
  thread(&bench, 0.0241);
  EXPECT_TRUE(isDone(&bench));
}

TEST(JudgeAlong, BackwardsLosesNothing) {
  Bench bench = waitingFor(when(K::kAlong, kRingObject, 0, Hand::kAny, 0.9));
  for (const double along : {0.002, 0.006, 0.010, 0.007, 0.003}) {
    thread(&bench, along);
    bench.tick();
  }
  EXPECT_NEAR(bench.state().progress, 0.010 / 0.030, 1e-9);
}

TEST(JudgeAlong, PutOnFartherOnDoesNotCount) {
  Bench bench = waitingFor(when(K::kAlong, kRingObject, 0, Hand::kAny, 0.9));
  thread(&bench, 0.002);
  bench.tick();
  bench.put(kRingSlot, {0.0, 0.0, 0.1});  // off the wire
  bench.run(10);
  thread(&bench, 0.029);  // and on again at its end
  EXPECT_FALSE(isDone(&bench, 100));
  EXPECT_NEAR(bench.state().progress, 0.002 / 0.030, 1e-9);
}

TEST(JudgeAlong, GoesOnWhereItWasLeft) {
  Bench bench = waitingFor(when(K::kAlong, kRingObject, 0, Hand::kAny, 0.3));
  thread(&bench, 0.006);
  bench.tick();
  bench.put(kRingSlot, {0.0, 0.0, 0.1});
  bench.run(10);
  thread(&bench, 0.0095);
  EXPECT_TRUE(isDone(&bench));
}

TEST(JudgeUnthreaded, TheWireIsOutOfTheOpening) {
  Bench bench = waitingFor(when(K::kUnthreaded, kRingObject, 0));
  thread(&bench, 0.029);
  EXPECT_FALSE(isDone(&bench, 10));
  const double h = std::sqrt(0.5);
  bench.put(kRingSlot, {0.0101, 0.05, 0.018}, {0.0, h, 0.0, h});  // past the end
  EXPECT_TRUE(isDone(&bench));
}

TEST(JudgeUnthreaded, BesideTheWireIsUnthreadedToo) {
  Bench bench = waitingFor(when(K::kUnthreaded, kRingObject, 0));
  bench.put(kRingSlot, {0.0081, 0.05, 0.01});
  EXPECT_TRUE(isDone(&bench));
}

// ---- camera

TEST(JudgeCamera, APointInThePictureIsWithinItsShareOfTheHalfHeight) {
  // half the field is 0.4 rad, tangent 0.4228: at 0.2 m that is 84.6 mm
  for (const double aside : {0.041, 0.044}) {
    Bench bench = waitingFor(when(K::kInView, kNobody, 0, Hand::kAny, 0.5));
    bench.model.camera.eye_W = {-0.2, 0.0, 0.04};
    bench.model.camera.target_W = {0.0, aside, 0.04};
    // the angle to the middle is atan(aside / 0.2); its tangent against half of 0.4228
    EXPECT_EQ(isDone(&bench), aside / 0.2 <= 0.5 * 0.42279) << aside;
  }
}

TEST(JudgeCamera, NothingIsInViewBehindOrWithoutACamera) {
  const Predicate in_view = when(K::kInView, kNobody, 0, Hand::kAny, 1.0);
  Bench behind = waitingFor(in_view), none = waitingFor(in_view);
  behind.model.camera.eye_W = {-0.2, 0.0, 0.04};
  behind.model.camera.target_W = {-0.4, 0.0, 0.04};
  EXPECT_FALSE(isDone(&behind));
  none.model.camera.eye_W = none.model.camera.target_W = {-0.2, 0.0, 0.04};
  EXPECT_FALSE(isDone(&none));
}

TEST(JudgeCamera, StandsNearAPoint) {
  Bench bench = waitingFor(when(K::kCameraNear, kNobody, 0, Hand::kAny, 0.03));
  bench.model.camera.eye_W = {0.031, 0.0, 0.04};
  EXPECT_FALSE(isDone(&bench));
  bench.model.camera.eye_W = {0.029, 0.0, 0.04};
  EXPECT_TRUE(isDone(&bench));
}

// ---- steps, tracks, timer

TEST(JudgeSteps, DwellMustBeUnbroken) {
  Bench bench = waitingFor(when(K::kUntouched), 0.1);
  bench.run(99);
  bench.touch(kJaw1L, kRing, 1.0);
  bench.tick();
  bench.clearContacts();
  EXPECT_FALSE(isDone(&bench, 99));
  EXPECT_TRUE(isDone(&bench));
}

TEST(JudgeSteps, AllOfAStepMustHoldTogether) {
  Bench bench(Bench::with({track({step({when(K::kUntouched), around(kPegA)})})}));
  bench.put(kRingSlot, {0.03, 0.0, 0.002});
  bench.touch(kJaw1L, kRing, 1.0);
  EXPECT_FALSE(isDone(&bench, 10));
  bench.clearContacts();
  bench.put(kRingSlot, {0.0, 0.0, 0.1});
  EXPECT_FALSE(isDone(&bench, 10));
  bench.put(kRingSlot, {0.03, 0.0, 0.002});
  EXPECT_TRUE(isDone(&bench));
}

TEST(JudgeSteps, ComeOneATickAndStayDone) {
  Bench bench(Bench::with({track({step({around(kPegA)}), step({around(kPegA)}), step({around(kPegB)})})}));
  bench.put(kRingSlot, {0.03, 0.0, 0.002});
  bench.tick();
  EXPECT_EQ(bench.done(), 1);
  EXPECT_EQ(bench.state().step, 2U);
  bench.tick();
  EXPECT_EQ(bench.done(), 2);
  bench.put(kRingSlot, {0.0, 0.0, 0.1});
  bench.run(10);
  EXPECT_EQ(bench.done(), 2);
  EXPECT_EQ(bench.state().step, 3U);
  EXPECT_EQ(bench.last(ExerciseEventKind::kStepDone)->step, 1);
  EXPECT_EQ(bench.last(ExerciseEventKind::kStepDone)->track, 0);
}

TEST(JudgeSteps, ATrackWaitsForTheOneBeforeIt) {
  Bench bench(
      Bench::with({track({step({around(kPegA)})}), track({step({around(kPegB, kBlockObject)})}, kBlockObject, 0)}));
  bench.put(kBlockSlot, {-0.03, 0.0, 0.002});
  bench.run(10);
  EXPECT_EQ(bench.done(1), 0);
  bench.put(kRingSlot, {0.03, 0.0, 0.002});
  bench.run(2);
  EXPECT_EQ(bench.done(0), 1);
  EXPECT_EQ(bench.done(1), 1);
  EXPECT_EQ(bench.state().status, ExerciseStatus::kDone);
}

TEST(JudgeSteps, TracksWithoutOrderGoSideBySide) {
  Bench bench(
      Bench::with({track({step({around(kPegA)})}), track({step({around(kPegB, kBlockObject)})}, kBlockObject)}));
  bench.put(kBlockSlot, {-0.03, 0.0, 0.002});
  bench.tick();
  EXPECT_EQ(bench.done(0), 0);
  EXPECT_EQ(bench.done(1), 1);
  EXPECT_EQ(bench.state().status, ExerciseStatus::kRunning);
}

TEST(JudgeTimer, BeginsWithTheFirstPedalDown) {
  Bench bench(Bench::with({endless()}));
  bench.model.pedal = 0;
  bench.model.mode = Mode::kPedalUp;
  bench.run(10);
  EXPECT_EQ(bench.state().status, ExerciseStatus::kWaiting);
  EXPECT_EQ(bench.state().began, -1);
  bench.model.pedal = 1;
  bench.model.mode = Mode::kTeleoperating;
  bench.tick();
  EXPECT_EQ(bench.state().status, ExerciseStatus::kRunning);
  EXPECT_EQ(bench.state().began, 11);
  EXPECT_EQ(bench.count(ExerciseEventKind::kStarted), 1);
  EXPECT_EQ(bench.count(ExerciseEventKind::kBegan), 1);
}

TEST(JudgeTimer, BeginsWhenTheRingLeavesItsPegAndStopsWithTheLastStep) {
  Exercise exercise = Bench::with({track({step({around(kPegB)}, 0.1)})});
  exercise.begin = {unless(around(kPegA))};
  Bench bench(exercise);
  bench.put(kRingSlot, {0.03, 0.0, 0.002});
  bench.run(100);
  EXPECT_EQ(bench.state().status, ExerciseStatus::kWaiting);
  bench.put(kRingSlot, {0.0, 0.0, 0.03});
  bench.run(50);
  EXPECT_EQ(bench.state().began, 101);
  bench.put(kRingSlot, {-0.03, 0.0, 0.002});
  bench.run(100);
  EXPECT_EQ(bench.state().status, ExerciseStatus::kDone);
  EXPECT_EQ(bench.state().ended, 250);
  EXPECT_EQ(bench.count(ExerciseEventKind::kDone), 1);
  bench.run(100);
  EXPECT_EQ(bench.state().ended, 250);
}

TEST(JudgeTimer, RunsOutAtTheLimit) {
  Exercise exercise = Bench::with({endless()});
  exercise.time_limit = 2.0;
  Bench bench(exercise);
  bench.run(2000);
  EXPECT_EQ(bench.state().status, ExerciseStatus::kRunning);
  bench.tick();
  EXPECT_EQ(bench.state().status, ExerciseStatus::kFailed);
  EXPECT_EQ(bench.state().failure, ExerciseFailure::kTimeLimit);
  EXPECT_EQ(bench.state().ended - bench.state().began, 2000);
  EXPECT_EQ(bench.count(ExerciseEventKind::kFailed), 1);
}

TEST(JudgeTimer, GoesOnWithThePedalUpAndStandsWhileTimeIsLost) {
  Exercise exercise = Bench::with({endless()});
  exercise.time_limit = 1.0;
  Bench bench(exercise);
  bench.run(500);
  bench.model.mode = Mode::kPaused;
  bench.run(5000);
  bench.model.mode = Mode::kPedalUp;
  bench.run(500);
  EXPECT_EQ(bench.state().status, ExerciseStatus::kRunning);
  bench.tick();
  EXPECT_EQ(bench.state().failure, ExerciseFailure::kTimeLimit);
}

TEST(JudgeTimer, AnAttemptCanBeGivenUp) {
  Bench bench(Bench::with({endless()}));
  bench.run(10);
  bench.judge->giveUp();
  bench.tick();
  EXPECT_EQ(bench.state().failure, ExerciseFailure::kGivenUp);
  EXPECT_EQ(bench.state().ended, 11);
}

TEST(JudgeTimer, EachStartIsANewAttempt) {
  Bench bench(Bench::with({track({step({around(kPegA)}), step({around(kPegB)})})}, {rule(Mistake::kBreakOff)}));
  bench.put(kRingSlot, {0.03, 0.0, 0.002});
  bench.broken.mask = 1;
  bench.run(10);
  EXPECT_EQ(bench.state().attempt, 1);
  EXPECT_EQ(bench.done(), 1);
  EXPECT_EQ(bench.mistakes(Mistake::kBreakOff), 1U);
  bench.put(kRingSlot, {0.0, 0.0, 0.1});
  bench.broken.mask = 0;
  bench.judge->start();
  bench.run(10);
  EXPECT_EQ(bench.state().attempt, 2);
  EXPECT_EQ(bench.done(), 0);
  EXPECT_EQ(bench.state().step, 1U);
  EXPECT_EQ(bench.mistakes(Mistake::kBreakOff), 0U);
  EXPECT_EQ(bench.state().began, 11);
}

TEST(JudgeTimer, WithoutTracksThereIsNoExercise) {
  Bench bench(Bench::with({}));
  bench.run(10);
  EXPECT_EQ(bench.state().status, ExerciseStatus::kNone);
  EXPECT_EQ(bench.judge->signals(), FaultSignals{});
  EXPECT_TRUE(bench.events.empty());
}

TEST(JudgeModes, NothingIsJudgedWhereTheModelGoesThroughEverything) {
  for (const Mode mode : {Mode::kChoosing, Mode::kTracking, Mode::kReturning, Mode::kReplaying, Mode::kPaused}) {
    Bench bench(Bench::with({track({step({around(kPegA)})})}));
    bench.run(5);
    bench.model.mode = mode;
    bench.put(kRingSlot, {0.03, 0.0, 0.002});
    bench.run(100);
    EXPECT_EQ(bench.done(), 0) << static_cast<int>(mode);
    bench.model.mode = Mode::kTeleoperating;
    bench.tick();
    EXPECT_EQ(bench.done(), 1) << static_cast<int>(mode);
  }
}

TEST(JudgeModes, ItIsJudgedWhereverTheModelIsItself) {
  for (const Mode mode : {Mode::kTeleoperating, Mode::kPedalUp, Mode::kExecuting, Mode::kSimulating,
                          Mode::kSimulationHeld, Mode::kTrial, Mode::kTrialHeld, Mode::kCameraMoving}) {
    Bench bench(Bench::with({track({step({around(kPegA)})})}));
    bench.model.mode = mode;
    bench.put(kRingSlot, {0.03, 0.0, 0.002});
    EXPECT_TRUE(isDone(&bench)) << static_cast<int>(mode);
  }
}

TEST(JudgeModes, ARehearsalTakesTime) {
  Exercise exercise = Bench::with({track({step({around(kPegA)})})});
  exercise.time_limit = 0.050;
  Bench bench(exercise);
  bench.run(5);
  bench.judge->setRehearsal(true);
  bench.run(40);
  EXPECT_EQ(bench.state().status, ExerciseStatus::kRunning);
  bench.run(10);
  EXPECT_EQ(bench.state().failure, ExerciseFailure::kTimeLimit);
}

TEST(JudgeModes, ARehearsalIsNoPartOfTheAttempt) {
  Bench bench(Bench::with({track({step({around(kPegA)})})}, {rule(Mistake::kBreakOff, 0, true)}));
  bench.run(5);
  bench.judge->setRehearsal(true);
  bench.put(kRingSlot, {0.03, 0.0, 0.002});
  bench.broken.mask = 1;
  bench.run(100);
  EXPECT_EQ(bench.done(), 0);
  EXPECT_EQ(bench.state().status, ExerciseStatus::kRunning);
  EXPECT_EQ(bench.mistakes(Mistake::kBreakOff), 0U);
  EXPECT_EQ(bench.state().bodies[kTowerASlot], kBodyBrokenOff) << "the broken part is still shown";
  // WHEN it is undone
  bench.put(kRingSlot, {0.0, 0.0, 0.1});
  bench.broken.mask = 0;
  bench.judge->setRehearsal(false);
  bench.run(10);
  EXPECT_EQ(bench.done(), 0);
  EXPECT_EQ(bench.mistakes(Mistake::kBreakOff), 0U);
  EXPECT_EQ(bench.state().bodies[kTowerASlot], 0);
  // and done again for good
  bench.put(kRingSlot, {0.03, 0.0, 0.002});
  EXPECT_TRUE(isDone(&bench));
}

// ---- signals for triggers

TEST(JudgeSignals, StepAndTissue) {
  Bench bench(Bench::with({track({step({around(kPegA)}), step({around(kPegB)})})}));
  bench.tip(Arm::kGold, {0.0, 0.05, 0.050});
  bench.tip(Arm::kGreen, {0.0, -0.05, 0.017});
  bench.tick();
  EXPECT_EQ(bench.judge->signals().step, 1U);
  EXPECT_NEAR(bench.judge->signals().tissue_distance, 0.017, 1e-12);  // the plate's top is z = 0; jaws level
  bench.put(kRingSlot, {0.03, 0.0, 0.002});
  bench.tick();
  EXPECT_EQ(bench.judge->signals().step, 2U);
}

TEST(JudgeSignals, TheTargetIsWhatTheRunningStepWaitsFor) {
  const Vec3 tip{0.003, 0.004, 0.052};
  const struct {
    Predicate until;
    double distance;
  } cases[] = {
      {when(K::kAt, kRingObject, 0), std::sqrt(0.003 * 0.003 + 0.004 * 0.004 + 0.012 * 0.012)},
      {when(K::kTipNear, kNobody, 0, Hand::kAny, 0.0001), 0.013},
      {when(K::kTipInside, kNobody, 0, Hand::kBoth), 0.032},
      {around(kPegA), std::sqrt(0.027 * 0.027 + 0.004 * 0.004 + 0.032 * 0.032)},      // top of the peg at z = 20 mm
      {held(Hand::kGold), std::sqrt(0.003 * 0.003 + 0.004 * 0.004 + 0.048 * 0.048)},  // ring at (0, 0, 100) mm
  };
  for (const auto& c : cases) {
    Bench bench(Bench::with({track({step({c.until, held(Hand::kBoth, kBlockObject)})})}));
    bench.tip(Arm::kGold, tip);
    bench.tip(Arm::kGreen, {0.0, -0.5, 0.3});
    bench.tick();
    EXPECT_NEAR(bench.judge->signals().target_distance, c.distance, 1e-12) << static_cast<int>(c.until.kind);
  }
}

TEST(JudgeSignals, OnAWireTheTargetIsThePlaceToReach) {
  Bench along(Bench::with({track({step({when(K::kAlong, kRingObject, 0, Hand::kAny, 0.5)})})}));  // 15 mm of 30, upward
  Bench off(Bench::with({track({step({when(K::kUnthreaded, kRingObject, 0), held(Hand::kGold)})})}));
  for (Bench* bench : {&along, &off}) {
    bench->tip(Arm::kGreen, {0.0, 0.05, 0.05});
    bench->tip(Arm::kGold, {0.5, 0.05, 0.05});
    bench->tick();
  }
  EXPECT_NEAR(along.judge->signals().target_distance, 0.035, 1e-12);
  EXPECT_NEAR(off.judge->signals().target_distance, std::sqrt(0.01 * 0.01 + 0.03 * 0.03), 1e-12);
}

TEST(JudgeSignals, WithoutAnAttemptThereAreNone) {
  Bench bench(Bench::with({track({step({around(kPegA)})})}));
  bench.put(kRingSlot, {0.03, 0.0, 0.002});
  bench.tick();
  ASSERT_EQ(bench.state().status, ExerciseStatus::kDone);
  EXPECT_TRUE(std::isinf(bench.judge->signals().target_distance));
  EXPECT_TRUE(std::isfinite(bench.judge->signals().tissue_distance));
}

TEST(JudgeSignals, WhatIsShownOfARecordedSessionIsNearToNothing) {
  Bench bench(Bench::with({track({step({around(kPegA)})})}));
  bench.tip(Arm::kGold, {0.0, 0.05, 0.001});
  bench.tick();
  ASSERT_TRUE(std::isfinite(bench.judge->signals().tissue_distance));
  bench.model.mode = Mode::kReplaying;
  bench.tick();
  EXPECT_TRUE(std::isinf(bench.judge->signals().tissue_distance));
  EXPECT_TRUE(std::isinf(bench.judge->signals().target_distance));
  EXPECT_EQ(bench.judge->signals().step, 1U);
  bench.model.mode = Mode::kPedalUp;
  bench.tick();
  EXPECT_TRUE(std::isfinite(bench.judge->signals().tissue_distance));
}

TEST(JudgeSignals, AnObjectThatIsNotDueYetIsNoTarget) {
  Bench bench(Bench::with({track({step({when(K::kTipNear, kNobody, 0, Hand::kAny, 1e-4)})}),
                           track({step({when(K::kTipNear, kNobody, 1, Hand::kAny, 1e-4)})}, kBlockObject, 0)}));
  bench.tip(Arm::kGold, {0.05, 0.02, 0.010});  // where the second track will want it
  bench.tip(Arm::kGreen, {0.0, -0.5, 0.3});
  bench.tick();
  EXPECT_NEAR(bench.judge->signals().target_distance, std::sqrt(0.0025 + 0.0004 + 0.0009), 1e-12);
}

TEST(JudgeAlong, EachStepIsLedFromItsOwnBeginning) {
  const Predicate along = when(K::kAlong, kRingObject, 0, Hand::kAny, 0.8);
  Bench bench(Bench::with({track({step({along}), step({along})})}));
  for (double at = 0.002; bench.done() == 0 && at < 0.03; at += 0.0005) {
    thread(&bench, at);
    bench.tick();
  }
  for (double at = 0.002; at < 0.0239; at += 0.0005) {
    thread(&bench, at);
    bench.tick();
    ASSERT_EQ(bench.done(), 1) << at;
  }
  thread(&bench, 0.0241);
  EXPECT_TRUE(isDone(&bench));
}

TEST(JudgeSteps, DwellBeginsAnewBehindAPauseAndInANewAttempt) {
  Bench bench = waitingFor(around(kPegA), 0.1);
  bench.put(kRingSlot, {0.03, 0.0, 0.002});
  bench.run(99);
  bench.model.mode = Mode::kPaused;
  bench.run(10);
  bench.model.mode = Mode::kTeleoperating;
  EXPECT_FALSE(isDone(&bench, 99));
  bench.judge->start();
  EXPECT_FALSE(isDone(&bench, 99));
  EXPECT_TRUE(isDone(&bench));
}

}  // namespace
}  // namespace raven2_trainer::training::testing
