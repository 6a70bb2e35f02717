#include "raven2_trainer/model/camera.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::model {
namespace {

/** At 1 m above the origin looking down, x of W up in the picture, 90 degrees high. */
Camera downward() {
  CameraConfig config;
  config.eye_W = {0.0, 0.0, 1.0};
  config.target_W = {0.0, 0.0, 0.0};
  config.up_W = {1.0, 0.0, 0.0};
  config.vertical_fov = kPi / 2;
  return makeCamera(config, 640, 480);
}

TEST(Camera, TargetIsInTheCentreOfTheImage) {
  double u = 0, v = 0;
  ASSERT_TRUE(downward().project({0, 0, 0}, &u, &v));
  EXPECT_NEAR(u, 319.5, 1e-9);
  EXPECT_NEAR(v, 239.5, 1e-9);
}

TEST(Camera, UpIsSmallerRowAndRightIsLargerColumn) {
  double u = 0, v = 0;
  // 45 degrees up from the axis: the picture's upper edge, 240 px above the centre. W's left (+y) is the left.
  ASSERT_TRUE(downward().project({1.0, 0.0, 0.0}, &u, &v));
  EXPECT_NEAR(u, 319.5, 1e-9);
  EXPECT_NEAR(v, 239.5 - 240.0, 1e-9);
  ASSERT_TRUE(downward().project({0.0, -0.5, 0.0}, &u, &v));
  EXPECT_NEAR(u, 319.5 + 120.0, 1e-9);
  EXPECT_NEAR(v, 239.5, 1e-9);
}

TEST(Camera, ScreenOffsetShrinksWithDistance) {
  double u = 0, v = 0;
  ASSERT_TRUE(downward().project({0.0, -0.5, -1.0}, &u, &v));
  EXPECT_NEAR(u, 319.5 + 60.0, 1e-9);
}

TEST(Camera, PointsBehindHaveNoPixel) {
  double u = 1, v = 2;
  EXPECT_FALSE(downward().project({0.0, 0.0, 1.5}, &u, &v));
  EXPECT_FALSE(downward().project({0.3, 0.0, 1.0}, &u, &v));
  EXPECT_FALSE(downward().project({std::nan(""), 0.0, 0.0}, &u, &v));
  EXPECT_EQ(u, 1);
  EXPECT_EQ(v, 2);
}

TEST(Camera, FrameIsRightHandedOptical) {
  CameraConfig config;
  config.eye_W = {-0.75, 0.15, 0.65};
  config.target_W = {0.05, 0.0, 0.18};
  config.up_W = {0, 0, 1};
  config.vertical_fov = 0.75;
  const Camera camera = makeCamera(config, 1280, 720);
  EXPECT_NEAR(camera.X_WC.R.determinant(), 1.0, 1e-12);
  EXPECT_LT((camera.X_WC.R * camera.X_WC.R.transpose() - Matrix3::Identity()).norm(), 1e-12);
  EXPECT_NEAR(camera.X_WC.R(2, 0), 0.0, 1e-12);  // x level
  EXPECT_LT(camera.X_WC.R(2, 1), 0.0);           // y down
}

TEST(Camera, UpAlongTheViewStillGivesARotation) {
  CameraConfig config;
  config.eye_W = {0, 0, 1};
  config.up_W = {0, 0, 1};
  config.vertical_fov = 1.0;
  const Camera camera = makeCamera(config, 100, 100);
  EXPECT_NEAR(camera.X_WC.R.determinant(), 1.0, 1e-12);
}

class MovingCamera : public ::testing::Test {
 protected:
  MovingCamera() {
    config_.eye_W = {-0.2, 0.1, 0.3};
    config_.target_W = {0.0, 0.0, 0.1};
    config_.up_W = {0, 0, 1};
    config_.vertical_fov = 0.8;
    // Bases that are neither at the origin nor along the axes of W.
    X_WB_[0].p = {-0.03, 0.06, 0.14};
    X_WB_[0].R << 0, -1, 0, 0, 0, -1, 1, 0, 0;
    X_WB_[1].p = {0.05, -0.06, 0.12};
    X_WB_[1].R << 0, 1, 0, 0, 0, 1, 1, 0, 0;
    state_.arms[0].p_BT = {-0.08, 0.01, 0.02};
    state_.arms[1].p_BT = {-0.07, -0.02, 0.01};
  }

  Camera camera(CameraMoves moves) {
    config_.moves = moves;
    return cameraAt(config_, state_, X_WB_, 640, 360);
  }

  static void expectSame(const Camera& a, const Camera& b) {
    EXPECT_EQ((a.X_WC.p - b.X_WC.p).norm(), 0.0);
    EXPECT_EQ((a.X_WC.R - b.X_WC.R).norm(), 0.0);
    EXPECT_EQ(a.fx, b.fx);
  }

  static void expectInTheMiddle(const Camera& camera, const Vector3& p_W) {
    double u = 0, v = 0;
    ASSERT_TRUE(camera.project(p_W, &u, &v));
    EXPECT_NEAR(u, 319.5, 1e-9);
    EXPECT_NEAR(v, 179.5, 1e-9);
  }

