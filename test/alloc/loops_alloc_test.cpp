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

TEST(LoopsAlloc, ClutchingPressingOnTheSceneAndRequestsDoNotTouchTheHeap) {
  raven2_trainer::testing::useOde();
  TrainerConfig config = raven2_trainer::testing::packagedConfig();
  config.hazard = "none";
  config.runtime.plan_at = -1.0;
  raven2_trainer::testing::Rig rig(config);
  ASSERT_TRUE(rig.home());
  std::uint32_t contacts = 0;
  const auto press = [&] {
    for (int i = 0; i < 1500; ++i) {
      rig.tick(i % 300 >= 60, {0.0, 0.0, 50e-6});  // down, with a clutch now and then
      contacts += rig.model().arms[0].contacts;
    }
    Request request;
    request.kind = RequestKind::kSetCollisions;
    request.enabled = 0;
    rig.shared->requests.tryPush(request);
    for (int i = 0; i < 100; ++i)
      rig.tick(true);
    request.enabled = 1;
    rig.shared->requests.tryPush(request);
  };
  press();  // warm
  contacts = 0;
  EXPECT_EQ(allocatorCalls(press), 0);
  EXPECT_GT(contacts, 0u) << "nothing was pressed on: the test showed less than it says";
}

}  // namespace
}  // namespace raven2_trainer::runtime

#endif
