#include "raven2_trainer/haptics/passivity_guard.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <cmath>
#include <limits>
#include <vector>

#include "raven2_trainer/core/random.h"
#include "raven2_trainer/core/types.h"

namespace raven2_trainer::haptics {
namespace {

using Eigen::Vector3d;

constexpr PassivityConfig kConfig{/*enabled=*/true,     /*max_delay=*/0.12, /*budget=*/0.02, /*bank=*/0.03,
                                  /*hand_damping=*/1.0, /*rest=*/0.5};
constexpr double kRounding = 1e-12;  // [J]

PassivityConfig withDelay(double seconds) {
  PassivityConfig config = kConfig;
  config.max_delay = seconds;
  return config;
}

/** Nothing is ever forgotten: the plain sums. */
PassivityConfig withoutLimit(PassivityConfig config) {
  config.bank = 1e9;
  return config;
}

Vector3d anyVector(Random* random, double size) {
  return {random->uniform(-size, size), random->uniform(-size, size), random->uniform(-size, size)};
}

/** A smooth wander of a hand: three sinusoids an axis. */
class Wander {
 public:
  explicit Wander(Random* random) {
    for (int i = 0; i < 9; ++i) {
      amplitude[i] = random->uniform(0.0, 0.02);
      omega[i] = random->uniform(1.0, 60.0);
      phase[i] = random->uniform(0.0, 2.0 * kPi);
    }
  }
  Vector3d at(double t) const {
    Vector3d x = Vector3d::Zero();
    for (int i = 0; i < 9; ++i)
      x[i % 3] += amplitude[i] * std::sin(omega[i] * t + phase[i]);
    return x;
  }

