#include "render/projection.h"

#include <algorithm>
#include <cmath>

namespace raven2_trainer::render {

namespace {

constexpr double kNear = 0.005;       // [m]
constexpr double kFar = 10.0;         // [m]
constexpr double kFloor = 0.02;       // [m] height of what most shadows fall on
constexpr double kShadowShare = 1.2;  // [-] half width of the shadow map over the distance of what is looked at
constexpr double kMinShadowReach = 0.15, kMaxShadowReach = 0.65;  // [m]
constexpr double kShadowDepth = 1.2;     // [m] things up to here above the map's centre cast shadows
constexpr double kMaxDistance = 1000.0;  // [m]

Eigen::Matrix4d homogeneous(const Pose& pose) {
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  m.topLeftCorner<3, 3>() = pose.R;
  m.topRightCorner<3, 1>() = pose.p;
  return m;
}

/** OpenGL's clip space from the optical frame (z forward, y down); integer pixel centres lie half a pixel inside. */
Eigen::Matrix4d clipFromCamera(const model::Camera& c) {
  Eigen::Matrix4d m = Eigen::Matrix4d::Zero();
  m(0, 0) = 2.0 * c.fx / c.width;
  m(0, 2) = 2.0 * (c.cx + 0.5) / c.width - 1.0;
  m(1, 1) = -2.0 * c.fy / c.height;
  m(1, 2) = 1.0 - 2.0 * (c.cy + 0.5) / c.height;
  m(2, 2) = (kFar + kNear) / (kFar - kNear);
  m(2, 3) = -2.0 * kFar * kNear / (kFar - kNear);
  m(3, 2) = 1.0;
  return m;
}

/** One side plane of the pyramid; `slope` is the tangent of its angle to the optical axis. */
bool isBeyondSide(double across, double z, double slope, double radius) noexcept {
  return across - slope * z > radius * std::sqrt(1.0 + slope * slope);
}

/** [m] Where the optical axis meets the floor, within bounds. */
double viewDistance(const model::Camera& camera) {
  const double down = -camera.X_WC.R(2, 2);
  const double distance = down > 1e-3 ? (camera.X_WC.p.z() - kFloor) / down : kMaxShadowReach / kShadowShare;
  return std::clamp(distance, kMinShadowReach / kShadowShare, 2.0 * kMaxShadowReach / kShadowShare);
}

}  // namespace

Eigen::Matrix4f clipFromWorld(const model::Camera& camera) {
  return (clipFromCamera(camera) * homogeneous(camera.X_WC.inverse())).cast<float>();
}

Eigen::Vector3f keyLight() {
  return Eigen::Vector3f(-0.45F, 0.40F, 1.0F).normalized();
}

Eigen::Vector3f fillLight() {
  return Eigen::Vector3f(-0.6F, -1.0F, 0.35F).normalized();
}

Eigen::Matrix4f shadowClipFromWorld(const model::Camera& camera) {
  const double distance = viewDistance(camera);
  const double reach = std::clamp(kShadowShare * distance, kMinShadowReach, kMaxShadowReach);
  const Vector3 centre_W = camera.X_WC * Vector3(0, 0, distance);
  const Vector3 z = -keyLight().cast<double>();
  const Vector3 x = z.cross(Vector3::UnitY()).normalized();
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  m.block<1, 3>(0, 0) = x.transpose() / reach;
  m.block<1, 3>(1, 0) = z.cross(x).transpose() / reach;
  m.block<1, 3>(2, 0) = z.transpose() / kShadowDepth;
  m.topRightCorner<3, 1>() = -(m.topLeftCorner<3, 3>() * centre_W);
  return m.cast<float>();
}

Eigen::Matrix4f textureFromClip() {
  Eigen::Matrix4f m = Eigen::Matrix4f::Identity() * 0.5F;
  m.col(3) << 0.5F, 0.5F, 0.5F, 1.0F;
  return m;
}

Eigen::Matrix4f matrixOf(const Pose& pose) {
  return homogeneous(pose).cast<float>();
}

bool isDrawable(const Pose& pose) noexcept {
  return pose.R.allFinite() && pose.p.allFinite() && pose.R.cwiseAbs().maxCoeff() < kMaxDistance &&
         pose.p.cwiseAbs().maxCoeff() < kMaxDistance;
}

bool isInView(const model::Camera& c, const Vector3& centre_W, double radius) noexcept {
  const Vector3 p = c.X_WC.inverse() * centre_W;
  if (p.z() + radius < kNear) return false;
  return !isBeyondSide(p.x(), p.z(), (c.width - c.cx) / c.fx, radius) &&
         !isBeyondSide(-p.x(), p.z(), (c.cx + 1.0) / c.fx, radius) &&
         !isBeyondSide(p.y(), p.z(), (c.height - c.cy) / c.fy, radius) &&
         !isBeyondSide(-p.y(), p.z(), (c.cy + 1.0) / c.fy, radius);
}

}  // namespace raven2_trainer::render
