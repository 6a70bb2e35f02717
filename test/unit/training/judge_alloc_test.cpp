#include <gtest/gtest.h>

#include "judge_support.h"
#include "raven2_trainer/core/random.h"
#include "support/allocation_counter.h"

#ifdef RAVEN2_COUNTS_ALLOCATIONS

namespace raven2_trainer::training::testing {
namespace {

TEST(JudgeAlloc, AMinuteOfAttemptsTouchesNoHeapAndNoLock) {
  WatchRule drop = rule(Mistake::kDrop);
  drop.grace = 0.05;
  Exercise exercise = Bench::with(
      {track({step({held(Hand::kGold)}), step({when(PredicateKind::kAlong, kRingObject, 0, Hand::kAny, 0.5)}),
              step({around(kPegA), when(PredicateKind::kUntouched), when(PredicateKind::kResting)}, 0.05)})},
      {touchRule(Mistake::kWireTouch, {"grasper1_L", "ring"}, {"wire"}, 0.05, 0.1), drop, rule(Mistake::kOutOfOrder),
       rule(Mistake::kWrongArm), rule(Mistake::kBreakOff)});
  Bench bench(exercise);
  Random random(3);
  int calls = 0, locks = 0, held_ticks = 0;
  bench.tick();
  for (int i = 0; i < 60000; ++i) {
    if (i % 200 == 0) bench.clearContacts();
    if (i % 200 == 50) bench.grip(i % 400 < 200 ? Arm::kGold : Arm::kGreen);
    if (i % 200 == 60) bench.touch(kJaw1L, kWire, random.uniform(0.0, 0.2));
    if (i % 3000 == 0) bench.put(kRingSlot, {i % 6000 == 0 ? 0.03 : 0.4, 0.0, 0.002});  // the search for reach runs too
    if (i % 20000 == 0) bench.judge->start();
    ++bench.model.tick;
    calls +=
        raven2_trainer::testing::allocatorCalls([&] { bench.judge->tick(bench.model, bench.contacts, bench.broken); });
    locks += raven2_trainer::testing::mutexLocks();
    held_ticks += bench.state().bodies[kRingSlot] != 0 ? 1 : 0;
  }
  EXPECT_EQ(calls, 0);
  EXPECT_EQ(locks, 0);
  EXPECT_GT(held_ticks, 1000);
}

}  // namespace
}  // namespace raven2_trainer::training::testing

#endif
