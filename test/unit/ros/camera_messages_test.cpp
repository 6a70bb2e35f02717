#include <gtest/gtest.h>

#include "ros/bridge/messages.h"

namespace raven2_trainer::ros_bridge {
namespace {

/** [px] Pixel of a point by the matrix of a camera_info alone (sensor_msgs/CameraInfo): P (x, y, z, 1). */
Eigen::Vector2d pixelBy(const sensor_msgs::CameraInfo& info, const Vector3& p) {
  Eigen::Matrix<double, 3, 4> P;
  for (Eigen::Index row = 0; row < 3; ++row) {
    for (Eigen::Index column = 0; column < 4; ++column)
      P(row, column) = info.P[static_cast<std::size_t>(4 * row + column)];
  }
  const Vector3 q = P * p.homogeneous();
  return {q.x() / q.z(), q.y() / q.z()};
}

class CameraMessages : public ::testing::Test {
 protected:
  CameraMessages() {
    config_.vertical_fov = 0.8;
    config_.moves = CameraMoves::kClutch;
    state_.camera = {{-0.12, 0.14, 0.21}, {0.01, -0.02, 0.03}, {0.0, 0.0, 1.0}};
  }

  model::Camera camera(double aside) {
    config_.aside = aside;
    return model::cameraAt(config_, state_, {}, 640, 360);
  }

  CameraConfig config_;
  ModelState state_;
};

TEST_F(CameraMessages, AMovedCamerasMatrixPutsPointsWhereThePictureHasThem) {
  const model::Camera moved = camera(0.0);
  const sensor_msgs::CameraInfo info = cameraInfo(moved, opticalFrame("endoscope"), ros::Time(3, 0));
  EXPECT_EQ(info.header.frame_id, "endoscope_optical_frame");
  // Transform into that frame by the published transform, as any other program would.
  const auto tf = transform(moved.X_WC, info.header.frame_id, ros::Time(3, 0)).transform;
  const Quaternion q(tf.rotation.w, tf.rotation.x, tf.rotation.y, tf.rotation.z);
  for (const Vector3& p_W : {Vector3(0.01, -0.02, 0.03), Vector3(0.05, 0.04, 0.06), Vector3(-0.03, 0.01, 0.0)}) {
    const Vector3 p_C = q.conjugate() * (p_W - Vector3(tf.translation.x, tf.translation.y, tf.translation.z));
    EXPECT_GT(p_C.z(), 0.0) << "z is forward";
    double u = 0, v = 0;
    ASSERT_TRUE(moved.project(p_W, &u, &v));
    EXPECT_LT((pixelBy(info, p_C) - Eigen::Vector2d(u, v)).norm(), 1e-6);
  }
}

TEST_F(CameraMessages, BothEyesTakePointsInTheLeftOnesFrame) {
  const double baseline = 0.005;
  const model::Camera left = camera(-0.5 * baseline), right = camera(0.5 * baseline);
  const sensor_msgs::CameraInfo l = cameraInfo(left, "l", ros::Time(3, 0)),
                                r = cameraInfo(right, "l", ros::Time(3, 0), baseline);
  EXPECT_EQ(l.P[3], 0.0);
  EXPECT_NEAR(r.P[3], -right.fx * baseline, 1e-12);
  for (const Vector3& p_C : {Vector3(0.0, 0.0, 0.2), Vector3(0.03, -0.02, 0.15), Vector3(-0.04, 0.01, 0.3)}) {
    double u = 0, v = 0;
    ASSERT_TRUE(left.project(left.X_WC * p_C, &u, &v));
    EXPECT_LT((pixelBy(l, p_C) - Eigen::Vector2d(u, v)).norm(), 1e-6);
    ASSERT_TRUE(right.project(left.X_WC * p_C, &u, &v));
    EXPECT_LT((pixelBy(r, p_C) - Eigen::Vector2d(u, v)).norm(), 1e-6);
  }
}

TEST_F(CameraMessages, AStampIsAsOldAsWhatItIsOf) {
  const ros::Time now(100, 500);
  EXPECT_EQ(stampOf(7'000'000'000, 7'030'000'000, now), ros::Time(99, 970'000'500));
  EXPECT_EQ(stampOf(7'000'000'000, 6'999'000'000, now), now) << "no stamp in the future";
  EXPECT_EQ(stampOf(0, 7'000'000'000, now), now) << "the time is unknown";
  EXPECT_EQ(stampOf(1, 200'000'000'000, now), now) << "older than the ROS clock";
}

}  // namespace
}  // namespace raven2_trainer::ros_bridge
