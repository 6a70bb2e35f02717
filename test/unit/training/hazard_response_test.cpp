#include "raven2_trainer/training/hazard_response.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <tuple>
#include <utility>

#include "gtest/gtest.h"
#include "raven2_trainer/core/vec3.h"

namespace raven2_trainer::training {
namespace {

constexpr std::size_t kInjection = 600;
constexpr double kScale = 0.1;

/** [m/s] of the gold hand along x, by milliseconds from the injection. */
using Speed = std::function<double(Tick)>;

double goingOn(Tick) {
  return 0.08;
}

Speed then(double before, Tick when, double after) {
  return [=](Tick t) { return t < when ? before : after; };
}

/** A window in which the hand feels nothing and the robot shows nothing. */
HazardWindow makeQuietWindow(const Speed& speed, Tick until = 6000) {
  HazardWindow window;
  window.motion_scale = kScale;
  window.injection = kInjection;
  window.recovered = true;
  double place = 3.0;
  for (Tick t = -static_cast<Tick>(kInjection); t < until; ++t) {
    HandSample sample;
    sample.pedal = 1;
    sample.has_robot = 1;
    sample.linked = 1;
    place += speed(t) * kTickSeconds;
    at(sample.master_I, Arm::kGold) = {place * kScale, 0.4, 0.0};
    window.samples.push_back(sample);
  }
  window.recovery = window.samples.size();
  return window;
}

HandSample& sampleAt(HazardWindow* window, Tick after) {
  return window->samples[kInjection + static_cast<std::size_t>(after)];
}

/** Force from `begin` to `end` ms behind the injection, all of it the force cue. */
void push(HazardWindow* window, Tick begin, Tick end, const Vec3& force, Arm arm = Arm::kGold) {
  for (Tick t = begin; t < end; ++t) {
    at(sampleAt(window, t).force_I, arm) = force;
    at(sampleAt(window, t).cue_force, arm) = norm(force);
  }
}

/** A felt force from the injection on. */
HazardWindow makeWindow(const Speed& speed) {
  HazardWindow window = makeQuietWindow(speed);
  push(&window, 0, 300, {0.0, kFeltForce, 0.0});
  return window;
}

void liftPedal(HazardWindow* window, Tick begin, Tick end) {
  for (Tick t = begin; t < end; ++t)
    sampleAt(window, t).pedal = 0;
}

void expectFirst(const HazardResponse& result, Response response, Tick after, Tick tolerance = 6) {
  EXPECT_EQ(result.first.response, response) << kResponseNames[static_cast<std::size_t>(result.first.response)];
  EXPECT_NEAR(static_cast<double>(result.first.after), static_cast<double>(after), static_cast<double>(tolerance));
}

HazardResponse judge(const HazardWindow& window, const ResponseRule& rule = {}) {
  return judgeResponse(window, rule, {});
}

TEST(HazardResponse, AStopFromBeforeTheHazardIsNoAnswer) {
  HazardWindow window = makeWindow(goingOn);
  for (HandSample& sample : window.samples)
    sample.stop = 1;
  EXPECT_EQ(judge(window).first.response, Response::kPushOn);
}

TEST(HazardResponse, AHandThatRestsInAClutchDoesNotHoldStill) {
  const auto pauses = [](Tick t) { return t > 600 && t < 3000 ? 0.0 : 0.08; };
  HazardWindow window = makeWindow(pauses);
  window.usual_clutch = 1500;  // released for less than twice as long is no answer
  liftPedal(&window, 500, 3100);
  EXPECT_EQ(judge(window).first.response, Response::kNone);
}

TEST(ResponseRule, IsThatOfTheDrill) {
  ExerciseDrill drill;
  for (std::size_t i = 0; i < kDrillResponseCount; ++i)
    (i % 2 == 0 ? drill.right : drill.wrong).push_back(static_cast<DrillResponse>(i));
  drill.within = 3.5;
  const ResponseRule rule = ruleOf(drill);
  EXPECT_EQ(rule.within, 3.5);
  ASSERT_EQ(rule.right.size(), 3u);
  ASSERT_EQ(rule.wrong.size(), 3u);
  for (std::size_t i = 0; i < kDrillResponseCount; ++i) {
    const Response response = (i % 2 == 0 ? rule.right : rule.wrong)[i / 2];
    EXPECT_STREQ(kResponseNames[static_cast<std::size_t>(response)], kDrillResponseNames[i]);
  }
}

TEST(HazardResponse, PedalUpIsExactAndRight) {
  HazardWindow window = makeQuietWindow(goingOn);
  push(&window, 40, 900, {0.0, 1.0, 0.0});
  liftPedal(&window, 437, 2600);
  const HazardResponse result = judge(window);
  expectFirst(result, Response::kPedalUp, 437, 0);
  EXPECT_EQ(result.deciding.after, 437);
  EXPECT_EQ(result.verdict, Verdict::kRight);
  EXPECT_EQ(result.force_after, 40);
  EXPECT_EQ(result.cue_after, 40);
  EXPECT_EQ(result.sense, Sense::kForce);
}

/** A force of `newton` on one hand for `length` ms, and a long release of the pedal well behind it. */
HazardResponse afterForce(Arm arm, double newton, Tick length, Tick recovery = 6000) {
  HazardWindow window = makeQuietWindow(goingOn);
  push(&window, 200, 200 + length, {0.0, newton, 0.0}, arm);
  liftPedal(&window, 700, 6000);
  window.recovery = kInjection + static_cast<std::size_t>(recovery);
  return judge(window);
}

/** As afterForce(), but with the robot's tip `gap` away from the model's. */
HazardResponse afterGap(Arm arm, double gap, Tick length, bool has_robot = true) {
  HazardWindow window = makeQuietWindow(goingOn);
  for (Tick t = 200; t < 200 + length; ++t) {
    at(sampleAt(&window, t).robot_B, arm) = {0.0, 0.0, gap};
    sampleAt(&window, t).has_robot = has_robot ? 1 : 0;
  }
  liftPedal(&window, 700, 6000);
  return judge(window);
}

TEST(HazardResponse, AForceThatAHandNoticesIsACue) {
  for (const Arm arm : kArms) {
    const HazardResponse felt = afterForce(arm, 0.5, 100);
    EXPECT_EQ(felt.cue_after, 200);
    EXPECT_EQ(felt.sense, Sense::kForce);
    EXPECT_EQ(felt.verdict, Verdict::kRight);
    for (const Tick recovery : {201, 250})
      EXPECT_EQ(afterForce(arm, 0.5, 1000, recovery).verdict, Verdict::kRight) << "it begins in the aftermath";
    for (const HazardResponse& nothing :
         {afterForce(arm, 0.49, 2000), afterForce(arm, 3.0, 99), afterForce(arm, 3.0, 1000, 200)}) {
      EXPECT_EQ(nothing.cue_after, -1);
      EXPECT_EQ(nothing.sense, Sense::kNone);
      EXPECT_EQ(nothing.verdict, Verdict::kNotJudged);
      EXPECT_EQ(nothing.reaction.response, Response::kNone);
    }
  }
}

TEST(HazardResponse, ARobotThatPartsVisiblyIsACue) {
  for (const Arm arm : kArms) {
    const HazardResponse seen = afterGap(arm, -0.003, 100);
    EXPECT_EQ(seen.cue_after, 300) << "three pictures later";
    EXPECT_EQ(seen.sense, Sense::kGhost);
    EXPECT_EQ(seen.verdict, Verdict::kRight);
    for (const HazardResponse& nothing :
         {afterGap(arm, 0.0029, 2000), afterGap(arm, 0.01, 99), afterGap(arm, 0.01, 2000, false)})
      EXPECT_EQ(nothing.verdict, Verdict::kNotJudged);
  }
}

TEST(HazardResponse, WhatWasThereBeforeTheInjectionIsNoCueUntilItHasEnded) {
  for (const Arm arm : kArms) {
    for (const bool is_force : {true, false}) {
      for (const auto& [from, to, again, cue] : {std::tuple<Tick, Tick, Tick, Tick>{-1, 2000, 2000, -1},
                                                 {-100, 150, 2000, -1},
                                                 {-100, 150, 300, 300},
                                                 {-100, 0, 0, -1},
                                                 {-100, -1, 0, 0}}) {
        HazardWindow window = makeQuietWindow(goingOn);
        for (Tick t = -100; t < 2000; ++t) {
          if ((t < from || t >= to) && t < again) continue;
          if (is_force)
            at(sampleAt(&window, t).cue_force, arm) = 1.0;
          else
            at(sampleAt(&window, t).robot_B, arm) = {0.0, 0.0, 0.01};
        }
        liftPedal(&window, 900, 6000);
        const Tick wanted = cue < 0 || is_force ? cue : cue + kNoticed;
        EXPECT_EQ(judge(window).cue_after, wanted) << name(arm) << is_force << " " << from << " " << to << " " << again;
      }
    }
  }
}

TEST(HazardResponse, WhatWasThereOfOneArmHidesNoCueOfTheOther) {
  for (const Arm arm : kArms) {
    HazardWindow window = makeQuietWindow(goingOn);
    push(&window, -200, 4000, {0.0, 1.0, 0.0}, arm);
    push(&window, 150, 1000, {0.0, 1.0, 0.0}, otherArm(arm));
    liftPedal(&window, 600, 6000);
    EXPECT_EQ(judge(window).cue_after, 150) << name(arm);
    EXPECT_EQ(judge(window).verdict, Verdict::kRight) << name(arm);
  }
}

TEST(HazardResponse, TheFirstCueCountsWhicheverSenseItIsFor) {
  for (const Tick parted : {50, 150}) {
    HazardWindow window = makeQuietWindow(goingOn);
    push(&window, 200, 1000, {0.0, 1.0, 0.0});
    for (Tick t = parted; t < 1000; ++t)
      at(sampleAt(&window, t).robot_B, Arm::kGreen) = {0.0, 0.0, 0.01};
    EXPECT_EQ(judge(window).cue_after, parted == 50 ? 150 : 200);
    EXPECT_EQ(judge(window).sense, parted == 50 ? Sense::kGhost : Sense::kForce);
  }
}

TEST(HazardResponse, AClutchIsNoAnswer) {
  struct Case {
    Tick usual, up;
    bool answers;
  };
  for (const Case& c : {Case{0, 500, false}, Case{0, 1999, false}, Case{0, 2000, true}, Case{500, 2000, true},
                        Case{1500, 2000, false}, Case{1500, 2999, false}, Case{1500, 3000, true}}) {
    HazardWindow window = makeWindow(then(0.006, 0, 0.006));
    window.usual_clutch = c.usual;
    liftPedal(&window, 437, 437 + c.up);
    const HazardResponse result = judge(window);
    EXPECT_EQ(result.verdict, c.answers ? Verdict::kRight : Verdict::kNone) << c.usual << " " << c.up;
    EXPECT_EQ(result.reaction.after, c.answers ? 437 : -1);
    EXPECT_EQ(result.release, c.up);
    EXPECT_EQ(result.release_needed, c.usual == 1500 ? 3000 : 2000);
  }
}

TEST(HazardResponse, TheLongestReleaseInTheTimeForAnAnswerIsGiven) {
  const auto release = [](std::initializer_list<std::pair<Tick, Tick>> lifts) {
    HazardWindow window = makeWindow(goingOn);
    for (const auto& [begin, end] : lifts)
      liftPedal(&window, begin, end);
    return judge(window).release;
  };
  EXPECT_EQ(release({}), 0);
  EXPECT_EQ(release({{-300, kQuickest}}), 0) << "over before anybody could answer";
  EXPECT_EQ(release({{-300, kQuickest + 1}}), 401) << "a clutch that went on";
  EXPECT_EQ(release({{500, 900}, {1000, 1700}, {1800, 2300}}), 700);
  EXPECT_EQ(release({{4000, 4700}}), 700) << "at twice the time of the rule";
  EXPECT_EQ(release({{4001, 4700}}), 0);
  HazardWindow window = makeQuietWindow(goingOn);
  liftPedal(&window, 500, 900);
  EXPECT_EQ(judge(window).release, 0) << "there was nothing to answer";
  EXPECT_EQ(judge(window).release_needed, 0);
}

TEST(HazardResponse, ItTakesLongerToDisengageThanTwoClutches) {
  EXPECT_EQ(disengagedFor(0), 2000);
  EXPECT_EQ(disengagedFor(1000), 2000);
  EXPECT_EQ(disengagedFor(1001), 2002);
  EXPECT_EQ(disengagedFor(60000), 10000) << "or nobody could answer after a long pause";
}

TEST(HazardResponse, WhoDisengagesBehindAClutchIsTimedFromTheSecondRelease) {
  HazardWindow window = makeWindow(goingOn);
  liftPedal(&window, 150, 650);
  liftPedal(&window, 800, 6000);
  EXPECT_EQ(judge(window).verdict, Verdict::kRight);
  EXPECT_EQ(judge(window).reaction.after, 800);
}

TEST(HazardResponse, RetreatBeginsWithTheFirstTickOfItsRun) {
  const HazardWindow window = makeWindow(then(0.08, 300, -0.05));
  expectFirst(judge(window), Response::kRetreat, 300);
  EXPECT_EQ(judge(window).verdict, Verdict::kNone) << "every stroke ends like this";
  ResponseRule rule;
  rule.right = {Response::kRetreat};
  EXPECT_EQ(judge(window, rule).verdict, Verdict::kRight) << "if the rule asks for it";
}

TEST(HazardResponse, AShortStepBackIsNoRetreat) {
  const Speed twitch = [](Tick t) { return t >= 300 && t < 320 ? -0.05 : 0.08; };
  EXPECT_NE(judge(makeWindow(twitch)).first.response, Response::kRetreat);
  const Speed longer = [](Tick t) { return t >= 300 && t < 345 ? -0.05 : 0.08; };
  expectFirst(judge(makeWindow(longer)), Response::kRetreat, 300);
}

TEST(HazardResponse, SlowingDownAndHoldingStillAreFound) {
  expectFirst(judge(makeWindow(then(0.08, 250, 0.012))), Response::kSlow, 250);  // below a fifth of 80 mm/s
  expectFirst(judge(makeWindow(then(0.08, 250, 0.002))), Response::kHoldStill, 250);
  EXPECT_NE(judge(makeWindow(then(0.08, 250, 0.02))).first.response, Response::kSlow);  // a quarter
}

TEST(HazardResponse, StandingStillCountsAsSlowWhereThatIsRight) {
  ResponseRule rule;
  rule.right = {Response::kSlow};
  const HazardResponse result = judge(makeWindow(then(0.08, 250, 0.0)), rule);
  EXPECT_EQ(result.deciding.response, Response::kHoldStill);
  EXPECT_EQ(result.verdict, Verdict::kRight);
  rule.right = {Response::kHoldStill};
  EXPECT_NE(judge(makeWindow(then(0.08, 250, 0.012)), rule).verdict, Verdict::kRight);
}

TEST(HazardResponse, ALongRestAfterSlowingIsAnotherResponse) {
  const Speed in_two = [](Tick t) { return t < 250 ? 0.08 : t < 800 ? 0.012 : 0.0; };
  ResponseRule rule;
  rule.right = {Response::kHoldStill};
  const HazardResponse result = judge(makeWindow(in_two), rule);
  expectFirst(result, Response::kSlow, 250);
  EXPECT_NEAR(static_cast<double>(result.deciding.after), 800.0, 6.0);
}

TEST(HazardResponse, ARestBetweenStrokesIsNoResponse) {
  const Speed strokes = [](Tick t) { return t >= 250 && t < 1150 ? 0.0 : 0.08; };
  EXPECT_EQ(judge(makeWindow(strokes)).first.response, Response::kPushOn);
  const Speed long_rest = [](Tick t) { return t >= 250 && t < 2200 ? 0.0 : 0.08; };
  EXPECT_NE(judge(makeWindow(long_rest)).first.response, Response::kHoldStill);
  const Speed longer = [](Tick t) { return t >= 250 && t < 2300 ? 0.0 : 0.08; };
  expectFirst(judge(makeWindow(longer)), Response::kHoldStill, 250);
}

TEST(HazardResponse, AHandThatRestsWhileTheOtherWorksIsNoResponse) {
  HazardWindow window = makeWindow(then(0.08, 250, 0.0));
  for (std::size_t k = kInjection; k < window.samples.size(); ++k) {
    const double place = 0.08 * kTickSeconds * static_cast<double>(k - kInjection);
    at(window.samples[k].master_I, Arm::kGreen) = {0.0, place * kScale, 0.0};
  }
  EXPECT_EQ(judge(window).first.response, Response::kPushOn);
}

TEST(HazardResponse, AHandThatWasSlowCanNeitherSlowDownNorTurnBack) {
  const HazardResponse result = judge(makeWindow(then(0.008, 300, -0.008)));
  EXPECT_EQ(result.first.response, Response::kNone);
  EXPECT_EQ(result.first.after, -1);
  EXPECT_EQ(result.verdict, Verdict::kNone);
}

TEST(HazardResponse, AHandThatStoodHoldsStillIfItStaysForTwoSecondsBehindTheCue) {
  const auto behind = [](Tick cue) {
    HazardWindow window = makeQuietWindow(then(0.0, 2650, 0.008));
    push(&window, cue, 4000, {0.0, kFeltForce, 0.0});
    return judge(window);
  };
  expectFirst(behind(0), Response::kHoldStill, 100, 0);
  expectFirst(behind(400), Response::kHoldStill, 500, 0);
  EXPECT_EQ(behind(400).verdict, Verdict::kRight);
  EXPECT_EQ(behind(700).first.response, Response::kNone) << "1.85 s are too short";
}

TEST(HazardResponse, AHandThatWasSlowHoldsStillFromWhenItComesToStand) {
  expectFirst(judge(makeWindow(then(0.008, 600, 0.001))), Response::kHoldStill, 600);
}

TEST(HazardResponse, AnEmergencyStopIsOne) {
  HazardWindow window = makeWindow(goingOn);
  for (Tick t = 700; t < 4000; ++t)
    sampleAt(&window, t).stop = 1;
  expectFirst(judge(window), Response::kStop, 700, 0);
}

TEST(HazardResponse, PushingOnIsWrongIfItDecidesFirst) {
  HazardWindow window = makeQuietWindow(goingOn);
  push(&window, 50, 4000, {0.0, 0.5, 0.0});
  const HazardResponse result = judge(window);
  expectFirst(result, Response::kPushOn, 1550, 0);
  EXPECT_EQ(result.verdict, Verdict::kWrong);
  liftPedal(&window, 1400, 6000);
  EXPECT_EQ(judge(window).verdict, Verdict::kRight);
}

TEST(HazardResponse, AHandThatStoodPushesOnInAnyDirection) {
  expectFirst(judge(makeWindow(then(0.0, 200, -0.05))), Response::kPushOn, 1500, 0);
  EXPECT_EQ(judge(makeWindow(then(0.0, 200, -0.01))).first.response, Response::kNone);  // 13 mm in all
}

TEST(HazardResponse, ALateOneIsLate) {
  HazardWindow window = makeQuietWindow(then(0.006, 0, 0.006));
  push(&window, 500, 4000, {0.0, 0.5, 0.0});
  liftPedal(&window, 2400, 6000);
  EXPECT_EQ(judge(window).verdict, Verdict::kRight);  // 1.9 s behind the cue
  ResponseRule rule;
  rule.within = 1.5;
  EXPECT_EQ(judge(window, rule).verdict, Verdict::kLate);
  EXPECT_EQ(judge(window, rule).deciding.after, 2400);
}

TEST(HazardResponse, WhatComesSoonerThanAnybodyReactsIsACoincidence) {
  HazardWindow window = makeWindow(goingOn);
  liftPedal(&window, 60, 80);
  liftPedal(&window, 500, 2600);
  const HazardResponse result = judge(window);
  expectFirst(result, Response::kPedalUp, 500, 0);
  ASSERT_EQ(result.coincidences.size(), 1u);
  EXPECT_EQ(result.coincidences[0].response, Response::kPedalUp);
  EXPECT_EQ(result.coincidences[0].after, 60);
}

TEST(HazardResponse, WhoHasLetGoBeforeAnybodyReactsAnswersByStayingSo) {
  for (const Tick begin : {-300, 0, 60}) {
    HazardWindow window = makeWindow(goingOn);
    liftPedal(&window, begin, 6000);
    EXPECT_EQ(judge(window).verdict, Verdict::kRight) << begin;
    EXPECT_EQ(judge(window).deciding.after, kQuickest) << "nobody can react sooner";
    EXPECT_EQ(judge(window).coincidences.size(), begin < 0 ? 0u : 1u);
    sampleAt(&window, 1500).pedal = 1;
    EXPECT_EQ(judge(window).verdict, Verdict::kRight) << "the pedal went down, and up again in time";
    EXPECT_EQ(judge(window).deciding.after, 1501);
    for (Tick t = 1500; t < 6000; ++t)
      sampleAt(&window, t).pedal = 1;
    EXPECT_EQ(judge(window).verdict, Verdict::kNone) << "a trainee who goes on has not answered";
  }
}

TEST(HazardResponse, ARightAnswerTakesFromItsCueToTheNextPress) {
  for (const Tick press : {2600, 3137, 6000}) {
    HazardWindow window = makeQuietWindow(goingOn);
    push(&window, 40, 340, {0.0, kFeltForce, 0.0});
    liftPedal(&window, 437, press);
    EXPECT_EQ(judge(window).answer_time, press - 40) << "6000: to the window's end";
    sampleAt(&window, 500).stop = 1;
    ResponseRule rule;
    rule.right = {Response::kStop};
    EXPECT_EQ(judge(window, rule).answer_time, press - 40);
  }
}

/** The pedal is down from 3000 to 3600 ms behind the injection, and again from 4000 on. */
HazardWindow makeTwoPresses(Tick recovery) {
  HazardWindow window = makeWindow(goingOn);
  window.recovery = kInjection + static_cast<std::size_t>(recovery);
  liftPedal(&window, 437, 3000);
  liftPedal(&window, 3600, 4000);
  return window;
}

/** From 3300 ms on, the robot's arm moves with the model. */
void moveAlong(HazardWindow* window, Arm arm, double metres) {
  for (Tick t = 3300; t < 6000; ++t) {
    at(sampleAt(window, t).robot_B, arm) = {metres, 0.0, 0.0};
    at(sampleAt(window, t).model_B, arm) = {metres, 0.0, 0.0};
  }
}

TEST(HazardResponse, InTheAftermathAPressThatTheRobotDoesNotFollowIsPartOfTheAnswer) {
  constexpr Tick kFirst = 3000, kSecond = 4000;
  for (const Arm arm : kArms) {
    HazardWindow window = makeTwoPresses(6000);
    EXPECT_EQ(judge(window).answer_time, kSecond) << "the arm did not move";
    moveAlong(&window, arm, 0.99 * kSeenGap);
    EXPECT_EQ(judge(window).answer_time, kSecond) << "too little to be seen";
    moveAlong(&window, arm, 1.01 * kSeenGap);
    EXPECT_EQ(judge(window).answer_time, kFirst);
    HazardWindow again = window;
    push(&again, 3499, 3500, {0.0, 0.0, kFeltForce});
    EXPECT_EQ(judge(again).answer_time, kSecond) << "the force is felt again";
    again = window;
    at(sampleAt(&again, 3499).model_B, arm) = {};
    EXPECT_EQ(judge(again).answer_time, kSecond) << "the gap is seen again";
    again = window;
    sampleAt(&again, 3499).linked = 0;
    EXPECT_EQ(judge(again).answer_time, kSecond) << "the robot does not follow again";
  }
}

TEST(HazardResponse, BehindTheAftermathAnyPressEndsTheAnswer) {
  for (const Tick recovery : {900, 3000, 3001, 3499}) {
    HazardWindow window = makeTwoPresses(recovery);
    push(&window, 3499, 3500, {0.0, 0.0, kFeltForce});
    EXPECT_EQ(judge(window).answer_time, 3000) << recovery;
  }
}

TEST(HazardResponse, StandingAndSlowingTakeAsLongAsTheyHaveToLast) {
  const auto expect_time = [](double speed, Response right, Tick carried_through) {
    ResponseRule rule;
    rule.right = {right};
    const HazardResponse result = judge(makeWindow(then(0.08, 437, speed)), rule);
    EXPECT_EQ(result.verdict, Verdict::kRight);
    EXPECT_EQ(result.answer_time, result.deciding.after + carried_through) << kResponseNames[static_cast<int>(right)];
  };
  expect_time(0.0, Response::kHoldStill, kCarriedThrough);
  expect_time(0.012, Response::kSlow, kCarriedThrough);
  expect_time(-0.08, Response::kRetreat, 0);
}

TEST(HazardResponse, OnlyARightAnswerTakesNoTimeOfTheAttempt) {
  HazardWindow window = makeWindow(then(0.006, 0, 0.006));
  liftPedal(&window, 437, 2600);
  ResponseRule rule;
  rule.within = 0.4;
  EXPECT_EQ(judge(window, rule).verdict, Verdict::kLate);
  EXPECT_EQ(judge(window, rule).answer_time, 0);
  rule.right = {Response::kStop};
  rule.wrong = {Response::kPedalUp};
  EXPECT_EQ(judge(window, rule).verdict, Verdict::kWrong);
  EXPECT_EQ(judge(window, rule).answer_time, 0);
}

TEST(HazardResponse, AStopThatCameBeforeAnybodyReactsLeavesNothingToAnswer) {
  HazardWindow window = makeWindow(then(0.006, 0, 0.006));
  EXPECT_EQ(judge(window).verdict, Verdict::kNone);
  sampleAt(&window, 50).stop = 1;
  EXPECT_EQ(judge(window).verdict, Verdict::kNotJudged);
}

/** Wrong: the pedal goes up. Late: it does so 1.9 s after the cue, of 1.5 s allowed. */
TEST(HazardResponse, AStopThatCameBeforeAnybodyReactsSparesAllButTheRight) {
  ResponseRule wrong, late;
  wrong.right = {Response::kRetreat};
  wrong.wrong = {Response::kPedalUp};
  late.within = 1.5;
  for (const auto& [rule, verdict] :
       {std::pair{wrong, Verdict::kWrong}, {late, Verdict::kLate}, {{}, Verdict::kRight}}) {
    HazardWindow window = makeQuietWindow(then(0.006, 0, 0.006));
    push(&window, 500, 4000, {0.0, 0.5, 0.0});
    liftPedal(&window, 2400, 6000);
    EXPECT_EQ(judge(window, rule).verdict, verdict);
    for (const Tick stop : {0, 499, 500, 599}) {
      HazardWindow stopped = window;
      sampleAt(&stopped, stop).stop = 1;
      EXPECT_EQ(judge(stopped, rule).verdict, verdict == Verdict::kRight ? verdict : Verdict::kNotJudged) << stop;
    }
    sampleAt(&window, 600).stop = 1;
    EXPECT_NE(judge(window, rule).verdict, Verdict::kNotJudged);
  }
}

/** The log ends `end` ms behind the injection. */
HazardWindow cutOff(HazardWindow window, Tick end) {
  window.samples.resize(kInjection + static_cast<std::size_t>(end));
  window.recovery = window.samples.size();
  window.recovered = false;
  return window;
}

Verdict verdictAt(const HazardWindow& window, Tick end, const ResponseRule& rule = {}) {
  return judge(cutOff(window, end), rule).verdict;
}

TEST(HazardResponse, WithoutAnAnswerTheLogMustShowAllTheTimeForOne) {
  for (const Arm arm : kArms) {
    HazardWindow window = makeQuietWindow(then(0.006, 0, 0.006), 9000);
    push(&window, 200, 400, {0.0, 1.0, 0.0}, arm);
    for (const Tick end : {301, 360, 2200, 4200})
      EXPECT_EQ(verdictAt(window, end), Verdict::kNotJudged) << end;
    for (const Tick end : {4210, 5000, 9000})  // the speed is a mean over 10 ms
      EXPECT_EQ(verdictAt(window, end), Verdict::kNone) << end;
  }
}

TEST(HazardResponse, AReleaseThatTheLogsEndCutsOffMayBeAClutch) {
  for (const Arm arm : kArms) {
    HazardWindow window = makeQuietWindow(goingOn, 9000);
    push(&window, 40, 900, {0.0, 1.0, 0.0}, arm);
    liftPedal(&window, 437, 9000);
    for (const Tick end : {438, 637, 2436})
      EXPECT_EQ(verdictAt(window, end), Verdict::kNotJudged) << end;
    EXPECT_EQ(verdictAt(window, 2437), Verdict::kRight);
    EXPECT_EQ(judge(cutOff(window, 2437)).deciding.after, 437);
    EXPECT_EQ(judge(cutOff(window, 2436)).answer_time, 0);
    window.usual_clutch = 1500;
    EXPECT_EQ(verdictAt(window, 3436), Verdict::kNotJudged) << "this surgeon's clutches are longer";
    EXPECT_EQ(verdictAt(window, 3437), Verdict::kRight);
  }
}

TEST(HazardResponse, WhetherAReleaseIsLateOrWrongIsAlsoUnknownUntilItLasted) {
  HazardWindow window = makeQuietWindow(then(0.006, 0, 0.006), 9000);
  push(&window, 0, 4000, {0.0, 1.0, 0.0});
  liftPedal(&window, 3500, 9000);
  EXPECT_EQ(verdictAt(window, 4500), Verdict::kNotJudged) << "late, or a clutch and no answer";
  EXPECT_EQ(verdictAt(window, 5500), Verdict::kLate);
  ResponseRule rule;
  rule.right = {Response::kStop};
  rule.wrong = {Response::kPedalUp};
  EXPECT_EQ(verdictAt(window, 5499, rule), Verdict::kNotJudged);
  EXPECT_EQ(verdictAt(window, 5500, rule), Verdict::kWrong);
}

TEST(HazardResponse, HandsThatMayGoOnRestingAreUnknown) {
  const HazardWindow window = makeQuietWindow(then(0.08, 1200, 0.0), 9000);
  HazardWindow felt = window;
  push(&felt, 0, 300, {0.0, 1.0, 0.0});
  EXPECT_EQ(verdictAt(felt, 1600), Verdict::kNotJudged) << "pushed on, or the beginning of a rest of 2 s";
  EXPECT_EQ(verdictAt(felt, 3150), Verdict::kNotJudged);
  EXPECT_EQ(verdictAt(felt, 3250), Verdict::kRight);
}

TEST(HazardResponse, WhatIsKnownDoesNotDependOnTheLogsEnd) {
  HazardWindow window = makeQuietWindow(goingOn, 9000);
  push(&window, 50, 4000, {0.0, 0.5, 0.0});
  for (const Tick end : {1551, 1600, 3000, 9000})
    EXPECT_EQ(verdictAt(window, end), Verdict::kWrong) << end;
  EXPECT_EQ(verdictAt(window, 1550), Verdict::kNotJudged);
  liftPedal(&window, 600, 9000);
  sampleAt(&window, 700).stop = 1;
  EXPECT_EQ(verdictAt(window, 710), Verdict::kRight) << "the stop, or the release before it";
  liftPedal(&window, 0, 600);
  window.samples[kInjection + 700].stop = 0;
  EXPECT_EQ(verdictAt(window, 1999), Verdict::kNotJudged) << "the pedal was up before anybody could react";
  EXPECT_EQ(verdictAt(window, 2000), Verdict::kRight);
}

TEST(HazardResponse, AForceOfOtherOriginIsNoCue) {
  for (const Arm arm : kArms) {
    HazardWindow window = makeQuietWindow(goingOn);
    for (Tick t = 0; t < 3000; ++t)
      at(sampleAt(&window, t).force_I, arm) = {0.0, 1.0, 0.0};
    EXPECT_EQ(judge(window).verdict, Verdict::kNotJudged);
    EXPECT_EQ(judge(window).peak_force, 1.0);
    for (Tick t = 300; t < 400; ++t)
      at(sampleAt(&window, t).cue_force, arm) = kFeltForce;
    EXPECT_EQ(judge(window).cue_after, 300);
  }
}

TEST(HazardResponse, AnswersAreWatchedForUntilTheLatestIsKnown) {
  ResponseRule rule;
  for (const double within : {0.05, 2.0, 60.0}) {
    rule.within = within;
    EXPECT_GE(watchOf(rule), static_cast<Tick>(2000 * within) + disengagedFor(kLongestHabit));
  }
}

TEST(HazardResponse, AResponseThatTheRuleDoesNotNameDoesNotDecide) {
  HazardWindow window = makeWindow(then(0.08, 250, 0.012));
  liftPedal(&window, 2400, 6000);
  ResponseRule rule;
  rule.right = {Response::kPedalUp};
  rule.wrong = {};
  rule.within = 3.0;
  const HazardResponse result = judge(window, rule);
  expectFirst(result, Response::kSlow, 250);
  EXPECT_EQ(result.deciding.response, Response::kPedalUp);
  EXPECT_EQ(result.deciding.after, 2400);
  EXPECT_EQ(result.reaction.after, 2400) << "the slowing was part of the work";
  rule.wrong = {Response::kSlow};
  EXPECT_EQ(judge(window, rule).verdict, Verdict::kWrong);
}

TEST(HazardResponse, WhatTheRuleDoesNotNameIsNoReactionToACueThatCameWithIt) {
  ResponseRule rule;
  rule.right = {Response::kPedalUp};
  rule.wrong = {};
  for (const Tick cue : {100, 200}) {
    HazardWindow window = makeQuietWindow(then(0.08, 250, 0.008));
    push(&window, cue, 4000, {0.0, 0.5, 0.0});
    const HazardResponse result = judge(window, rule);
    EXPECT_EQ(result.verdict, Verdict::kNone);
    EXPECT_EQ(result.reaction.response, cue == 100 ? Response::kSlow : Response::kNone) << cue;
    EXPECT_EQ(result.coincidences.size(), cue == 100 ? 0u : 1u);
  }
}

/** A hand model of 0.5 kg, 200 N/m and 10 Ns/m, as in config/console.yaml. */
HandConfig makeHand() {
  HandConfig hand;
  hand.hand_mass = 0.5;
  hand.hand_stiffness = 200.0;
  hand.hand_damping = 10.0;
  return hand;
}

/** The place of such a hand under a step of force, by Euler steps far smaller than the model's. */
std::vector<double> pushed(const std::vector<double>& newton) {
  std::vector<double> places;
  double x = 0.0, v = 0.0;
  for (const double force : newton) {
    for (int i = 0; i < 100; ++i) {
      v += 1e-5 * (force - 200.0 * x - 10.0 * v) / 0.5;
      x += 1e-5 * v;
    }
    places.push_back(x);
  }
  return places;
}

/** A force of 3 N against the motion pushes the hand back, whatever the trainee does. */
HazardWindow makePushedWindow() {
  HazardWindow window = makeQuietWindow(then(0.03, 0, 0.03));
  push(&window, 150, 4000, {-3.0, 0.0, 0.0});
  std::vector<double> newton;
  for (const HandSample& sample : window.samples)
    newton.push_back(at(sample.force_I, Arm::kGold)[0]);
  const std::vector<double> places = pushed(newton);
  for (std::size_t k = 0; k < places.size(); ++k)
    at(window.samples[k].master_I, Arm::kGold)[0] += places[k] * kScale;
  return window;
}

TEST(HazardResponse, WhatTheForceDidToTheHandIsNoResponse) {
  const HazardWindow window = makePushedWindow();
  ASSERT_FALSE(judge(window).coincidences.empty());
  EXPECT_EQ(judge(window).coincidences[0].response, Response::kRetreat);  // without the explanation by the force
  const HazardResponse result = judgeResponse(window, {}, explainByForce(window.samples, makeHand()));
  expectFirst(result, Response::kPushOn, 1650, 0);
  EXPECT_TRUE(result.coincidences.empty());
}

TEST(HazardResponse, ADeliberateRetreatUnderForceIsFoundAtItsTime) {
  HazardWindow window = makePushedWindow();
  double back = 0.0;
  for (Tick t = 420; t < 4000; ++t) {
    back += 0.08 * kTickSeconds;  // 30 mm/s on, then 50 mm/s back
    at(sampleAt(&window, t).master_I, Arm::kGold)[0] -= back * kScale;
  }
  expectFirst(judgeResponse(window, {}, explainByForce(window.samples, makeHand())), Response::kRetreat, 420);
}

TEST(HazardResponse, MeasuresExcursionForceAndDurationUntilRecovery) {
  HazardWindow window = makeQuietWindow(goingOn);
  window.recovery = kInjection + 1000;
  push(&window, 100, 1500, {0.0, 0.0, -0.2});
  push(&window, 700, 820, {0.0, 2.0, 0.0}, Arm::kGreen);
  push(&window, 1200, 1201, {0.0, 3.0, 0.0}, Arm::kGreen);
  for (HandSample& sample : window.samples)
    at(sample.robot_B, Arm::kGreen) = at(sample.model_B, Arm::kGreen) = {0.1, 0.1, 0.1};
  at(sampleAt(&window, 500).robot_B, Arm::kGreen) = {0.1, 0.13, 0.14};
  at(sampleAt(&window, 500).model_B, Arm::kGreen) = {0.1, 0.12, 0.1};
  at(sampleAt(&window, 1100).robot_B, Arm::kGreen) = {9.0, 0.0, 0.0};
  const HazardResponse result = judge(window);
  EXPECT_EQ(result.duration, 1000);
  EXPECT_TRUE(result.recovered);
  EXPECT_NEAR(result.excursion, 0.05, 1e-12);
  EXPECT_NEAR(result.error, std::hypot(0.01, 0.04), 1e-12);
  EXPECT_NEAR(result.peak_force, 2.0, 1e-12);
  EXPECT_NEAR(result.impulse, 0.780 * 0.2 + 0.120 * 2.0, 1e-9);
  EXPECT_EQ(result.force_after, 100);
  EXPECT_EQ(result.cue_after, 700);  // 0.2 N is too little to notice
}

TEST(HazardResponse, OfNothingIsNothing) {
  EXPECT_EQ(judge({}).verdict, Verdict::kNotJudged);
  HazardWindow window = makeQuietWindow(goingOn, 1);
  EXPECT_EQ(judge(window).first.response, Response::kNone);
  window.injection = 0;
  EXPECT_EQ(judge(window).first.response, Response::kNone);
}

/** The window with gold and green exchanged. */
HazardWindow exchanged(HazardWindow window) {
  for (HandSample& sample : window.samples) {
    for (PerArm<Vec3>* pair : {&sample.master_I, &sample.force_I, &sample.model_B, &sample.robot_B})
      std::swap((*pair)[0], (*pair)[1]);
    std::swap(sample.cue_force[0], sample.cue_force[1]);
  }
  return window;
}

void expectSame(const HazardResponse& a, const HazardResponse& b) {
  const auto expectSameTime = [](const TimedResponse& x, const TimedResponse& y) {
    EXPECT_EQ(x.response, y.response);
    EXPECT_EQ(x.after, y.after);
  };
  expectSameTime(a.first, b.first);
  expectSameTime(a.deciding, b.deciding);
  expectSameTime(a.reaction, b.reaction);
  EXPECT_EQ(a.verdict, b.verdict);
  EXPECT_EQ(a.force_after, b.force_after);
  EXPECT_EQ(a.cue_after, b.cue_after);
  EXPECT_EQ(a.sense, b.sense);
  EXPECT_EQ(a.excursion, b.excursion);
  EXPECT_EQ(a.error, b.error);
  EXPECT_EQ(a.peak_force, b.peak_force);
  EXPECT_NEAR(a.impulse, b.impulse, 1e-12);
}

/** Both robots' tips go astray, one from the model, one from where it was. */
HazardWindow makeAstrayWindow() {
  HazardWindow window = makeQuietWindow(then(0.08, 350, -0.05));
  push(&window, 100, 900, {0.0, 0.0, -0.2});
  for (Tick t = 200; t < 400; ++t) {
    at(sampleAt(&window, t).robot_B, Arm::kGold) = {0.03, 0.0, 0.0};
    at(sampleAt(&window, t).model_B, Arm::kGold) = {0.0, 0.0, 0.0};
    at(sampleAt(&window, t).robot_B, Arm::kGreen) = at(sampleAt(&window, t).model_B, Arm::kGreen) = {0.0, 0.07, 0.0};
  }
  push(&window, 200, 400, {0.5, 0.0, 0.0}, Arm::kGreen);
  return window;
}

TEST(HazardResponse, IsTheSameOfEitherArm) {
  const HazardWindow astray = makeAstrayWindow();
  EXPECT_NEAR(judge(astray).error, 0.03, 1e-12) << "of gold";
  EXPECT_NEAR(judge(astray).excursion, 0.07, 1e-12) << "of green";
  HazardWindow pushed_on = makeQuietWindow(goingOn);
  push(&pushed_on, 50, 4000, {0.0, 0.5, 0.0});
  const HazardWindow windows[] = {astray, pushed_on, makeWindow(then(0.08, 250, 0.002)),
                                  makeWindow(then(0.0, 2650, 0.008)), makeWindow(then(0.08, 300, -0.05))};
  for (const HazardWindow& window : windows) {
    expectSame(judge(window), judge(exchanged(window)));
    EXPECT_NE(judge(window).first.response, Response::kNone) << "or there is nothing to exchange";
  }
  const HazardWindow forced = makePushedWindow(), other = exchanged(forced);
  expectSame(judgeResponse(forced, {}, explainByForce(forced.samples, makeHand())),
             judgeResponse(other, {}, explainByForce(other.samples, makeHand())));
}

TEST(HazardResponse, MeasuresNothingFromARobotThatIsNotKnown) {
  HazardWindow window = makeAstrayWindow();
  for (Tick t = 250; t < 4000; ++t) {
    sampleAt(&window, t).has_robot = 0;
    at(sampleAt(&window, t).robot_B, Arm::kGold) = {5.0, 0.0, 0.0};
  }
  EXPECT_NEAR(judge(window).error, 0.03, 1e-12);
  EXPECT_NEAR(judge(window).excursion, 0.07, 1e-12);
  sampleAt(&window, 0).has_robot = 0;  // where it was is not known
  at(sampleAt(&window, 0).robot_B, Arm::kGold) = {5.0, 0.0, 0.0};
  EXPECT_NEAR(judge(window).error, 0.03, 1e-12);
  EXPECT_EQ(judge(window).excursion, 0.0);
}

TEST(HazardResponse, WhoCameToStandBeforeAnybodyReactsAnswersByStayingSo) {
  for (const Tick stand : {150, 250, 285}) {
    const auto until = [stand](Tick end) {
      HazardWindow window = makeQuietWindow([=](Tick t) { return t < stand || t >= end ? 0.08 : 0.0; });
      push(&window, 200, 400, {0.0, 1.0, 0.0});
      return judge(window);
    };
    EXPECT_EQ(until(9000).verdict, Verdict::kRight) << stand;
    EXPECT_EQ(until(9000).deciding.response, Response::kHoldStill);
    EXPECT_EQ(until(9000).deciding.after, 200 + kQuickest);
    EXPECT_EQ(until(2200).verdict, Verdict::kNone) << "not for two seconds";
  }
}

TEST(HazardResponse, HandsThatRestWhileAPlanMovesTheToolsAnswerNothing) {
  for (const double speed : {0.0, 0.08}) {  // before they come to rest
    HazardWindow window = makeWindow(then(speed, 400, 0.0));
    EXPECT_EQ(judge(window).verdict, Verdict::kRight);
    for (HandSample& sample : window.samples) {
      sample.executes = 1;
      sample.leads = 0;
    }
    EXPECT_EQ(judge(window).verdict, Verdict::kNone);
    liftPedal(&window, 437, 6000);
    EXPECT_EQ(judge(window).verdict, Verdict::kRight);
    EXPECT_EQ(judge(window).deciding.after, 437);
  }
}

TEST(HazardResponse, AGapThatTheModelMakesAloneIsNoCueUntilItHasClosed) {
  for (const Arm arm : kArms) {
    HazardWindow window = makeQuietWindow(goingOn);
    for (Tick t = 500; t < 3300; ++t) {
      at(sampleAt(&window, t).robot_B, arm) = {0.0, 0.0, 0.01};
      sampleAt(&window, t).apart = t < 3000 ? 1 : 0;
    }
    EXPECT_EQ(judge(window).sense, Sense::kNone);
    EXPECT_EQ(judge(window).verdict, Verdict::kNotJudged);
    for (Tick t = 3500; t < 4000; ++t)
      at(sampleAt(&window, t).robot_B, arm) = {0.0, 0.0, 0.01};
    EXPECT_EQ(judge(window).cue_after, 3500 + kNoticed);
  }
}

TEST(HazardResponse, AHandThatMovesNoToolDoesNotPushOn) {
  HazardWindow window = makeWindow(goingOn);
  liftPedal(&window, 1800, 6000);
  EXPECT_EQ(judge(window).verdict, Verdict::kWrong);
  for (Tick t = 200; t < 1800; ++t)
    sampleAt(&window, t).leads = 0;
  EXPECT_EQ(judge(window).verdict, Verdict::kRight);
  EXPECT_EQ(judge(window).deciding.after, 1800);
}

TEST(HazardResponse, APauseEndsWhatIsKnown) {
  HazardWindow window = makeWindow(goingOn);
  liftPedal(&window, 437, 2600);
  sampleAt(&window, 3000).paused = 1;
  EXPECT_EQ(judge(window).verdict, Verdict::kRight) << "the answer was over";
  sampleAt(&window, 0).paused = 1;
  EXPECT_EQ(judge(window).verdict, Verdict::kRight) << "the hazard began in that pause";
  sampleAt(&window, 1000).paused = 1;
  EXPECT_EQ(judge(window).verdict, Verdict::kNotJudged);
}

}  // namespace
}  // namespace raven2_trainer::training
