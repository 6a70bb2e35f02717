#include <gtest/gtest.h>

#include "support/allocation_counter.h"
#include "support/rig.h"

#ifdef RAVEN2_COUNTS_ALLOCATIONS

namespace raven2_trainer::runtime {
namespace {

using raven2_trainer::testing::allocatorCalls;

TEST(LoopsAlloc, TicksOfDaemonAndVirtualRavenDoNotTouchTheHeap) {
  // GIVEN the whole chain from the master's datagram to the force, warm, teleoperating, a fault armed and acting
  raven2_trainer::testing::useOde();
  TrainerConfig config = raven2_trainer::testing::packagedConfig();
  config.hazard = "sudden_jump";
  config.scenarios[0].fault.first_tick = 2000;
  raven2_trainer::testing::Rig rig(config);
  ASSERT_TRUE(rig.home());
  for (int i = 0; i < 1500; ++i)
    rig.tick(true, {10e-6, 0.0, 0.0});
  // THEN 2000 further ticks, 300 of them faulty, allocate nothing
  bool faulty = false;
  EXPECT_EQ(allocatorCalls([&] {
              for (int i = 0; i < 2000; ++i) {
                rig.tick(true, {i % 2 == 0 ? 10e-6 : -10e-6, 0.0, 0.0});
                faulty = faulty || rig.robot().active_fault != 0;
              }
            }),
            0);
  EXPECT_TRUE(faulty) << "no fault acted: the test showed less than it says";
}

}  // namespace
}  // namespace raven2_trainer::runtime

#endif