  CameraConfig config_;
  PerArm<Pose> X_WB_{};
  ModelState state_;
};

TEST_F(MovingCamera, TheClutchsPoseIsTakenWithTheLensOfTheConfiguration) {
  state_.camera = {{0.1, -0.3, 0.4}, {0.02, 0.01, 0.0}, {0.0, 0.0, 1.0}};
  const Camera moved = camera(CameraMoves::kClutch);
  EXPECT_LT((moved.X_WC.p - Vector3(0.1, -0.3, 0.4)).norm(), 1e-12);
  expectInTheMiddle(moved, {0.02, 0.01, 0.0});
  EXPECT_EQ(moved.fx, makeCamera(config_, 640, 360).fx);
  expectSame(camera(CameraMoves::kNever), makeCamera(config_, 640, 360));
}

TEST_F(MovingCamera, TheClutchRollsItByItsUp) {
  // GIVEN a camera that looks down, its up along x, y and between, not that of the configuration
  for (const double angle : {0.0, 0.5, 2.0, -1.5}) {
    const Vector3 up(std::cos(angle), std::sin(angle), 0.0);
    state_.camera = {{0.0, 0.0, 0.4}, {0.0, 0.0, 0.0}, {up.x(), up.y(), up.z()}};
    double u = 0, v = 0;
    ASSERT_TRUE(camera(CameraMoves::kClutch).project(0.05 * up, &u, &v));
    EXPECT_NEAR(u, 319.5, 1e-9) << angle;
    EXPECT_LT(v, 179.5 - 10.0) << angle << ": above the middle";
  }
}

TEST_F(MovingCamera, ARecordThatTellsNoCameraLeavesItWhereTheConfigurationPutsIt) {
  ASSERT_EQ(state_.camera.eye_W, state_.camera.target_W);
  expectSame(camera(CameraMoves::kClutch), makeCamera(config_, 640, 360));
}

TEST_F(MovingCamera, ItLooksAtTheToolFromTheSideThatTheConfigurationGives) {
  // By hand: the gold base takes x, y, z of B to z, -x, -y of W.
  const Vector3 gold_W(-0.03 - 0.01, 0.06 - 0.02, 0.14 - 0.08), green_W(0.05 - 0.02, -0.06 + 0.01, 0.12 - 0.07);
  const Vector3 offset(-0.2, 0.1, 0.2);
  for (const auto& [moves, tip_W] : {std::pair(CameraMoves::kGoldTool, gold_W), {CameraMoves::kGreenTool, green_W}}) {
    const Camera moved = camera(moves);
    expectInTheMiddle(moved, tip_W);
    EXPECT_LT((moved.X_WC.p - tip_W - offset).norm(), 1e-12);
  }
}

TEST_F(MovingCamera, WhatIsNotFiniteDoesNotMoveIt) {
  const double nan = std::nan(""), inf = HUGE_VAL;
  const Camera fixed = makeCamera(config_, 640, 360);
  state_.arms[0].p_BT[1] = nan;
  expectSame(camera(CameraMoves::kGoldTool), fixed);
  for (const double bad : {nan, inf}) {
    state_.camera = {{bad, 0, 1}, {0, 0, 0}, {0, 0, 1}};
    expectSame(camera(CameraMoves::kClutch), fixed);
    state_.camera = {{1, 0, 1}, {0, 0, 0}, {0, bad, 1}};
    expectSame(camera(CameraMoves::kClutch), fixed);
  }
}

TEST_F(MovingCamera, TwoEyesSeeAPointApartByFocalLengthTimesBaselineOverDepth) {
  state_.camera = {{-0.2, 0.05, 0.2}, {0.0, 0.0, 0.03}, {0.0, 0.0, 1.0}};
  const double baseline = 0.005;
  config_.aside = -0.5 * baseline;
  const Camera left = camera(CameraMoves::kClutch);
  config_.aside = 0.5 * baseline;
  const Camera right = camera(CameraMoves::kClutch);
  EXPECT_NEAR((right.X_WC.p - left.X_WC.p).norm(), baseline, 1e-12);
  for (const double depth : {0.05, 0.2, 0.6}) {
    const Vector3 p_W = left.X_WC * Vector3(0.01, -0.02, depth);
    double ul = 0, vl = 0, ur = 0, vr = 0;
    ASSERT_TRUE(left.project(p_W, &ul, &vl) && right.project(p_W, &ur, &vr));
    EXPECT_NEAR(ul - ur, left.fx * baseline / depth, 1e-9) << "the left eye sees it farther right";
    EXPECT_NEAR(vl, vr, 1e-9);
  }
}

TEST(CameraByName, IsFoundOrTheKnownOnesAreTold) {
  std::vector<CameraConfig> cameras(2);
  cameras[0].name = "overview";
  cameras[1].name = "top";
  EXPECT_EQ(findCamera(cameras, "top"), &cameras[1]);
  EXPECT_EQ(&requireCamera(cameras, "overview"), &cameras[0]);
  EXPECT_EQ(findCamera(cameras, "side"), nullptr);
  try {
    requireCamera(cameras, "side");
    FAIL() << "no such camera";
  } catch (const ConfigException& e) {
    EXPECT_NE(std::string(e.what()).find("no camera is called \"side\"; known: overview, top"), std::string::npos)
        << e.what();
  }
}

TEST(Camera, UpAlongTheViewGivesARotationWhicheverWayItLooks) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      CameraConfig config;
      config.target_W[axis] = side;
      config.up_W[axis] = 1.0;
      config.vertical_fov = 1.0;
      const Camera camera = makeCamera(config, 100, 100);
      EXPECT_NEAR(camera.X_WC.R.determinant(), 1.0, 1e-12) << axis << " " << side;
      EXPECT_LT((camera.X_WC.R.col(2) - toEigen(config.target_W)).norm(), 1e-12) << axis << " " << side;
    }
  }
}

}  // namespace
}  // namespace raven2_trainer::model