 private:
  double amplitude[9], omega[9], phase[9];
};

TEST(PassivityGuard, AHandThatMovesWithoutForceHasNoAccount) {
  Random random(1);
  const Wander wander(&random);
  PassivityGuard guard(kConfig);
  for (int k = 0; k < 3000; ++k) {
    guard.observe(wander.at(1e-3 * k));
    guard.given(Vector3d::Zero(), false);
    ASSERT_EQ(guard.gain(), 1.0);
    ASSERT_EQ(guard.energy(), 0.0);
    ASSERT_EQ(guard.allowance(), kConfig.budget);
  }
}

TEST(PassivityGuard, AConstantForceGivesNothingForGood) {
  // GIVEN 3.3 N for a minute, and a hand that wanders by centimetres meanwhile
  Random random(2);
  const Wander wander(&random);
  PassivityGuard guard(kConfig);
  const Vector3d start = wander.at(0.0);
  for (int k = 0; k < 60000; ++k) {
    const double begun = std::min(1.0, k / 300.0);  // from where the hand rests when it begins
    guard.observe(start + begun * (wander.at(1e-3 * k) - start));
    guard.given({3.3, 0.0, 0.0}, true);
    // THEN the energy put into the motion would come back if the hand returned to its start. Only the forces still
    // under way at the start cost energy: at most 3.3 N over the hand's motion meanwhile
    ASSERT_EQ(guard.gain(), 1.0) << k;
  }
}

TEST(PassivityGuard, CountsTheWorkOfAForceInStepWithTheMotion) {
  // GIVEN x = A sin(wt) and a force F cos(wt): pi F A a period (integral of F cos(wt) A w cos(wt))
  constexpr double kAmplitude = 0.003, kForce = 0.5, kOmega = 47.0;
  constexpr int kPeriods = 5;
  PassivityConfig config = withDelay(0.0);
  config.hand_damping = 0.0;
  PassivityGuard guard(config);
  const int end = static_cast<int>(std::lround(kPeriods * 2.0 * kPi / kOmega / 1e-3));
  for (int k = 0; k <= end; ++k) {
    guard.observe({0.0, kAmplitude * std::sin(kOmega * 1e-3 * k), 0.0});
    guard.given({0.0, kForce * std::cos(kOmega * 1e-3 * (k + 0.5)), 0.0}, true);  // as in the middle of the tick
  }
  guard.given(Vector3d::Zero(), false);
  guard.observe({0.0, kAmplitude * std::sin(kOmega * 1e-3 * end), 0.0});
  EXPECT_NEAR(guard.energy(), kPeriods * kPi * kForce * kAmplitude, 0.01 * kPeriods * kPi * kForce * kAmplitude);
  EXPECT_EQ(guard.gain(), 0.0) << "23.6 mJ of 20";
}

TEST(PassivityGuard, NeverTakesTheWorkAtTheHandForLessWhateverTheDelayUpToItsBound) {
  // GIVEN any round trip up to 120 ms, however divided, and any forces and motions; the work summed up at the hand
  Random random(3);
  for (int run = 0; run < 60; ++run) {
    const int there = static_cast<int>(random.next() % 61), back = static_cast<int>(random.next() % 61);
    const Wander wander(&random);
    const double hold = random.uniform(1.0, 100.0);  // [ticks] of a force
    PassivityGuard guard(kConfig);
    std::vector<Vector3d> forces, hand;
    std::vector<double> work;  // [J] at the hand up to that tick
    Vector3d force = Vector3d::Zero(), anchor = Vector3d::Zero();
    for (int k = 0; k < 1000; ++k) {
      hand.push_back(wander.at(1e-3 * k));
      const bool has_arrived = k > there;
      const Vector3d acting = has_arrived ? forces[static_cast<std::size_t>(k - 1 - there)] : Vector3d::Zero();
      work.push_back(k > 0 ? work.back() + acting.dot(hand[k] - hand[k - 1]) : 0.0);
      const int seen = std::max(0, k - back);
      guard.observe(hand[static_cast<std::size_t>(seen)]);
      if (k == 0) anchor = hand[0];
      if (random.uniform(0.0, hold) < 1.0 || k == 0) force = anyVector(&random, 2.0);
      forces.push_back(force);
      guard.given(force, true);
      if (k <= there + back) continue;
      const Vector3d then = forces[static_cast<std::size_t>(seen - 1 - there)];
      const double gained = work[static_cast<std::size_t>(seen)] - std::max(0.0, then.dot(hand[seen] - anchor));
      ASSERT_GE(guard.energy(), gained - kRounding) << "run " << run << ", tick " << k;
    }
  }
}

TEST(PassivityGuard, OfOneDelayAloneItIsTheWorkAtTheHand) {
  // GIVEN a delay of zero, the sum is that of the definition
  Random random(4);
  const Wander wander(&random);
  PassivityGuard guard(withoutLimit(withDelay(0.0)));
  double work = 0.0;
  Vector3d before = wander.at(0.0), force = Vector3d::Zero(), anchor = before;
  for (int k = 0; k < 2000; ++k) {
    const Vector3d now = wander.at(1e-3 * k);
    guard.observe(now);
    work += force.dot(now - before);
    if (k > 0) {
      ASSERT_NEAR(guard.energy(), work - std::max(0.0, force.dot(now - anchor)), kRounding);
    }
    before = now;
    force = anyVector(&random, 1.0);
    guard.given(force, true);
  }
}

TEST(PassivityGuard, AllowsNoMoreThanTheHandsDampingTookHoweverTheMotionArrives) {
  // GIVEN a slow motion reported in whole 10 um and in bunches of up to 12 ticks
  Random random(5);
  for (int run = 0; run < 20; ++run) {
    const Wander wander(&random);
    PassivityGuard guard(kConfig);
    double taken = 0.0;  // [J] by 1 Ns/m
    Vector3d told = Vector3d::Zero();
    int next = 0;
    for (int k = 0; k < 5000; ++k) {
      const double t = 0.2e-3 * k;  // five times slower than it wanders
      taken += kConfig.hand_damping * (wander.at(t + 0.2e-3) - wander.at(t)).squaredNorm() / 1e-3;
      if (k >= next) {
        told = (wander.at(t) / 1e-5).array().round().matrix() * 1e-5;
        next = k + 1 + static_cast<int>(random.next() % 12);
      }
      guard.observe(told);
      guard.given({0.01, 0.0, 0.0}, true);
    }
    // bunches shift motion from one block to the next: a fifth of doubt
    ASSERT_LE(guard.allowance() - kConfig.budget, 1.2 * taken + 1e-4) << run;
    ASSERT_GT(guard.allowance() - kConfig.budget, 0.5 * taken) << run;
  }
}

/** A steady hand pushes back and forth against a force of 1 N that always opposes it: the port takes all of that. */
void pushAgainst(PassivityGuard* guard, int ticks) {
  for (int k = 0; k < ticks; ++k) {
    const double t = 1e-3 * k;
    guard->observe({0.03 * std::sin(kPi * t), 0.0, 0.0});
    guard->given({std::cos(kPi * t) > 0.0 ? -1.0 : 1.0, 0.0, 0.0}, true);
  }
}

/** Then the port gives 1 mJ a tick, as its gain lets it. @return [J] given until it stops. */
double givenBack(PassivityGuard* guard) {
  constexpr double kStep = 0.001;  // [m]
  double given = 0.0;
  for (int k = 0; k < 2000; ++k) {
    const double force = guard->gain() * (k % 2 == 0 ? 1.0 : -1.0);
    guard->given({force, 0.0, 0.0}, true);
    guard->observe({k % 2 == 0 ? kStep : 0.0, 0.0, 0.0});
    given += std::abs(force) * kStep;
  }
  return given;
}

TEST(PassivityGuard, AMinuteOfWorkTakenBuysNoMoreThanTheBank) {
  // GIVEN no delay and a hand without damping, so that every millijoule is the port's
  PassivityConfig config = withDelay(0.0);
  config.hand_damping = 0.0;
  for (const double bank : {0.02, 0.05}) {
    config.bank = bank;
    PassivityGuard guard(config);
    pushAgainst(&guard, 60000);  // 60 mm a half period, 60 of them: 3.6 J
    guard.given(Vector3d::Zero(), true);
    guard.observe(Vector3d::Zero());
    EXPECT_NEAR(guard.allowance() - guard.energy(), bank, 1e-12);
    const double given = givenBack(&guard);
    EXPECT_LE(given, bank + kRounding);
    EXPECT_GT(given, bank - 0.5 * config.budget) << "it may give what it has, but for the part over which it fades";
  }
  // without a limit all of it comes back: 2 J in these 2000 ticks, and the gain is still 1
  PassivityGuard boundless(withoutLimit(config));
  pushAgainst(&boundless, 60000);
  EXPECT_GT(givenBack(&boundless), 1.9);
}

TEST(PassivityGuard, AMinuteOfMotionBuysNoMoreThanTheBank) {
  // GIVEN a force that does nothing, and a hand at 0.1 m/s: 1 Ns/m takes 10 mW of it, 0.6 J
  PassivityGuard guard(withDelay(0.0));
  for (int k = 0; k < 60000; ++k) {
    guard.observe({1e-4 * std::abs(k % 1000 - 500), 0.0, 0.0});
    guard.given({0.0, 1.0, 0.0}, true);
    ASSERT_LE(guard.allowance() - guard.energy(), kConfig.bank + kRounding) << k;
    ASSERT_EQ(guard.gain(), 1.0) << k;
  }
  EXPECT_GT(guard.allowance(), 0.5);
}

TEST(PassivityGuard, WhatAForceHasStoredIsNotForgottenWhileItActs) {
  // GIVEN 2 N, a hand that pushes 50 mm against it within a second, holds for a minute and lets itself be pushed home:
  // 100 mJ, five times the bank, and all of them the hand's own
  PassivityGuard guard(kConfig);
  const auto at = [](int k) { return 0.05 * (k < 1000 ? 1e-3 * k : k < 61000 ? 1.0 : 1e-3 * (62000 - k)); };
  for (int k = 0; k <= 62000; ++k) {
    guard.observe({-at(k), 0.0, 0.0});
    guard.given({2.0, 0.0, 0.0}, true);
    ASSERT_EQ(guard.gain(), 1.0) << k;
  }
}

TEST(PassivityGuard, AtAnyTimeItGivesNoMoreThanTheBankAndWhatIsStored) {
  // GIVEN any forces and motions: from any tick on, until the allowance is used up, the work is at most the bank, what
  // the damping takes, and what the forces at both ends take back
  Random random(8);
  for (int run = 0; run < 20; ++run) {
    const Wander wander(&random);
    PassivityGuard guard(withDelay(0.0));
    Vector3d force = Vector3d::Zero(), before = wander.at(0.0);
    const Vector3d anchor = before;
    double work = 0.0, least = 1e9;  // [J] least: of work - allowance - what was stored, so far
    for (int k = 0; k < 5000; ++k) {
      const Vector3d now = wander.at(1e-3 * k);
      guard.observe(now);
      work += force.dot(now - before);
      before = now;
      const double stored = force.dot(now - anchor);
      if (k > 0) {
        least = std::min(least, work - guard.allowance() - std::min(0.0, stored));
        // THEN M exceeds the allowance as soon as there was an earlier tick since when more than that was given
        const double beyond = work - guard.allowance() - least - kConfig.bank - std::max(0.0, stored);
        ASSERT_GE(guard.energy() - guard.allowance(), beyond - kRounding) << "run " << run << ", tick " << k;
      }
      if (random.next() % 50 == 0) force = anyVector(&random, 2.0);
      guard.given(force, true);
    }
  }
}

TEST(PassivityGuard, FadesTheForceOverTheSecondHalfOfItsBudget) {
  PassivityConfig config = withDelay(0.0);
  config.hand_damping = 0.0;
  PassivityGuard guard(config);
  // 1 N over 1 mm, taken away and brought back with the hand where it began: 1 mJ a time
  double work = 0.0;
  for (int cycle = 0; cycle < 30; ++cycle) {
    guard.observe({0.0, 0.0, 0.0});
    guard.given({1.0, 0.0, 0.0}, true);
    guard.observe({0.001, 0.0, 0.0});
    guard.given({0.0, 1e-9, 0.0}, true);  // practically zero
    guard.observe({0.001, 0.0, 0.0});
    work += 0.001;
    const double expected = std::clamp((config.budget - work) / (0.5 * config.budget), 0.0, 1.0);
    ASSERT_NEAR(guard.energy(), work, 1e-9);
    ASSERT_NEAR(guard.gain(), expected, 1e-6) << cycle;
    // the yielding force fades over the quarter before that
    const double yielding = std::clamp((0.5 * config.budget - work) / (0.25 * config.budget), 0.0, 1.0);
    ASSERT_NEAR(guard.yieldingGain(), work <= 0.25 * config.budget ? 1.0 : yielding, 1e-6) << cycle;
  }
}

TEST(PassivityGuard, StartsAnewAfterARestAndNotBefore) {
  PassivityGuard guard(kConfig);
  for (int k = 0; k < 200; ++k) {
    guard.observe({1e-3 * (k % 2), 0.0, 0.0});
    guard.given({k % 2 == 0 ? 1.0 : -1.0, 0.0, 0.0}, true);  // 1 N over every millimetre
  }
  ASSERT_EQ(guard.gain(), 0.0);
  constexpr int kRest = 121 + 500;  // every force that may still be under way, and 0.5 s
  for (int k = 1; k < kRest; ++k) {
    guard.observe({0.0, 0.0, 0.0});
    guard.given(Vector3d::Zero(), false);
    ASSERT_EQ(guard.gain(), 0.0) << k;
  }
  ASSERT_FALSE(guard.isResting());
  guard.given(Vector3d::Zero(), false);
  EXPECT_TRUE(guard.isResting());
  EXPECT_EQ(guard.gain(), 1.0);
  EXPECT_EQ(guard.energy(), 0.0);
  EXPECT_EQ(guard.allowance(), kConfig.budget);
}

TEST(PassivityGuard, AfterARestItIsAsOneThatNeverGaveAForce) {
  // GIVEN a guard with forces of every delay, a begun block of motion and an energy, that rests at a tick of any number
  for (const int used_ticks : {3, 150, 407}) {
    Random random(9);
    const Wander wander(&random);
    PassivityGuard used(kConfig), fresh(kConfig);
    for (int k = 0; k < used_ticks; ++k) {
      used.observe(wander.at(1e-3 * k));
      used.given(anyVector(&random, 3.0), true);
    }
    int ticks = used_ticks;
    for (; !used.isResting(); ++ticks) {
      used.observe(wander.at(1e-3 * ticks));
      used.given(Vector3d::Zero(), false);
    }
    EXPECT_EQ(ticks - used_ticks, 121 + 500);
    // WHEN forces begin again, THEN the two differ in nothing
    for (int k = 0; k < 400; ++k) {
      const Vector3d x = wander.at(1e-3 * (ticks + k)), force = anyVector(&random, 1.0);
      for (PassivityGuard* guard : {&used, &fresh}) {
        guard->observe(x);
        guard->given(force, true);
      }
      ASSERT_EQ(used.energy(), fresh.energy()) << used_ticks << ", tick " << k;
      ASSERT_EQ(used.allowance(), fresh.allowance()) << used_ticks << ", tick " << k;
    }
    for (int k = 0; k < 121 + 499; ++k) {  // and the next rest is as long
      for (PassivityGuard* guard : {&used, &fresh})
        guard->given(Vector3d::Zero(), false);
      ASSERT_FALSE(used.isResting() || fresh.isResting()) << k;
    }
  }
}

TEST(PassivityGuard, StartedAnewWhileForcesActItForgetsThem) {
  Random random(10);
  const Wander wander(&random);
  PassivityGuard used(kConfig), fresh(kConfig);
  for (int k = 0; k < 150; ++k) {
    used.observe(wander.at(1e-3 * k));
    used.given(anyVector(&random, 3.0), true);
  }
  used.startAgain();
  EXPECT_TRUE(used.isResting());
  for (int k = 150; k < 500; ++k) {
    const Vector3d x = wander.at(1e-3 * k), force = anyVector(&random, 1.0);
    for (PassivityGuard* guard : {&used, &fresh}) {
      guard->observe(x);
      guard->given(force, true);
    }
    ASSERT_EQ(used.energy(), fresh.energy()) << k;
    ASSERT_EQ(used.allowance(), fresh.allowance()) << k;
  }
}

TEST(PassivityGuard, ForcesBeginTheirAccountWhereTheHandIs) {
  // GIVEN a hand that went 0.5 m before the first force THEN this counts neither as motion nor as a place to return to
  PassivityGuard guard(withDelay(0.0));
  for (int k = 0; k <= 5; ++k) {
    guard.observe({0.1 * k, 0.0, 0.0});
    guard.given(Vector3d::Zero(), false);
  }
  guard.given({1.0, 0.0, 0.0}, true);
  for (int k = 1; k <= 16; ++k) {
    guard.observe({0.5 - 1e-4 * k, 0.0, 0.0});
    guard.given({1.0, 0.0, 0.0}, true);
    EXPECT_NEAR(guard.energy(), -1e-4 * k, 1e-12) << "taken from the hand";
  }
  EXPECT_NEAR(guard.allowance() - kConfig.budget, 1.6e-3 * 1.6e-3 / 0.016, 1e-12) << "by 1 Ns/m in 16 ms";
}

TEST(PassivityGuard, DoesNotStartAnewWhileTheLawStillAsks) {
  PassivityGuard guard(kConfig);
  for (int k = 0; k < 200; ++k) {
    guard.observe({1e-3 * (k % 2), 0.0, 0.0});
    guard.given({k % 2 == 0 ? 1.0 : -1.0, 0.0, 0.0}, true);
  }
  for (int k = 0; k < 5000; ++k) {
    guard.observe({0.0, 0.0, 0.0});
    guard.given(Vector3d::Zero(), true);  // the force is zero, but the law asked for one
    ASSERT_EQ(guard.gain(), 0.0) << k;
  }
}

TEST(PassivityGuard, SwitchedOffItSeesTheSameAndDoesNothing) {
  PassivityConfig off = kConfig;
  off.enabled = false;
  PassivityGuard guard(kConfig), observer(off);
  Random random(6);
  for (int k = 0; k < 2000; ++k) {
    const Vector3d x = 1e-4 * Vector3d(k % 20, 0.0, 0.0) + anyVector(&random, 1e-5);
    const Vector3d force = (k + 1) % 20 == 0 ? Vector3d(Vector3d::Zero()) : Vector3d(1.0, 0.0, 0.0);
    for (PassivityGuard* each : {&guard, &observer}) {
      each->observe(x);
      each->given(force, true);
    }
    ASSERT_EQ(guard.energy(), observer.energy());
    ASSERT_EQ(observer.gain(), 1.0);
    ASSERT_EQ(observer.yieldingGain(), 1.0);
  }
  EXPECT_EQ(guard.gain(), 0.0) << "the motion must use up the budget";
}

TEST(PassivityGuard, WhatIsNotFiniteIsNoMotion) {
  const double nan = std::nan(""), inf = std::numeric_limits<double>::infinity();
  PassivityGuard guard(kConfig);
  guard.observe({0.0, 0.0, 0.0});
  guard.given({1.0, 0.0, 0.0}, true);
  for (const double bad : {nan, inf, -inf, 1e300}) {
    guard.observe({bad, 0.0, 0.0});
    guard.given({1.0, 0.0, 0.0}, true);
    ASSERT_TRUE(std::isfinite(guard.energy()));
    ASSERT_EQ(guard.gain(), 1.0);
  }
}

TEST(PassivityGuard, ForgottenInTheMidstOfARestItTakesAWholeOne) {
  PassivityGuard guard(kConfig);
  guard.observe({0.0, 0.0, 0.0});
  const auto ticksToRest = [&guard](int most) {
    int ticks = 0;
    for (; ticks < most && !guard.isResting(); ++ticks)
      guard.given({0.0, 0.0, 0.0}, false);
    return ticks;
  };
  guard.given({1.0, 0.0, 0.0}, true);
  const int whole = ticksToRest(10'000);
  EXPECT_EQ(whole, 121 + 500);  // the delays of 0 to 0.12 s, and 0.5 s
  guard.given({1.0, 0.0, 0.0}, true);
  ASSERT_EQ(ticksToRest(400), 400);
  guard.forget();
  EXPECT_EQ(ticksToRest(10'000), whole);
}

TEST(PassivityGuard, ForgottenItIsKnownAgainAfterARest) {
  // GIVEN two guards of which one missed a force
  PassivityGuard whole(kConfig), other(kConfig);
  whole.observe({0.0, 0.0, 0.0});
  whole.given({2.0, 0.0, 0.0}, true);
  other.forget();
  Random random(7);
  int rested = 0;
  for (int k = 0; k < 3000; ++k) {
    const Vector3d x = anyVector(&random, 0.01);
    const Vector3d force = k > 100 && k < 900 ? Vector3d(Vector3d::Zero()) : anyVector(&random, 1.0);
    whole.observe(x);
    other.observe(x);
    if (other.isResting()) ++rested;
    if (rested > 0) {
      ASSERT_EQ(whole.energy(), other.energy()) << k;
      ASSERT_EQ(whole.gain(), other.gain()) << k;
    }
    const bool is_asked = force != Vector3d::Zero();
    whole.given(force, is_asked);
    other.given(force, is_asked);
  }
  EXPECT_GT(rested, 0);
}

TEST(PassivityGuard, WatchesEachDelayUpToTheLongestOneAllowedAndNoLonger) {
  // GIVEN 1 N for one tick, and a hand that moves by 1 mm along it so many ticks later, and stays there: 1 mJ is given
  for (const int ticks : {0, 1, 200, 201, 399, 400, 401}) {
    PassivityGuard guard(withDelay(0.4));
    guard.observe({0.0, 0.0, 0.0});
    guard.given({1.0, 0.0, 0.0}, true);
    for (int k = 0; k < ticks; ++k) {
      guard.observe({0.0, 0.0, 0.0});
      guard.given(Vector3d::Zero(), true);
    }
    guard.observe({0.001, 0.0, 0.0});
    guard.given(Vector3d::Zero(), true);
    guard.observe({0.001, 0.0, 0.0});  // now the force of this delay is zero, which takes nothing back
    EXPECT_NEAR(guard.energy(), ticks <= 400 ? 0.001 : 0.0, 1e-12) << ticks;
  }
}

TEST(PassivityGuard, CountsTheMotionAcrossANumberThatIsNone) {
  const double nan = std::nan(""), inf = std::numeric_limits<double>::infinity();
  PassivityGuard guard(withDelay(0.0));
  guard.observe({0.0, 0.0, 0.0});
  guard.given({1.0, 0.0, 0.0}, true);
  int steps = 0;
  for (const double bad : {nan, inf, -inf}) {
    guard.observe({bad, 0.0, 0.0});
    guard.given({1.0, 0.0, 0.0}, true);
    guard.observe({-0.001 * ++steps, 0.0, 0.0});
    guard.given({1.0, 0.0, 0.0}, true);
    EXPECT_NEAR(guard.energy(), -0.001 * steps, 1e-12) << "1 N over a millimetre each, taken from the hand";
  }
}

TEST(Shortened, KeepsDirectionAndFloor) {
  const Vector3d force(0.3, -0.4, 1.2);  // 1.3 N
  EXPECT_EQ(shortened(force, 1.0, 0.05), force);
  EXPECT_NEAR((shortened(force, 0.5, 0.05) - 0.5 * force).norm(), 0.0, 1e-15);
  EXPECT_NEAR(shortened(force, 0.0, 0.05).norm(), 0.05, 1e-15);
  EXPECT_NEAR(shortened(force, 0.0, 0.05).cross(force).norm(), 0.0, 1e-15);
  EXPECT_EQ(shortened(force, 0.0, 0.0), Vector3d::Zero());
  EXPECT_EQ(shortened(0.01 * force, 0.0, 0.05), 0.01 * force) << "never longer than it was";
  EXPECT_EQ(shortened(Vector3d::Zero(), 0.3, 0.05), Vector3d::Zero()) << "nothing is made of nothing";
}

}  // namespace
}  // namespace raven2_trainer::haptics
