#include "raven2_trainer/model/camera.h"

#include <gtest/gtest.h>

#include <cmath>

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

}  // namespace
}  // namespace raven2_trainer::model
