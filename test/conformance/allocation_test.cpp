#include <gtest/gtest.h>

#include "conformance/robot.h"
#include "support/allocation_counter.h"

namespace raven2_trainer::conformance {
namespace {

#ifdef RAVEN2_COUNTS_ALLOCATIONS
using raven2_trainer::testing::allocatorCalls;

TEST(Allocation, NoneInHomingTeleoperationRefusalOrNaN) {
  VirtualRavenConfig config = packaged().virtual_raven;
  config.full_homing = true;
  Robot homing(config, false);
  Robot engaged;
  engaged.engage();
  const int calls = allocatorCalls([&] {
    for (int k = 0; k < 6000; ++k) {
      homing.cycle();
      wire::ItpPacket p = engaged.packet();
      p.delx_um[0] = k < 2000 ? 5 : 0;
      p.delz_um[1] = k == 2500 ? 60000 : 0;
      if (k == 4000) p.Qw[0] = 0.0;
      engaged.send(p);
      engaged.cycle();
    }
  });
  EXPECT_EQ(calls, 0);
  EXPECT_EQ(engaged.level(), RunLevel::kPedalDown);
}

TEST(Allocation, NoneWithTheDetectorOnGuard) {
  DetectorConfig detector = packaged().detector;
  detector.mitigate = Mitigation::kHold;
  Robot robot;
  robot.software.setDetector(detector);
  robot.engage();
  const int calls = allocatorCalls([&] {
    for (int k = 0; k < 2000; ++k) {
      wire::ItpPacket p = robot.packet();
      p.delx_um[0] = k > 1000 && k < 1005 ? 2000 : 5;
      robot.send(p);
      robot.cycle();
    }
  });
  EXPECT_EQ(calls, 0);
  EXPECT_GE(robot.software.detectorReport().alarms, 1U) << "no alarm in the counted cycles";
}
#endif

}  // namespace
}  // namespace raven2_trainer::conformance
