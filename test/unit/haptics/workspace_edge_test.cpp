#include "raven2_trainer/haptics/workspace_edge.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "raven2_trainer/core/random.h"
#include "raven2_trainer/core/types.h"

namespace raven2_trainer::haptics {
namespace {

using Eigen::Vector3d;

// the Omni's box: 70 mm deep (x forward), 160 wide (y right), 120 high (z down)
constexpr EdgeConfig kConfig{/*enabled=*/true,
                             {0.07, 0.16, 0.12},
                             /*margin=*/0.01,
                             /*max_force=*/1.5,
                             WorkspaceOrigin::kPedalDown};

TEST(WorkspaceEdge, IsSilentUpToTheMargin) {
  Random random(1);
  for (int i = 0; i < 1000; ++i) {
    const Vector3d hand(random.uniform(-0.025, 0.025), random.uniform(-0.07, 0.07), random.uniform(-0.05, 0.05));
    ASSERT_EQ(workspaceEdge(kConfig, hand), Vector3d::Zero());
  }
}

TEST(WorkspaceEdge, PushesBackWithItsWholeForceAtEachFace) {
  EXPECT_NEAR((workspaceEdge(kConfig, {0.035, 0.01, 0.02}) - Vector3d(-1.5, 0.0, 0.0)).norm(), 0.0, 1e-12);
  EXPECT_NEAR((workspaceEdge(kConfig, {-0.035, 0.0, 0.0}) - Vector3d(1.5, 0.0, 0.0)).norm(), 0.0, 1e-12);
  EXPECT_NEAR((workspaceEdge(kConfig, {0.0, 0.08, 0.0}) - Vector3d(0.0, -1.5, 0.0)).norm(), 0.0, 1e-12);
  EXPECT_NEAR((workspaceEdge(kConfig, {0.0, 0.0, -0.06}) - Vector3d(0.0, 0.0, 1.5)).norm(), 0.0, 1e-12);
  EXPECT_NEAR((workspaceEdge(kConfig, {0.0, 0.5, 0.0}) - Vector3d(0.0, -1.5, 0.0)).norm(), 0.0, 1e-12);
  EXPECT_NEAR(workspaceEdge(kConfig, {0.03, 0.0, 0.0}).x(), -0.75, 1e-12) << "halfway: 3/4 - 2/8 of it";
  EXPECT_NEAR(workspaceEdge(kConfig, {0.0275, 0.0, 0.0}).x(), -0.234375, 1e-12) << "a quarter: 3/16 - 2/64 of it";
  EXPECT_NEAR(workspaceEdge(kConfig, {0.2, -0.4, 0.3}).norm(), 1.5, 1e-12) << "in a corner no more";
}

TEST(WorkspaceEdge, PushesTowardsTheBoxFromEachFaceAndCorner) {
  // GIVEN the hand 3, 4 and 12 mm outside of the inner box, on either side of each axis: 13 mm, beyond the margin
  const Vector3d half(0.035, 0.08, 0.06), out(0.003, 0.004, 0.012);
  for (int sides = 0; sides < 27; ++sides) {
    const Vector3d side(sides % 3 - 1, sides / 3 % 3 - 1, sides / 9 - 1);
    const Vector3d outside = side.cwiseProduct(out);
    const Vector3d hand = side.cwiseProduct(half - Vector3d::Constant(kConfig.margin)) + outside;
    const double distance = outside.norm(), x = std::min(distance / kConfig.margin, 1.0);
    const Vector3d expected =
        distance > 0.0 ? Vector3d(-1.5 * x * x * (3.0 - 2.0 * x) * outside / distance) : Vector3d(Vector3d::Zero());
    EXPECT_NEAR((workspaceEdge(kConfig, hand) - expected).norm(), 0.0, 1e-12) << side.transpose();
  }
}

TEST(WorkspaceEdge, DoesNotJumpAndIsBoundedAnywhere) {
  // the steepest of 3 x^2 - 2 x^3 is 3/2: 1.5 N * 1.5 / 10 mm
  constexpr double kSteepest = 225.0;  // [N/m]
  Random random(2);
  for (int i = 0; i < 20000; ++i) {
    const Vector3d hand(random.uniform(-0.08, 0.08), random.uniform(-0.16, 0.16), random.uniform(-0.12, 0.12));
    Vector3d step(random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0));
    step *= 1e-6 / step.norm();
    const Vector3d force = workspaceEdge(kConfig, hand);
    ASSERT_LE(force.norm(), kConfig.max_force * (1.0 + 1e-12));
    ASSERT_LE((workspaceEdge(kConfig, hand + step) - force).norm(), kSteepest * 1.001e-6);
  }
}

TEST(WorkspaceEdge, GivesNothingOnAClosedWay) {
  Random random(3);
  for (int run = 0; run < 20; ++run) {
    // a random closed curve through faces, edges and corners
    Vector3d c[3], s[3];
    for (int i = 0; i < 3; ++i) {
      c[i] = {random.uniform(-0.04, 0.04), random.uniform(-0.08, 0.08), random.uniform(-0.06, 0.06)};
      s[i] = {random.uniform(-0.04, 0.04), random.uniform(-0.08, 0.08), random.uniform(-0.06, 0.06)};
    }
    const auto at = [&](double u) {
      Vector3d x = Vector3d::Zero();
      for (int i = 0; i < 3; ++i)
        x += c[i] * std::cos((i + 1) * u) + s[i] * std::sin((i + 1) * u);
      return x;
    };
    constexpr int kSteps = 20000;
    double work = 0.0, exchanged = 0.0;
    for (int k = 0; k < kSteps; ++k) {
      const double u = 2.0 * kPi * k / kSteps, h = 2.0 * kPi / kSteps;
      const double dw = workspaceEdge(kConfig, at(u + 0.5 * h)).dot(at(u + h) - at(u));
      work += dw;
      exchanged += std::abs(dw);
    }
    ASSERT_NEAR(work, 0.0, 1e-5 * exchanged) << run;
    ASSERT_GT(exchanged, 0.01) << "the curve must meet the edge";
  }
}

TEST(WorkspaceEdge, GivesNoForceForPlacesThatAreNotFinite) {
  const double nan = std::nan(""), inf = std::numeric_limits<double>::infinity();
  for (const double bad : {nan, inf, -inf, 1e200})
    EXPECT_EQ(workspaceEdge(kConfig, {0.0, bad, 0.0}), Vector3d::Zero());
}

}  // namespace
}  // namespace raven2_trainer::haptics
