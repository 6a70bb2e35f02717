#include "raven2_trainer/campaign/outcome.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <string>

namespace raven2_trainer::campaign {
namespace {

// As shipped: config/campaigns/safecomp15.yaml.
constexpr Limits kLimits{/*masked=*/0.0001, /*jump=*/0.001, /*still=*/0.001, /*moved=*/0.003, /*force=*/0.05};
constexpr int kTicks = 400;
constexpr int kInjection = 100;  // first faulty tick

/** Both tips go 20 mm/s along x. */
Sample goldenAt(int tick) {
  Sample sample;
  sample.p_BT = {Vec3{2e-5 * tick, 0.1, 0.2}, Vec3{2e-5 * tick, -0.1, 0.2}};
  sample.plc = sample.software = RunLevel::kPedalDown;
  return sample;
}

/** A faulty run is the golden one with a change from the injection on. @param[in] change gets ticks since then. */
using Change = std::function<void(int since, Sample* sample)>;

Figures compare(const Change& change) {
  Comparison comparison(kLimits);
  for (int tick = 0; tick < kTicks; ++tick) {
    Sample faulty = goldenAt(tick);
    if (tick >= kInjection) {
      faulty.faulted = 1;
      change(tick - kInjection, &faulty);
    }
    comparison.add(goldenAt(tick), faulty);
  }
  return comparison.figures();
}

Outcome outcomeOf(const Change& change) {
  return classify(Ending::kComplete, compare(change), kLimits);
}

void nothing(int, Sample*) {}

TEST(Comparison, ARunThatIsItsGoldenOneIsMasked) {
  const Figures figures = compare(nothing);
  EXPECT_EQ(figures.injected, kInjection);
  EXPECT_EQ(maxDeviation(figures), 0.0);
  EXPECT_EQ(figures.max_jump, 0.0);
  EXPECT_NEAR(figures.golden_motion[0], 2e-5 * (kTicks - kInjection), 1e-12) << "from the tick before the fault";
  EXPECT_EQ(classify(Ending::kComplete, figures, kLimits), Outcome::kMasked);
}

TEST(Comparison, AFaultThatNeverActedLeavesNoFigures) {
  Comparison comparison(kLimits);
  for (int tick = 0; tick < kTicks; ++tick)
    comparison.add(goldenAt(tick), goldenAt(tick));
  EXPECT_EQ(comparison.figures().injected, kNever);
  EXPECT_EQ(classify(Ending::kComplete, comparison.figures(), kLimits), Outcome::kMasked);
}

TEST(Classify, ADeviationIsSmallFromJustOverTheMaskedOne) {
  const auto shifted = [](double by) {
    return outcomeOf([by](int since, Sample* s) { s->p_BT[1][2] += std::min(1e-5 * since, by); });
  };
  EXPECT_EQ(shifted(0.999e-4), Outcome::kMasked);
  EXPECT_EQ(shifted(1.001e-4), Outcome::kSlowDeviation);
  EXPECT_EQ(shifted(0.02), Outcome::kSlowDeviation) << "far, but never fast: 10 mm/s against the golden run";
}

TEST(Classify, AJumpIsMoreThanOneMillimetreInTwoTicks) {
  const auto stepped = [](double first, double second) {
    return outcomeOf([=](int since, Sample* s) { s->p_BT[0][1] += since == 0 ? 0.0 : since == 1 ? first : second; });
  };
  EXPECT_EQ(stepped(0.0011, 0.0011), Outcome::kUnsafeJump) << "in one tick";
  EXPECT_EQ(stepped(0.0006, 0.0011), Outcome::kUnsafeJump) << "in two";
  EXPECT_EQ(stepped(0.0005, 0.00099), Outcome::kSlowDeviation);
}

TEST(Classify, AsManyMillimetresInThreeTicksAreNoJump) {
  EXPECT_EQ(outcomeOf([](int since, Sample* s) { s->p_BT[0][1] += 0.0004 * std::min(since, 3); }),
            Outcome::kSlowDeviation);
}

TEST(Comparison, TheJumpIsTimedFromTheInjection) {
  const Figures figures = compare([](int since, Sample* s) { s->p_BT[0][1] += since >= 7 ? 0.002 : 0.0; });
  EXPECT_EQ(figures.jumped, 7);
  EXPECT_NEAR(figures.max_jump, 0.002, 1e-12);
  EXPECT_NEAR(figures.deviation[0], 0.002, 1e-12);
  EXPECT_EQ(figures.deviation[1], 0.0);
}

TEST(Classify, AJumpOfTheGoldenRunItselfIsNone) {
  Comparison comparison(kLimits);
  for (int tick = 0; tick < kTicks; ++tick) {
    Sample sample = goldenAt(tick);
    sample.p_BT[0][0] += tick > 200 ? 0.005 : 0.0;
    Sample faulty = sample;
    faulty.faulted = 1;
    comparison.add(sample, faulty);
  }
  EXPECT_EQ(classify(Ending::kComplete, comparison.figures(), kLimits), Outcome::kMasked);
}

/** Homing from power-on: both tips go 8 mm; from tick 200 on the robot is in PEDAL_DN and they go on. */
Sample homingAt(int tick) {
  Sample sample = goldenAt(tick);
  sample.plc = sample.software = tick < 200 ? RunLevel::kInit : RunLevel::kPedalDown;
  return sample;
}

Figures compareHoming(const Change& change) {
  Comparison comparison(kLimits);
  for (int tick = 0; tick < kTicks; ++tick) {
    Sample faulty = homingAt(tick);
    faulty.faulted = 1;
    change(tick, &faulty);
    comparison.add(homingAt(tick), faulty);
  }
  return comparison.figures();
}

TEST(Classify, ARobotThatHomesAndNeverStartsDidNotMove) {
  const auto homed = [](RunLevel plc, RunLevel software) {
    return compareHoming([=](int tick, Sample* s) {
      *s = homingAt(std::min(tick, 199));
      s->faulted = 1;
      s->plc = tick < 200 ? s->plc : plc;
      s->software = tick < 200 ? s->software : software;
    });
  };
  const auto outcome = [](const Figures& f) { return classify(Ending::kComplete, f, kLimits); };
  const Figures stuck = homed(RunLevel::kInit, RunLevel::kInit);
  EXPECT_EQ(stuck.started, 0);
  EXPECT_EQ(stuck.golden_started, 1);
  EXPECT_EQ(outcome(stuck), Outcome::kNoMotion) << "although its tips moved 4 mm each while homing";
  EXPECT_EQ(outcome(homed(RunLevel::kPedalUp, RunLevel::kPedalDown)), Outcome::kNoMotion) << "the PLC has the brakes";
  EXPECT_EQ(outcome(homed(RunLevel::kPedalDown, RunLevel::kPedalUp)), Outcome::kNoMotion);
  EXPECT_EQ(outcome(homed(RunLevel::kPedalDown, RunLevel::kPedalDown)), Outcome::kSlowDeviation) << "it started";
}

TEST(Classify, ARobotThatRunsAwayInsteadOfStartingMoved) {
  const Figures figures = compareHoming([](int tick, Sample* s) {
    s->p_BT[0][1] += 5e-5 * tick;
    s->plc = s->software = RunLevel::kInit;
  });
  EXPECT_EQ(figures.started, 0);
  EXPECT_EQ(classify(Ending::kComplete, figures, kLimits), Outcome::kSlowDeviation);
}

TEST(Classify, ARunThatEndsBeforeItsGoldenOneStartsIsNotHeldToIt) {
  Comparison comparison(kLimits);
  for (int tick = 0; tick < 150; ++tick) {
    Sample faulty = homingAt(tick);
    faulty.faulted = 1;
    comparison.add(homingAt(tick), faulty);
  }
  EXPECT_EQ(comparison.figures().golden_started, 0);
  EXPECT_EQ(classify(Ending::kComplete, comparison.figures(), kLimits), Outcome::kMasked);
}

TEST(Classify, AnArmThatStaysWhereItWasDidNotMove) {
  const Vec3 where = goldenAt(kInjection - 1).p_BT[0];
  EXPECT_EQ(outcomeOf([&](int, Sample* s) { s->p_BT[0] = where; }), Outcome::kNoMotion) << "one arm is enough";
  const auto coasting = [&](double metres) {
    return outcomeOf([=](int since, Sample* s) {
      s->p_BT[0] = where;
      s->p_BT[0][0] += std::min(2e-5 * since, metres);
    });
  };
  EXPECT_EQ(coasting(0.00099), Outcome::kNoMotion);
  EXPECT_EQ(coasting(0.00101), Outcome::kSlowDeviation);
}

TEST(Classify, WhereOneArmStandsAndTheOtherGoesAstrayTheRobotMoved) {
  const Vec3 where = goldenAt(kInjection - 1).p_BT[0];
  const auto astray = [&](double metres) {
    return outcomeOf([=](int since, Sample* s) {
      s->p_BT[0] = where;
      s->p_BT[1][2] += std::min(1e-5 * since, metres);
    });
  };
  EXPECT_EQ(astray(0.99e-4), Outcome::kNoMotion);
  EXPECT_EQ(astray(1.01e-4), Outcome::kSlowDeviation);
}

TEST(Classify, AnArmThatHadLittleToDoMayStandToo) {
  Comparison comparison(kLimits);
  for (int tick = 0; tick < kTicks; ++tick) {
    Sample golden = goldenAt(tick), faulty = goldenAt(0);
    golden.p_BT[1] = goldenAt(tick / 10).p_BT[1];  // 0.8 mm, less than the 3 mm of `moved`
    faulty.faulted = 1;
    comparison.add(golden, faulty);
  }
  EXPECT_GT(comparison.figures().deviation[1], kLimits.masked);
  EXPECT_EQ(classify(Ending::kComplete, comparison.figures(), kLimits), Outcome::kNoMotion);
}

TEST(Classify, AnArmThatHadNowhereToGoIsNotOneThatDidNotMove) {
  Comparison comparison(kLimits);
  Sample resting = goldenAt(0);
  resting.faulted = 1;
  for (int tick = 0; tick < kTicks; ++tick)
    comparison.add(resting, resting);
  EXPECT_EQ(classify(Ending::kComplete, comparison.figures(), kLimits), Outcome::kMasked);
}

TEST(Classify, EitherStopIsAnEStop) {
  const Figures software = compare([](int since, Sample* s) { s->soft_estopped = since == 30 ? 1 : 0; });
  EXPECT_EQ(software.software_stop, 30);
  EXPECT_EQ(software.plc_stop, kNever);
  EXPECT_EQ(classify(Ending::kComplete, software, kLimits), Outcome::kEStop);
  const Figures plc = compare([](int since, Sample* s) { s->plc = since >= 50 ? RunLevel::kEStop : s->plc; });
  EXPECT_EQ(plc.plc_stop, 50);
  EXPECT_EQ(plc.software_stop, kNever);
  EXPECT_EQ(plc.reported, kNever) << "the control program still assumes PEDAL_DN";
  EXPECT_EQ(classify(Ending::kComplete, plc, kLimits), Outcome::kEStop);
}

TEST(Comparison, AStopIsReportedWhenTheProgramKnowsIt) {
  const Figures figures = compare([](int since, Sample* s) {
    s->software = since >= 53 || since == 10 ? RunLevel::kEStop : s->software;
    s->plc = since >= 50 ? RunLevel::kEStop : s->plc;
  });
  EXPECT_EQ(figures.reported, 53) << "an E-STOP that the program assumed before the stop is no report";
}

TEST(Classify, APlcThatWasNeverStartedIsNoStop) {
  Comparison comparison(kLimits);
  for (int tick = 0; tick < kTicks; ++tick) {
    Sample faulty = goldenAt(0);
    faulty.plc = faulty.software = RunLevel::kEStop;
    faulty.faulted = 1;
    comparison.add(goldenAt(tick), faulty);
  }
  EXPECT_EQ(comparison.figures().plc_stop, kNever);
  EXPECT_EQ(classify(Ending::kComplete, comparison.figures(), kLimits), Outcome::kNoMotion);
}

TEST(Classify, AProgramThatEndedIsACrashAndOneThatStandsAHang) {
  const auto program = [](ProgramState state) {
    return compare([state](int, Sample* s) {
      s->faulted = 0;  // the program reports no fault any more
      s->program = state;
      s->plc = RunLevel::kEStop;
      s->p_BT[0][1] += 0.1;
    });
  };
  EXPECT_EQ(program(ProgramState::kCrashed).injected, kInjection);
  EXPECT_EQ(classify(Ending::kComplete, program(ProgramState::kCrashed), kLimits), Outcome::kCrash);
  EXPECT_EQ(classify(Ending::kComplete, program(ProgramState::kHung), kLimits), Outcome::kHang);
}

TEST(Classify, AProcessThatDiedOrUsedUpItsTimeNeedsNoFigures) {
  EXPECT_EQ(classify(Ending::kDied, Figures{}, kLimits), Outcome::kCrash);
  EXPECT_EQ(classify(Ending::kBudget, Figures{}, kLimits), Outcome::kHang);
  EXPECT_EQ(classify(Ending::kMemory, Figures{}, kLimits), Outcome::kCrash);
  EXPECT_EQ(classify(Ending::kNoEnd, Figures{}, kLimits), Outcome::kNone) << "the machine's speed decided";
}

TEST(Classify, TheGraverOutcomeCounts) {
  const auto stop = [](Sample* s) { s->soft_estopped = 1; };
  EXPECT_EQ(outcomeOf([&](int, Sample* s) { stop(s), s->p_BT[0][1] += 0.01; }), Outcome::kUnsafeJump);
  const Vec3 where = goldenAt(kInjection - 1).p_BT[0];
  EXPECT_EQ(outcomeOf([&](int, Sample* s) { stop(s), s->p_BT[0] = where; }), Outcome::kEStop);
}

TEST(Classify, ATipThatIsNoNumberIsNotMasked) {
  const Figures figures = compare([](int since, Sample* s) {
    if (since > 5) s->p_BT[0][0] = std::numeric_limits<double>::quiet_NaN();
  });
  EXPECT_EQ(figures.is_finite, 0);
  EXPECT_EQ(classify(Ending::kComplete, figures, kLimits), Outcome::kUnsafeJump);
}

TEST(Comparison, AForceCountsWhereTheGoldenRunHasNone) {
  Comparison comparison(kLimits);
  for (int tick = 0; tick < kTicks; ++tick) {
    Sample golden = goldenAt(tick), faulty = goldenAt(tick);
    faulty.faulted = 1;
    faulty.force[1] = tick >= 10 ? 1.5 : 0.0;
    golden.force[1] = tick < 20 ? 0.8 : 0.0;
    comparison.add(golden, faulty);
  }
  EXPECT_EQ(comparison.figures().force, 20);
  EXPECT_EQ(comparison.figures().max_force, 1.5);
}

// ---- either arm --------------------------------------------------------------------------------------------------

/** Both tips are judged alike, along every axis and in both directions. */
class EitherTip : public ::testing::TestWithParam<std::size_t> {
 protected:
  std::size_t arm() const { return GetParam(); }
  std::size_t other() const { return 1 - GetParam(); }

