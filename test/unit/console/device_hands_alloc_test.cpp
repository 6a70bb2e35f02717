#include <gtest/gtest.h>

#include <cmath>

#include "console_support.h"
#include "device_bench.h"
#include "support/allocation_counter.h"

#ifdef RAVEN2_COUNTS_ALLOCATIONS

namespace raven2_trainer::console {
namespace {

TEST(DeviceHandsAlloc, EngagedRefusedAndSilentTheyTouchNoHeapAndNoLock) {
  MasterConfig config = testMaster();
  config.orientation = true;
  config.gripper_from = GripperFrom::kToggles;
  DeviceBench bench(config);
  ConsoleConfig at_once = testConfig();
  at_once.start_delay = 0.0;
  Console console(at_once, std::move(bench.source));
  console.setReady(true);
  int calls = 0, locks = 0, engaged = 0;
  for (int i = 0; i < 20000; ++i) {
    DeviceSample& left = bench.samples[0];
    if (i % 3000 < 2800) ++left.poses;  // silent at times
    ++bench.samples[1].poses;
    left.position[0] = 0.02 * std::sin(0.01 * i) + (i % 5000 == 4000 ? 0.1 : 0.0);
    bench.samples[1].position[1] = 0.001 * std::sin(0.02 * i);
    left.buttons = i % 700 < 500 ? 1 : 0;
    bench.samples[1].buttons = i % 90 < 45 ? 2 : 0;
    for (const Arm arm : kArms)
      at(bench.link.samples, arm).store(at(bench.samples, arm));
    wire::ItpPacket packet;
    calls += raven2_trainer::testing::allocatorCalls([&] { packet = console.tick(); });
    locks += raven2_trainer::testing::mutexLocks();
    engaged += packet.surgeon_mode;
  }
  EXPECT_EQ(calls, 0);
  EXPECT_EQ(locks, 0);
  EXPECT_GT(engaged, 5000);
  EXPECT_GT(bench.report().found[0], 5U);
}

}  // namespace
}  // namespace raven2_trainer::console

#endif
