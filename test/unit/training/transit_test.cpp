#include "raven2_trainer/training/transit.h"

#include "gtest/gtest.h"
#include "motion_support.h"

namespace raven2_trainer::training {
namespace {

ExerciseEvent makeEvent(ExerciseEventKind kind, Hand hand) {
  ExerciseEvent event;
  event.kind = kind;
  event.arm = hand;
  return event;
}

/** The arm takes something at once, carries it along the path for `ticks`, and lets go. */
std::vector<Transit> carry(const Path& path, Tick ticks, const PerArm<Pose>& X_WB = {}) {
  TransitCollector collector(X_WB);
  collector.add(makeEvent(ExerciseEventKind::kHeld, Hand::kGreen));
  for (Tick k = 0; k < ticks; ++k) {
    ModelState model = makeRecord(k, {9.0, 9.0, 9.0}, path(kTickSeconds * static_cast<double>(k))).model;
    at(model.arms, Arm::kGreen).q[0] = static_cast<double>(k);
    at(model.arms, Arm::kGold).q[0] = -static_cast<double>(k);
    collector.add(model);
  }
  EXPECT_TRUE(collector.transits().empty());
  collector.add(makeEvent(ExerciseEventKind::kReleased, Hand::kGreen));
  return collector.transits();
}

Vec3 straightWay(double t) {
  return {0.1 * t, 0.02, -0.03};  // 100 mm/s
}

TEST(Transit, IsTheWayBetweenTheEndsOfACarry) {
  const std::vector<Transit> transits = carry(straightWay, 1000);
  ASSERT_EQ(transits.size(), 1u);
  EXPECT_EQ(transits[0].arm, Arm::kGreen);
  EXPECT_NEAR(transits[0].way_W.front()[0], kTransitEnd, 0.002);
  EXPECT_NEAR(transits[0].way_W.back()[0], 0.1 - kTransitEnd, 0.002);
  EXPECT_NEAR(lengthOf(transits[0].way_W), 0.1 - 2 * kTransitEnd, 0.003);
  EXPECT_NEAR(transits[0].start[0], 155.0, 15.0);  // the joints of where it begins
  EXPECT_EQ(transits[0].other[0], -transits[0].start[0]);
}

TEST(Transit, OfAShortCarryIsNone) {
  EXPECT_TRUE(carry(straightWay, 400).empty());
  EXPECT_TRUE(carry([](double) { return Vec3{}; }, 400).empty());
  EXPECT_TRUE(carry(straightWay, 0).empty());
}

/** 20 mm of 100 mm are cut out, or are the model's alone, with the pedal up. */
TEST(Transit, SkipsWhatIsNoMotionOfTheHand) {
  for (const bool is_cut : {true, false}) {
    TransitCollector collector({});
    collector.add(makeEvent(ExerciseEventKind::kHeld, Hand::kGold));
    for (Tick k = 0; k < 1000; ++k) {
      ModelState model = makeRecord(k, straightWay(kTickSeconds * static_cast<double>(k))).model;
      const bool is_part = k >= 400 && k < 600;
      model.pedal = is_part ? 0 : 1;
      if (!(is_part && is_cut)) collector.add(model);
    }
    collector.add(makeEvent(ExerciseEventKind::kReleased, Hand::kGold));
    ASSERT_EQ(collector.transits().size(), 1u);
    EXPECT_NEAR(collector.transits()[0].skipped, 0.020, 0.002) << is_cut;
    const auto plan = [](const Transit&) { return std::vector<Vec3>{{0.0, 0.0, 0.0}, {0.025, 0.0, 0.0}}; };
    EXPECT_NEAR(compare(collector.transits(), plan).ratio.value(), 0.025 / 0.047, 0.03) << is_cut;
  }
}

TEST(Transit, StandsInTheWorld) {
  PerArm<Pose> X_WB;
  at(X_WB, Arm::kGreen).p = {0.0, 1.0, 0.0};
  EXPECT_NEAR(carry(straightWay, 1000, X_WB).at(0).way_W[0][1], 1.02, 1e-9);
}

TEST(Transit, NeedsAHandThatHolds) {
  TransitCollector collector({});
  collector.add(makeEvent(ExerciseEventKind::kReleased, Hand::kGold));
  collector.add(makeEvent(ExerciseEventKind::kHeld, Hand::kAny));
  for (Tick k = 0; k < 1000; ++k)
    collector.add(makeRecord(k, straightWay(kTickSeconds * static_cast<double>(k))).model);
  collector.add(makeEvent(ExerciseEventKind::kReleased, Hand::kGold));
  EXPECT_TRUE(collector.transits().empty());
}

Predicate makePredicate(PredicateKind kind, Hand hand) {
  Predicate predicate;
  predicate.kind = kind;
  predicate.hand = hand;
  return predicate;
}

/** Gold to a place, the camera anywhere, then green to hold something; after that a track of gold's. */
std::vector<ExerciseTrack> makeTracks() {
  ExerciseTrack first, second;
  first.steps = {{"there", {makePredicate(PredicateKind::kTipNear, Hand::kGold)}, 0.0},
                 {"look", {makePredicate(PredicateKind::kInView, Hand::kAny)}, 0.0},
                 {"take", {makePredicate(PredicateKind::kHeld, Hand::kGreen)}, 0.0}};
  second.after = 0;
  second.steps = {{"back", {makePredicate(PredicateKind::kTipOutside, Hand::kGold)}, 0.0}};
  return {first, second};
}

ExerciseEvent makeStepDone(std::uint8_t track, std::uint8_t step) {
  ExerciseEvent event;
  event.kind = ExerciseEventKind::kStepDone;
  event.track = track;
  event.step = step;
  return event;
}

/** Four steps of a second each, both tips at 100 mm/s. */
std::vector<Transit> reach(const std::vector<ExerciseTrack>& tracks) {
  TransitCollector collector({}, tracks);
  for (Tick k = 0; k < 4000; ++k) {
    if (k == 1000 || k == 2000 || k == 3000) collector.add(makeStepDone(0, static_cast<std::uint8_t>(k / 1000 - 1)));
    const double t = kTickSeconds * static_cast<double>(k);
    collector.add(makeRecord(k, straightWay(t), {0.0, 0.1 * t, 0.0}).model);
  }
  collector.add(makeStepDone(1, 0));
  return collector.transits();
}

TEST(Transit, IsTheWayToWhereAStepWaitsForATip) {
  const std::vector<Transit> transits = reach(makeTracks());
  ASSERT_EQ(transits.size(), 3u);
  EXPECT_EQ(transits[0].arm, Arm::kGold);
  EXPECT_NEAR(transits[0].way_W.front()[0], 0.0 + kTransitEnd, 0.002);
  EXPECT_NEAR(transits[0].way_W.back()[0], 0.1 - kTransitEnd, 0.002);
  EXPECT_EQ(transits[1].arm, Arm::kGreen);
  EXPECT_NEAR(transits[1].way_W.front()[1], 0.2 + kTransitEnd, 0.002);
  EXPECT_NEAR(transits[1].way_W.back()[1], 0.3 - kTransitEnd, 0.002);
  EXPECT_EQ(transits[2].arm, Arm::kGold);
  EXPECT_NEAR(transits[2].way_W.front()[0], 0.3 + kTransitEnd, 0.002)
      << "the second track's turn comes with the first's end";
}

TEST(Transit, OfStepsAboutAnObjectIsOnlyWhatIsCarried) {
  std::vector<ExerciseTrack> tracks = makeTracks();
  tracks[0].object = tracks[1].object = 0;
  EXPECT_TRUE(reach(tracks).empty());
  tracks = makeTracks();
  tracks[0].steps[0].until[0].negated = 1;
  tracks[0].steps[2].until[0].hand = Hand::kAny;
  EXPECT_EQ(reach(tracks).size(), 1u) << "steps without an arm, or with a place to leave, are no transit";
}

TEST(DistanceTo, APolylineIsThatToItsNearestSegment) {
  const std::vector<Vec3> corner{{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, {1.0, 1.0, 0.0}};
  EXPECT_NEAR(distanceTo(corner, {0.5, -0.2, 0.0}), 0.2, 1e-12);
  EXPECT_NEAR(distanceTo(corner, {1.0, 0.5, 0.3}), 0.3, 1e-12);
  EXPECT_NEAR(distanceTo(corner, {-3.0, 0.0, 4.0}), 5.0, 1e-12);
  EXPECT_NEAR(distanceTo({{1.0, 1.0, 1.0}}, {1.0, 1.0, 3.0}), 2.0, 1e-12);
  EXPECT_NEAR(lengthOf(corner), 2.0, 1e-12);
  EXPECT_EQ(lengthOf({}), 0.0);
}

Transit makeTransit(const std::vector<Vec3>& way) {
  Transit transit;
  transit.way_W = way;
  return transit;
}

/** 60 mm by way of a corner that is 40 mm off. */
Transit makeDetour() {
  std::vector<Vec3> way;
  for (int i = 0; i <= 50; ++i)
    way.push_back({0.0006 * i, 0.0008 * i, 0.0});
  for (int i = 1; i <= 50; ++i)
    way.push_back({0.03 + 0.0006 * i, 0.04 - 0.0008 * i, 0.0});
  return makeTransit(way);
}

std::vector<Vec3> ends(const Transit& transit) {
  return {transit.way_W.front(), transit.way_W.back()};
}

TEST(Economy, OfAWayAgainstItselfIsOne) {
  const Economy economy = compare({makeDetour()}, [](const Transit& t) { return t.way_W; });
  EXPECT_NEAR(economy.ratio.value(), 1.0, 1e-12);
  EXPECT_NEAR(economy.off_path.value(), 0.0, 1e-12);
}

TEST(Economy, OfADetourIsTheShareOfTheStraightLine) {
  const Economy economy = compare({makeDetour()}, ends);
  EXPECT_NEAR(economy.ratio.value(), 0.06 / 0.10, 1e-9);
  EXPECT_NEAR(economy.off_path.value(), 0.02, 0.001);        // half the height of the triangle
  EXPECT_NEAR(economy.off_path_p95.value(), 0.038, 0.0005);  // all but a twentieth of the path is below 38 mm
}

TEST(Economy, AddsLengthsUpAndLeavesOutWhatHasNoPlan) {
  const Transit line = makeTransit({{0.0, 0.0, 0.0}, {0.0, 0.0, 0.06}});
  const Transit unplanned = makeTransit({{5.0, 0.0, 0.0}, {6.0, 0.0, 0.0}});
  const auto plan = [](const Transit& t) { return t.way_W[0][0] > 1.0 ? std::vector<Vec3>{} : ends(t); };
  const Economy economy = compare({line, makeDetour(), unplanned}, plan);
  EXPECT_NEAR(economy.ratio.value(), (0.06 + 0.06) / (0.06 + 0.10), 1e-9);
  EXPECT_EQ(economy.transits, 3u);
  EXPECT_EQ(economy.planned, 2u);
}

TEST(Economy, IsNoMoreThanOneAndNothingWithoutPlans) {
  const auto longer = [](const Transit& t) { return std::vector<Vec3>{t.way_W[0], {9.0, 0.0, 0.0}, t.way_W.back()}; };
  EXPECT_EQ(compare({makeDetour()}, longer).ratio, 1.0);
  EXPECT_FALSE(compare({makeDetour()}, nullptr).ratio);
  EXPECT_FALSE(compare({}, ends).ratio);
  EXPECT_FALSE(compare({}, ends).off_path);
}

}  // namespace
}  // namespace raven2_trainer::training