  /** Each tip of the golden run moves some part of goldenAt()'s motion; `change` makes it the faulty run. */
  Outcome outcomeWith(double own_part, double others_part, const Change& change) const {
    Comparison comparison(kLimits);
    for (int tick = 0; tick < kTicks; ++tick) {
      Sample golden = goldenAt(0);
      golden.p_BT[arm()][0] += own_part * 2e-5 * tick;
      golden.p_BT[other()][0] += others_part * 2e-5 * tick;
      Sample faulty = golden;
      faulty.faulted = 1;
      change(tick, &faulty);
      comparison.add(golden, faulty);
    }
    return classify(Ending::kComplete, comparison.figures(), kLimits);
  }
};

TEST_P(EitherTip, JumpsAlongAnyAxisInEitherDirection) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const double jump : {-0.0011, 0.0011}) {
      const Figures figures = compare([&](int since, Sample* s) { s->p_BT[arm()][axis] += since >= 1 ? jump : 0.0; });
      EXPECT_EQ(figures.jumped, 1) << axis;
      EXPECT_NEAR(figures.max_jump, 0.0011, 1e-12) << axis;
      EXPECT_NEAR(figures.deviation[arm()], 0.0011, 1e-12) << axis;
      EXPECT_EQ(figures.deviation[other()], 0.0) << axis;
      EXPECT_EQ(classify(Ending::kComplete, figures, kLimits), Outcome::kUnsafeJump) << axis;
    }
  }
}

