#include "raven2_trainer/control/camera_orbit.h"

#include <gtest/gtest.h>

#include <cmath>

#include "raven2_trainer/kinematics/eigen.h"

namespace raven2_trainer::control {
namespace {

/** Behind the scene and above it, as the endoscope: looks along +x, so right is -y. */
CameraConfig camera() {
  CameraConfig config;
  config.eye_W = {-0.2, 0.0, 0.15};
  config.target_W = {0.0, 0.0, 0.03};
  return config;
}

double distanceOf(const CameraState& state) {
  return (toEigen(state.eye_W) - toEigen(state.target_W)).norm();
}

TEST(CameraOrbit, BeginsWhereTheConfiguredCameraStands) {
  const CameraState state = CameraOrbit(camera()).state();
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(state.eye_W[i], camera().eye_W[i], 1e-12);
    EXPECT_EQ(state.target_W[i], camera().target_W[i]);
  }
  EXPECT_EQ(state.up_W, (Vec3{0.0, 0.0, 1.0}));
}

TEST(CameraOrbit, GoesWhereTheHandsGoThreeTimesAsFar) {
  CameraOrbit right(camera()), up(camera()), forward(camera());
  right.move({0.0, 1e-4, 0.0});
  EXPECT_NEAR(right.state().eye_W[1], -3e-4, 1e-6);
  EXPECT_NEAR(right.state().eye_W[2], 0.15, 1e-12);
  up.move({0.0, 0.0, -1e-4});  // I's third axis points down
  EXPECT_GT(up.state().eye_W[2], 0.15);
  EXPECT_NEAR((toEigen(up.state().eye_W) - toEigen(camera().eye_W)).norm(), 3e-4, 1e-6);
  forward.move({1e-4, 0.0, 0.0});
  EXPECT_NEAR(distanceOf(forward.state()), distanceOf(CameraOrbit(camera()).state()) - 3e-4, 1e-12);
}

TEST(CameraOrbit, KeepsItsDistanceAroundAndComesBackWhereItWas) {
  CameraOrbit orbit(camera());
  const CameraState start = orbit.state();
  for (int i = 0; i < 1000; ++i) {
    orbit.move({0.0, 3e-4, 0.0});
    EXPECT_NEAR(distanceOf(orbit.state()), distanceOf(start), 1e-12);
    EXPECT_NEAR(orbit.state().eye_W[2], start.eye_W[2], 1e-12);
  }
  for (int i = 0; i < 1000; ++i)
    orbit.move({0.0, -3e-4, 0.0});
  EXPECT_LT((toEigen(orbit.state().eye_W) - toEigen(start.eye_W)).norm(), 1e-9);
}

TEST(CameraOrbit, StopsAtItsLimits) {
  CameraOrbit orbit(camera());
  for (int i = 0; i < 2000; ++i)
    orbit.move({1e-3, 0.0, -1e-3});
  EXPECT_NEAR(distanceOf(orbit.state()), 0.04, 1e-12);
  EXPECT_NEAR(orbit.state().eye_W[2] - 0.03, 0.04 * std::sin(85.0 * kPi / 180.0), 1e-12);
  for (int i = 0; i < 2000; ++i)
    orbit.move({-1e-3, 0.0, 1e-3});
  EXPECT_NEAR(distanceOf(orbit.state()), 0.6, 1e-12);
  EXPECT_GT(orbit.state().eye_W[2], 0.03) << "never from below";
}

double elevationOf(const CameraState& state) {
  return std::asin((state.eye_W[2] - state.target_W[2]) / distanceOf(state)) * 180.0 / kPi;
}

TEST(CameraOrbit, StaysFiveDegreesAboveTheBasePlateAndFiveFromUpright) {
  for (const double down : {1e-3, -1e-3}) {
    CameraOrbit orbit(camera());
    for (int i = 0; i < 2000; ++i)
      orbit.move({0.0, 0.0, down});
    EXPECT_NEAR(elevationOf(orbit.state()), down > 0.0 ? 5.0 : 85.0, 1e-9);
    orbit.move({0.0, 0.0, -0.1 * down});
    EXPECT_NEAR((toEigen(orbit.state().eye_W) - toEigen(camera().target_W)).norm(), distanceOf(orbit.state()), 1e-12);
    EXPECT_GT(elevationOf(orbit.state()), 5.0) << "back at once";
    EXPECT_LT(elevationOf(orbit.state()), 85.0);
  }
}

TEST(CameraOrbit, BringsAConfiguredCameraWithinItsLimits) {
  CameraConfig near = camera(), far = camera(), below = camera();
  near.eye_W = {-0.02, 0.0, 0.05};
  far.eye_W = {-2.0, 0.0, 1.0};
  below.eye_W = {-0.2, 0.0, -0.1};
  EXPECT_NEAR(distanceOf(CameraOrbit(near).state()), 0.04, 1e-12);
  EXPECT_NEAR(distanceOf(CameraOrbit(far).state()), 0.60, 1e-12);
  EXPECT_NEAR(elevationOf(CameraOrbit(below).state()), 5.0, 1e-9);
}

TEST(CameraOrbit, BeginsOnWhicheverSideTheConfiguredCameraStands) {
  for (const double x : {-0.15, 0.15}) {
    for (const double y : {-0.1, 0.1}) {
      CameraConfig config = camera();
      config.eye_W = {x, y, 0.13};
      EXPECT_LT((toEigen(CameraOrbit(config).state().eye_W) - toEigen(config.eye_W)).norm(), 1e-12) << x << " " << y;
    }
  }
}

TEST(CameraOrbit, BringsACameraFromStraightAboveFiveDegreesFromUpright) {
  CameraConfig above = camera();
  above.eye_W = {0.0, 0.0, 0.23};
  EXPECT_NEAR(elevationOf(CameraOrbit(above).state()), 85.0, 1e-9);
  EXPECT_NEAR(distanceOf(CameraOrbit(above).state()), 0.2, 1e-12);
}

}  // namespace
}  // namespace raven2_trainer::control
