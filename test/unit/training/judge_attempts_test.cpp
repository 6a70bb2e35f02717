#include <gtest/gtest.h>

#include <cmath>

#include "judge_support.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"
#include "raven2_trainer/training/tissue_distance.h"

// The judge by arm, by object, by side and by attempt. No rule may hold only for gold, for the first object, upwards,
// or in the first attempt.

namespace raven2_trainer::training::testing {
namespace {

using K = PredicateKind;
using E = ExerciseEventKind;

Hand handOf(Arm arm) {
  return arm == Arm::kGold ? Hand::kGold : Hand::kGreen;
}

std::uint16_t jawOf(Arm arm) {
  return arm == Arm::kGold ? kJaw1L : kJaw1R;
}

std::string armName(const ::testing::TestParamInfo<Arm>& p) {
  return name(p.param);
}

/** Ends the attempt if it runs, and begins the next one. */
void restart(Bench* bench, bool gives_up) {
  if (gives_up) {
    bench->judge->giveUp();
    bench->tick();
  }
  bench->judge->start();
  bench->events.clear();
}

// ---- state after earlier attempts

/** Whether the attempt before was given up, or is running when the next one starts. */
class EveryAttempt : public ::testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(Judge, EveryAttempt, ::testing::Bool(), [](const auto& p) {
  return p.param ? "GivenUp" : "Restarted";
});

TEST_P(EveryAttempt, HasItsOwnCountOfMistakes) {
  WatchRule strict = touchRule(Mistake::kWireTouch, {"grasper1_L", "grasper1_R"}, {"wire"}, 0.1, 0.05);
  strict.limit = 1;
  Bench bench(Bench::with({endless()}, {strict}));
  for (int attempt = 1; attempt <= 3; ++attempt) {
    bench.run(5);
    bench.touch(kJaw1L, kWire, 0.2);
    bench.run(5);
    EXPECT_EQ(bench.mistakes(Mistake::kWireTouch), 1U) << attempt;
    EXPECT_EQ(bench.state().status, ExerciseStatus::kRunning) << "one is allowed in attempt " << attempt;
    bench.clearContacts();
    bench.run(60);
    restart(&bench, GetParam());
  }
}

TEST_P(EveryAttempt, HasItsOwnTime) {
  Exercise exercise = Bench::with({endless()});
  exercise.time_limit = 0.5;
  Bench bench(exercise);
  for (int attempt = 1; attempt <= 3; ++attempt) {
    bench.run(400);
    EXPECT_EQ(bench.state().status, ExerciseStatus::kRunning) << attempt;
    restart(&bench, GetParam());
  }
  bench.run(501);
  EXPECT_EQ(bench.state().failure, ExerciseFailure::kTimeLimit);
}

TEST_P(EveryAttempt, SeesWhatBreaksOffInIt) {
  Bench bench(Bench::with({endless()}, {rule(Mistake::kBreakOff)}));
  for (int attempt = 1; attempt <= 3; ++attempt) {
    bench.broken.mask = 0;  // the scene is put together for each
    bench.run(5);
    bench.broken.mask = 2;
    bench.run(5);
    EXPECT_EQ(bench.mistakes(Mistake::kBreakOff), 1U) << attempt;
    EXPECT_EQ(bench.count(E::kBrokeOff), 1) << attempt;
    bench.broken.mask = 0;
    restart(&bench, GetParam());
  }
}

TEST_P(EveryAttempt, IsToldOfAHoldThatGoesOn) {
  Bench bench(Bench::with({endless()}));
  bench.grip(Arm::kGreen);
  for (int attempt = 1; attempt <= 2; ++attempt) {
    bench.run(19);
    EXPECT_EQ(bench.state().bodies[kRingSlot], 0) << attempt;
    bench.run(1);
    EXPECT_EQ(bench.state().bodies[kRingSlot], kHeldByGreen) << attempt;
    EXPECT_EQ(bench.count(E::kHeld), 1) << attempt;
    restart(&bench, GetParam());
  }
}

TEST_P(EveryAttempt, DoesNotPayForWhatWasLetGoBefore) {
  WatchRule drop = rule(Mistake::kDrop);
  drop.grace = 0.3;
  Bench bench(Bench::with({endless()}, {drop}));
  bench.grip(Arm::kGold);
  bench.run(200);
  bench.clearContacts();
  bench.run(100);  // let go for 50 ms: the verdict comes 250 ms later
  restart(&bench, GetParam());
  bench.run(1000);
  EXPECT_EQ(bench.mistakes(Mistake::kDrop), 0U);
  EXPECT_EQ(bench.count(E::kDropped), 0);
}

TEST_P(EveryAttempt, LeadsAlongTheWireFromItsBeginning) {
  Bench bench(Bench::with({track({step({when(K::kAlong, kRingObject, 0, Hand::kAny, 0.9)})})}));
  for (int attempt = 1; attempt <= 2; ++attempt) {
    for (const double along : {0.002, 0.006, 0.010}) {
      bench.put(kRingSlot, {0.002, 0.05, along});
      bench.tick();
      EXPECT_NEAR(bench.state().progress, along / 0.030, 1e-9) << attempt;
    }
    restart(&bench, GetParam());
  }
}

TEST_P(EveryAttempt, EndsItsTouches) {
  Bench bench(Bench::with({endless()}, {touchRule(Mistake::kCollision, {"grasper1_R"}, {"tower_a"}, 0.1, 0.05)}));
  bench.touch(kJaw1R, kTowerA, 0.2);
  for (int attempt = 1; attempt <= 2; ++attempt) {
    bench.run(10);
    EXPECT_EQ(bench.mistakes(Mistake::kCollision), 1U) << attempt;
    EXPECT_EQ(bench.count(E::kTouchBegan), 1) << attempt;
    restart(&bench, GetParam());
  }
}

TEST(JudgeStart, TakesBackAGivingUpThatCameBeforeIt) {
  Bench bench(Bench::with({endless()}));
  bench.run(5);
  bench.judge->giveUp();
  bench.judge->start();
  bench.run(5);
  EXPECT_EQ(bench.state().attempt, 2);
  EXPECT_EQ(bench.state().status, ExerciseStatus::kRunning);
  bench.judge->start();
  bench.judge->giveUp();
  bench.run(5);
  EXPECT_EQ(bench.state().attempt, 3);
  EXPECT_EQ(bench.state().failure, ExerciseFailure::kGivenUp);
  bench.judge->start();
  bench.run(5);
  EXPECT_EQ(bench.state().status, ExerciseStatus::kRunning) << "only the attempt before was given up";
}

// ---- either arm

class EitherArm : public ::testing::TestWithParam<Arm> {
 protected:
  Arm arm() const { return GetParam(); }
  Arm other() const { return otherArm(GetParam()); }
};
INSTANTIATE_TEST_SUITE_P(Judge, EitherArm, ::testing::ValuesIn(kArms), armName);

TEST_P(EitherArm, HoldsAloneUnlessTheOtherOneTouches) {
  for (const Hand hand : {handOf(arm()), Hand::kAny}) {
    Bench bench(Bench::with({track({step({when(K::kHeldAlone, kRingObject, kNobody, hand)})})}));
    bench.grip(arm());
    bench.touch(jawOf(other()), kRing, 0.01);
    bench.run(100);
    EXPECT_EQ(bench.done(), 0);
    bench.contacts.count -= 1;
    bench.run(1);
    EXPECT_EQ(bench.done(), 1);
  }
}

TEST_P(EitherArm, IsTheWrongOneWhereTheStepAsksForTheOther) {
  for (const bool is_wrong : {true, false}) {
    Bench bench(
        Bench::with({track({step({held(handOf(is_wrong ? other() : arm()))}, 10.0)})}, {rule(Mistake::kWrongArm)}));
    bench.run(1);
    bench.grip(arm());
    bench.run(50);
    EXPECT_EQ(bench.mistakes(Mistake::kWrongArm), is_wrong ? 1U : 0U);
  }
}

/** A hold ends where nothing is judged, because the scene may be different afterwards. */
TEST_P(EitherArm, LetsGoWhereNothingIsJudged) {
  Bench bench(Bench::with({endless()}));
  bench.grip(arm());
  bench.run(30);
  ASSERT_NE(bench.state().bodies[kRingSlot], 0);
  bench.model.mode = Mode::kChoosing;
  bench.run(1);
  EXPECT_EQ(bench.state().bodies[kRingSlot], 0);
  ASSERT_EQ(bench.count(E::kReleased), 1);
  EXPECT_EQ(bench.last(E::kReleased)->arm, handOf(arm()));
}

TEST_P(EitherArm, TouchesWithItsOwnForceAndTimeEachTime) {
  Bench bench(
      Bench::with({endless()}, {touchRule(Mistake::kWireTouch, {"grasper1_L", "grasper1_R"}, {"wire"}, 0.1, 0.05)}));
  bench.run(1);
  const struct {
    double force;
    int ticks;
  } touches[] = {{0.9, 40}, {0.2, 10}, {0.4, 25}};  // the first is the greatest; later forces do not add to it
  for (const auto& touch : touches) {
    bench.touch(jawOf(arm()), kWire, touch.force);
    bench.run(touch.ticks);
    bench.clearContacts();
    bench.run(60);
    ASSERT_NE(bench.last(E::kTouchEnded), nullptr);
    EXPECT_NEAR(bench.last(E::kTouchEnded)->force, touch.force, 1e-12);
    EXPECT_NEAR(bench.last(E::kTouchEnded)->value, 0.001 * touch.ticks, 1e-12);
  }
  EXPECT_EQ(bench.mistakes(Mistake::kWireTouch), 3U);
}

TEST_P(EitherArm, PressesWithTheSumOfItsContactsInEachTickAlone) {
  Bench bench(
      Bench::with({endless()}, {touchRule(Mistake::kWireTouch, {"grasper1_L", "grasper1_R"}, {"wire"}, 0.1, 0.05)}));
  bench.touch(jawOf(arm()), kWire, 0.06);  // below the rule's force, however often
  bench.run(20);
  EXPECT_EQ(bench.mistakes(Mistake::kWireTouch), 0U);
  bench.touch(jawOf(other()), kWire, 0.06);  // and the other arm's force does not add to it
  bench.run(20);
  EXPECT_EQ(bench.mistakes(Mistake::kWireTouch), 0U);
  bench.touch(jawOf(arm()), kWire, 0.06);
  bench.run(20);
  EXPECT_EQ(bench.mistakes(Mistake::kWireTouch), 1U);
}

/** The plate's top is z = 0 and ends at x, y = 0.1 m; the tools' axes are those of W. */
TEST_P(EitherArm, IsAsNearToTissueAsItsOpenJaws) {
  Bench bench(Bench::with({endless()}));
  bench.tip(other(), {0.0, 0.0, 0.5});
  bench.tip(arm(), {0.02, 0.03, 0.050});
  bench.tick();
  EXPECT_NEAR(bench.judge->signals().tissue_distance, 0.050, 1e-12);
  bench.tip(arm(), {-0.2, 0.0, -0.01});  // the jaws point at the plate's left side
  bench.tick();
  EXPECT_NEAR(bench.judge->signals().tissue_distance, 0.1 - kJawLength, 1e-12);
  at(bench.model.arms, arm()).q[5] = at(bench.model.arms, arm()).q[6] = 0.5;  // open by 1 rad
  bench.tick();
  EXPECT_NEAR(bench.judge->signals().tissue_distance, 0.1 - kJawLength * std::cos(0.5), 1e-12);
}

TEST_P(EitherArm, IsTheNearerOneToTheTarget) {
  const Predicate targets[] = {when(K::kTipNear, kNobody, 0, Hand::kAny, 1e-4), when(K::kAt, kRingObject, 0),
                               held(Hand::kBoth)};
  for (const Predicate& target : targets) {
    Bench bench(Bench::with({track({step({target})})}));
    if (target.kind == K::kHeld) bench.put(kRingSlot, {0.0, 0.0, 0.040});  // else it is where the point is
    bench.tip(arm(), {0.002, -0.003, 0.046});
    bench.tip(other(), {0.3, 0.0, 0.1});
    bench.tick();
    EXPECT_NEAR(bench.judge->signals().target_distance, 0.007, 1e-12) << static_cast<int>(target.kind);
  }
}

/** Whether an arm's tool reaches a place in any attitude of a separate grid, by inverse kinematics and limits. */
bool reaches(Arm arm, const Vector3& p_W) {
  const ArmsConfig arms = testArms();
  const Pose X_WB{model::armBaseRotation(arm), toEigen(at(arms.rcm_W, arm))};
  for (double lean = 0.0; lean < 1.5; lean += 0.2) {
    for (double turn = 0.0; turn < 6.2; turn += 0.4) {
      for (double roll = 0.0; roll < 6.2; roll += 0.4) {
        Pose X_WT;
        X_WT.R = (Eigen::AngleAxisd(turn, Vector3::UnitZ()) * Eigen::AngleAxisd(kPi / 2 - lean, Vector3::UnitY()) *
                  Eigen::AngleAxisd(roll, Vector3::UnitX()))
                     .toRotationMatrix();
        X_WT.p = p_W - 0.0075 * X_WT.R.col(0);
        kinematics::IkSolutions solutions;
        kinematics::inverseAll(arms.geometry, arm, X_WB.inverse() * X_WT, 0.2, &solutions);
        for (const kinematics::IkSolution& solution : solutions) {
          bool fits = solution.valid;
          for (std::size_t j = 0; j < kJointCount; ++j)
            fits = fits && solution.q[j] >= arms.geometry.q_min[j] && solution.q[j] <= arms.geometry.q_max[j];
          if (fits) return true;
        }
      }
    }
  }
  return false;
}

/** An object on the side of one arm, where the other one does not reach, can be taken. */
TEST_P(EitherArm, AloneReachesWhatLiesOnItsSide) {
  const double side = arm() == Arm::kGold ? 1.0 : -1.0;
  Vector3 place(0.0, 0.0, 0.0);
  for (double y = 0.02; y < 0.2; y += 0.01) {
    place = {-0.02, side * y, 0.016};
    if (reaches(arm(), place) && !reaches(other(), place)) break;
  }
  ASSERT_TRUE(reaches(arm(), place) && !reaches(other(), place)) << "or this test proves nothing";
  for (const std::size_t slot : {kRingSlot, kBlockSlot}) {
    Bench bench(Bench::with({track({step({held(Hand::kBoth), held(Hand::kBoth, kBlockObject)})})}));
    bench.run(10);
    bench.put(slot, toArray(place));
    bench.run(2500);
    EXPECT_EQ(bench.state().status, ExerciseStatus::kRunning) << slot;
  }
}

// ---- either object

struct Thing {
  std::uint8_t object;
  std::size_t slot;
  std::uint16_t body;
};

class EitherObject : public ::testing::TestWithParam<Thing> {};
INSTANTIATE_TEST_SUITE_P(Judge,
                         EitherObject,
                         ::testing::Values(Thing{kRingObject, kRingSlot, kRing},
                                           Thing{kBlockObject, kBlockSlot, kBlock}),
                         [](const auto& p) { return p.param.body == kRing ? "Ring" : "Block"; });

TEST_P(EitherObject, IsLostOutOfReachOrOffTheTable) {
  for (const Vec3& place : {Vec3{0.5, 0.5, 0.002}, Vec3{0.0, 0.0, -0.51}}) {
    Bench bench(Bench::with({endless()}));
    bench.run(10);
    bench.put(GetParam().slot, place);
    bench.run(2500);
    EXPECT_EQ(bench.state().failure, ExerciseFailure::kObjectLost);
  }
}

TEST_P(EitherObject, IsDroppedByEitherArm) {
  for (const Arm arm : kArms) {
    WatchRule drop = rule(Mistake::kDrop);
    drop.grace = 0.3;
    Bench bench(Bench::with({track({step({held(Hand::kBoth), held(Hand::kBoth, kBlockObject)})})}, {drop}));
    bench.grip(arm, GetParam().body);
    bench.run(200);
    EXPECT_EQ(bench.state().bodies[GetParam().slot], arm == Arm::kGold ? kHeldByGold : kHeldByGreen);
    bench.clearContacts();
    bench.run(400);
    EXPECT_EQ(bench.mistakes(Mistake::kDrop), 1U);
    ASSERT_NE(bench.last(E::kDropped), nullptr);
    EXPECT_EQ(bench.last(E::kDropped)->a, GetParam().body);
  }
}

// ---- either side

/** The box is x, y from -10 to 10 mm, z from 0 to 20 mm. */
TEST(JudgeRegion, IsLeftByEachOfItsSixFaces) {
  const Vec3 middle{0.0, 0.0, 0.01};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const double sign : {-1.0, 1.0}) {
      for (const double from_face : {-0.0001, 0.0001}) {
        Bench in(Bench::with({track({step({when(K::kTipInside, kNobody, 0, Hand::kGold)})})}));
        Bench out(Bench::with({track({step({when(K::kTipOutside, kNobody, 0, Hand::kGold)})})}));
        Vec3 tip = middle;
        tip[axis] += sign * (0.010 + from_face);
        for (Bench* bench : {&in, &out}) {
          bench->tip(Arm::kGold, tip);
          bench->tick();
        }
        EXPECT_EQ(in.done(), from_face < 0.0 ? 1 : 0) << axis << " " << sign;
        EXPECT_EQ(out.done(), from_face < 0.0 ? 0 : 1) << axis << " " << sign;
      }
    }
  }
}

