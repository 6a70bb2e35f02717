#include "render/projection.h"

#include <gtest/gtest.h>

#include "render_fixture.h"

namespace raven2_trainer::render {
namespace {

TEST(Projection, ClipSpaceAgreesWithTheCameraModel) {
  const model::Camera camera = testCamera();
  const Eigen::Matrix4f clip_from_world = clipFromWorld(camera);
  for (double x = -0.3; x <= 0.3; x += 0.15) {
    for (double y = -0.3; y <= 0.3; y += 0.15) {
      double u = 0.0, v = 0.0;
      ASSERT_TRUE(camera.project({x, y, 0.1}, &u, &v));
      const Eigen::Vector4f clip =
          clip_from_world * Eigen::Vector4f(static_cast<float>(x), static_cast<float>(y), 0.1F, 1);
      // Counted from the picture's edge, a pixel's centre is half a pixel beyond its integer coordinate.
      EXPECT_NEAR((clip.x() / clip.w() + 1.0) / 2.0 * kWidth - 0.5, u, 1e-3);
      EXPECT_NEAR((1.0 - clip.y() / clip.w()) / 2.0 * kHeight - 0.5, v, 1e-3);
      EXPECT_LT(std::abs(clip.z()), clip.w());
    }
  }
}

TEST(Projection, ASphereIsInViewAsLongAsAPartOfItIs) {
  const model::Camera camera = testCamera();
  const double edge = kHeight / 2.0 / camera.fy;  // tangent of half the opening
  const auto at = [&camera](double down, double z) { return camera.X_WC * Vector3(0.0, down, z); };
  EXPECT_TRUE(isInView(camera, at(0.0, 1.0), 0.0));
  EXPECT_FALSE(isInView(camera, at(0.0, -1.0), 0.5));
  EXPECT_TRUE(isInView(camera, at(0.0, -0.2), 0.5));
  EXPECT_FALSE(isInView(camera, at(edge + 0.2, 1.0), 0.1));
  EXPECT_TRUE(isInView(camera, at(edge + 0.2, 1.0), 0.3));
  EXPECT_FALSE(isInView(camera, at(-edge - 0.2, 1.0), 0.1));
}

TEST(Projection, AShadowIsInViewWhereItsRaysCrossTheView) {
  const model::Camera camera = testCamera();
  const Vector3 light = keyLight().cast<double>(), seen_W(0.02, 0.01, 0.05);
  const Vector3 above_W = seen_W + 1.0 * light;
  ASSERT_FALSE(isInView(camera, above_W, 0.05));
  EXPECT_TRUE(isShadowInView(camera, above_W, 0.05));
  EXPECT_TRUE(isShadowInView(camera, seen_W, 0.0));
  const Vector3 aside_W = above_W + 2.0 * camera.X_WC.R.col(0);
  EXPECT_FALSE(isShadowInView(camera, aside_W, 0.05));
  EXPECT_TRUE(isShadowInView(camera, aside_W, 2.0));
}

TEST(Projection, ASphereIsInTheShadowMapAsLongAsAPartOfItIs) {
  const Eigen::Matrix4f shadow = shadowClipFromWorld(testCamera());
  const auto at = [&shadow](const Eigen::Vector3f& clip) {
    return Vector3((shadow.inverse() * clip.homogeneous()).head<3>().cast<double>());
  };
  for (int axis = 0; axis < 3; ++axis) {
    for (const float sign : {-1.0F, 1.0F}) {
      const double reach = 1.0 / shadow.block<1, 3>(axis, 0).norm();  // [m] half the map
      const Vector3 outside_W = at(1.5F * sign * Eigen::Vector3f::Unit(axis));
      EXPECT_TRUE(isInShadowMap(shadow, at(0.9F * sign * Eigen::Vector3f::Unit(axis)), 0.0)) << axis;
      EXPECT_FALSE(isInShadowMap(shadow, outside_W, 0.49 * reach)) << axis;
      EXPECT_TRUE(isInShadowMap(shadow, outside_W, 0.51 * reach)) << axis;
    }
  }
}

TEST(Projection, TheShadowMapIsCentredOnWhatIsLookedAt) {
  const Eigen::Matrix4f shadow = shadowClipFromWorld(testCamera());
  const Eigen::Vector4f looked_at = shadow * Eigen::Vector4f(0.02F, 0.01F, 0.05F, 1.0F);
  EXPECT_LT(looked_at.head<3>().norm(), 0.2F);
  // A point farther along the light's rays has the greater depth.
  const Eigen::Vector3f p(0.1F, 0.0F, 0.1F);
  const Eigen::Vector4f near = shadow * (p + 0.1F * keyLight()).homogeneous(), far = shadow * p.homogeneous();
  EXPECT_LT(near.z(), far.z());
  EXPECT_NEAR(near.x(), far.x(), 1e-5F);
  EXPECT_NEAR(near.y(), far.y(), 1e-5F);
}

}  // namespace
}  // namespace raven2_trainer::render