TEST_P(EitherTip, IsNoNumberIfOneOfItsThreeIsNone) {
  constexpr double kInf = std::numeric_limits<double>::infinity();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const double none : {std::numeric_limits<double>::quiet_NaN(), kInf, -kInf}) {
      const Figures figures = compare([&](int since, Sample* s) {
        if (since > 5) s->p_BT[arm()][axis] = none;
      });
      EXPECT_EQ(figures.is_finite, 0) << axis << " " << none;
      EXPECT_EQ(classify(Ending::kComplete, figures, kLimits), Outcome::kUnsafeJump) << axis << " " << none;
    }
  }
}

TEST_P(EitherTip, ThatRunsAwayInsteadOfStartingMoved) {
  const Figures figures = compareHoming([&](int tick, Sample* s) {
    s->p_BT[arm()][1] += 5e-5 * tick;
    s->plc = s->software = RunLevel::kInit;
  });
  EXPECT_EQ(figures.started, 0);
  EXPECT_EQ(classify(Ending::kComplete, figures, kLimits), Outcome::kSlowDeviation);
}

TEST_P(EitherTip, ThatStaysIsNoMotionIfItsOwnGoldenOneWentFar) {
  const auto stays = [&](int, Sample* s) { s->p_BT[arm()] = goldenAt(0).p_BT[arm()]; };
  EXPECT_EQ(outcomeWith(1.0, 0.0, stays), Outcome::kNoMotion) << "8 mm, the other one rests";
  EXPECT_EQ(outcomeWith(0.3, 1.0, stays), Outcome::kSlowDeviation) << "2.4 mm is less than the 3 of `moved`";
}