TEST(JudgeRegion, IsAsFarAsItsNearestFaceOrCorner) {
  for (const double sign : {-1.0, 1.0}) {
    Bench bench(Bench::with({track({step({when(K::kTipInside, kNobody, 0, Hand::kBoth)})})}));
    bench.tip(Arm::kGreen, {0.0, 0.0, 0.5});
    bench.tip(Arm::kGold, {sign * 0.012, sign * 0.013, 0.01 + sign * 0.016});  // 2, 3 and 6 mm from a corner
    bench.tick();
    EXPECT_NEAR(bench.judge->signals().target_distance, 0.007, 1e-12) << sign;
    bench.tip(Arm::kGold, {sign * 0.005, sign * 0.018, 0.004});
    bench.tick();
    EXPECT_NEAR(bench.judge->signals().target_distance, 0.008, 1e-12) << sign;
  }
}

/** From its foot at z = 0 to its top at 20 mm. */
TEST(JudgePeg, IsAsFarAsItsNearestPoint) {
  const struct {
    double z, above_or_below;
  } cases[] = {{-0.004, 0.004}, {0.0, 0.0}, {0.013, 0.0}, {0.020, 0.0}, {0.024, 0.004}};
  for (const auto& c : cases) {
    Bench bench(Bench::with({track({step({around(kPegB)})})}));
    bench.tip(Arm::kGreen, {-0.03 - 0.003, 0.0, c.z});
    bench.tip(Arm::kGold, {0.3, 0.0, 0.3});
    bench.tick();
    EXPECT_NEAR(bench.judge->signals().target_distance, std::hypot(0.003, c.above_or_below), 1e-12) << c.z;
  }
}

