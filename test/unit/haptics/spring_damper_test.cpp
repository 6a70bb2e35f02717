#include "raven2_trainer/haptics/spring_damper.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace raven2_trainer::haptics {
namespace {

using Eigen::Vector3d;

// tolerance: 3 mm (paper, 3.2); least force: the 0.05 of eq. (5)
constexpr HapticGains kGains{/*kp=*/100.0, /*kd=*/1.0, /*tolerance=*/0.003, /*min_force=*/0.05, /*max_force=*/3.0};

TEST(SpringDamper, IsSilentUpToTheTolerance) {
  // GIVEN a fast but small deviation, THEN no force, whatever the velocity
  EXPECT_EQ(springDamper(kGains, {0.0029, 0, 0}, {0, 0, 0}, {1, 0, 0}, {0, 0, 0}), Vector3d::Zero());
  EXPECT_EQ(springDamper(kGains, {0.003, 0, 0}, {0, 0, 0}, {1, 0, 0}, {0, 0, 0}), Vector3d::Zero());
}

TEST(SpringDamper, FollowsEquationFiveJustOutside) {
  const Vector3d force = springDamper(kGains, {0.0031, 0, 0}, {0, 0, 0}, {0.2, 0, 0}, {0, 0.1, 0});
  EXPECT_NEAR(force.norm(), 100 * 0.0031 + std::hypot(0.2, 0.1), 1e-12);
}

TEST(SpringDamper, IsThePapersSumAndDirection) {
  // e = (2, -3, 6) mm, 7 mm long; the speeds differ by (0.2, 0.1, -0.2), 0.3 m/s: 100 * 0.007 + 1 * 0.3 = 1 N
  const Vector3d force =
      springDamper(kGains, {0.012, 0.007, 0.026}, {0.010, 0.010, 0.020}, {0.25, 0.1, -0.1}, {0.05, 0.0, 0.1});
  EXPECT_NEAR((force - Vector3d(2.0, -3.0, 6.0) / 7.0).norm(), 0.0, 1e-12);
  // and the damper adds, whichever way they part: eq. (5) has norms alone
  const Vector3d parting =
      springDamper(kGains, {0.012, 0.007, 0.026}, {0.010, 0.010, 0.020}, {0.05, 0.0, 0.1}, {0.25, 0.1, -0.1});
  EXPECT_EQ(parting, force);
}

TEST(SpringDamper, PointsFromRobotToModel) {
  const Vector3d force = springDamper(kGains, {0.01, 0.02, 0.0}, {0.01, 0.0, 0.0}, {5, 5, 5}, {0, 0, 0});
  EXPECT_GT(force.y(), 0.0);
  EXPECT_EQ(force.x(), 0.0);
  EXPECT_EQ(force.z(), 0.0);
}

TEST(SpringDamper, IsNeverBelowTheFloorNorAboveTheCap) {
  HapticGains weak = kGains;
  weak.kp = 1.0;
  weak.kd = 0.0;
  EXPECT_DOUBLE_EQ(springDamper(weak, {0.004, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}).norm(), 0.05);
  EXPECT_DOUBLE_EQ(springDamper(kGains, {1.0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}).norm(), 3.0);
}

TEST(SpringDamper, GivesNoForceForStatesThatAreNotFinite) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  for (const double bad : {nan, inf, -inf}) {
    EXPECT_EQ(springDamper(kGains, {bad, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}), Vector3d::Zero());
    EXPECT_EQ(springDamper(kGains, {0.1, 0, 0}, {0, 0, 0}, {0, bad, 0}, {0, 0, 0}), Vector3d::Zero());
  }
}

}  // namespace
}  // namespace raven2_trainer::haptics