TEST_P(EitherTip, ThatStaysIsNoMotionOnlyWhileTheOtherIsWithItsGoldenOne) {
  const auto astray = [&](double metres) {
    return [this, metres](int tick, Sample* s) {
      s->p_BT[arm()] = goldenAt(0).p_BT[arm()];
      s->p_BT[other()][2] -= std::min(1e-5 * tick, metres);
    };
  };
  EXPECT_EQ(outcomeWith(1.0, 1.0, astray(0.99e-4)), Outcome::kNoMotion);
  EXPECT_EQ(outcomeWith(1.0, 1.0, astray(1.01e-4)), Outcome::kSlowDeviation);
}

TEST_P(EitherTip, HasAForceOfItsOwnGoldenOneToCompareWith) {
  Comparison comparison(kLimits);
  for (int tick = 0; tick < kTicks; ++tick) {
    Sample golden = goldenAt(tick), faulty = goldenAt(tick);
    faulty.faulted = 1;
    faulty.force[arm()] = tick >= 10 ? 1.5 : 0.0;
    golden.force[arm()] = tick < 20 ? 0.8 : 0.0;
    golden.force[other()] = 0.8;
    comparison.add(golden, faulty);
  }
  EXPECT_EQ(comparison.figures().force, 20);
  EXPECT_EQ(comparison.figures().max_force, 1.5);
}

INSTANTIATE_TEST_SUITE_P(Arms, EitherTip, ::testing::Range<std::size_t>(0, kArmCount), [](const auto& tested) {
  return std::string(kArmNames[tested.param]);
});

TEST(Comparison, AProgramThatEndedReportsNoStop) {
  for (const ProgramState state : {ProgramState::kHung, ProgramState::kCrashed}) {
    const Figures figures = compare([state](int since, Sample* s) {
      if (since < 50) return;
      s->plc = s->software = RunLevel::kEStop;
      s->program = state;
    });
    EXPECT_EQ(figures.plc_stop, 50);
    EXPECT_EQ(figures.reported, kNever) << "no program is left to report the stop";
  }
}

}  // namespace
}  // namespace raven2_trainer::campaign