/** A ring has no upper side. */
TEST(JudgeAround, EitherWayUpAndByEitherSignOfItsQuaternion) {
  for (const double angle : {0.3, kPi - 0.3, kPi, kPi + 0.3, -0.3}) {
    for (const double sign : {-1.0, 1.0}) {
      Bench bench(Bench::with({track({step({around(kPegA)})})}));
      bench.put(kRingSlot, {0.03, 0.0, 0.01}, {sign * std::sin(0.5 * angle), 0.0, 0.0, sign * std::cos(0.5 * angle)});
      bench.tick();
      EXPECT_EQ(bench.done(), 1) << angle << " " << sign;
    }
  }
}

/** 7.9 mm aside is in the opening of 8 mm, 8.1 mm is not, wherever it is. */
TEST(JudgeAround, OnEverySideOfThePeg) {
  for (const Thing& thing : {Thing{kRingObject, kRingSlot, kRing}, Thing{kBlockObject, kBlockSlot, kBlock}}) {
    const double half = thing.object == kRingObject ? 0.008 : 0.006;
    for (const auto& [x, y] : {std::pair{1.0, 0.0}, {-1.0, 0.0}, {0.0, 1.0}, {0.0, -1.0}}) {
      for (const double beyond : {-0.0001, 0.0001}) {
        Bench bench(Bench::with({track({step({around(kPegA, thing.object)})}, thing.object)}));
        bench.put(thing.slot, {0.03 + x * (half + beyond), y * (half + beyond), 0.01});
        bench.tick();
        EXPECT_EQ(bench.done(), beyond < 0.0 ? 1 : 0) << x << " " << y;
      }
    }
  }
}

}  // namespace
}  // namespace raven2_trainer::training::testing
