#include "render/projection.h"

#include <algorithm>
#include <array>

namespace raven2_trainer::render {

namespace {

constexpr double kNearPlane = 0.005;  // [m]
constexpr double kFarPlane = 10.0;    // [m]
constexpr double kFloor = 0.02;       // [m] height of the floor, on which most shadows fall
constexpr double kShadowShare = 1.2;  // [-] half width of the shadow map over the distance of what is looked at
constexpr double kMinShadowReach = 0.15, kMaxShadowReach = 0.65;  // [m]
constexpr double kShadowDepth = 1.2;     // [m] things up to here above the map's centre cast shadows
constexpr double kShadowBlur = 0.01;     // [m] more than the lookup is off the lit point, which is up to 3 texels
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
  m(2, 2) = (kFarPlane + kNearPlane) / (kFarPlane - kNearPlane);
  m(2, 3) = -2.0 * kFarPlane * kNearPlane / (kFarPlane - kNearPlane);
  m(3, 2) = 1.0;
  return m;
}

/** The planes through the camera that bound its picture: unit vectors in C, away from it. */
std::array<Vector3, 4> sidesOf(const model::Camera& c) noexcept {
  const double right = (c.width - c.cx) / c.fx, left = (c.cx + 1.0) / c.fx;
  const double bottom = (c.height - c.cy) / c.fy, top = (c.cy + 1.0) / c.fy;
  return {Vector3(1.0, 0.0, -right).normalized(), Vector3(-1.0, 0.0, -left).normalized(),
          Vector3(0.0, 1.0, -bottom).normalized(), Vector3(0.0, -1.0, -top).normalized()};
}

/** False if a sphere stays beyond one side of the view while it moves from one place to another. */
bool isSweepInView(const model::Camera& camera, const Vector3& from_W, const Vector3& to_W, double radius) noexcept {
  const Pose X_CW = camera.X_WC.inverse();
  const Vector3 from = X_CW * from_W, to = X_CW * to_W;
  if (std::max(from.z(), to.z()) + radius < kNearPlane) return false;
  const std::array<Vector3, 4> sides = sidesOf(camera);
  return std::none_of(sides.begin(), sides.end(),
                      [&](const Vector3& outward) { return std::min(outward.dot(from), outward.dot(to)) > radius; });
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

float metresOf(float depth) noexcept {
  const double clip = 2.0 * static_cast<double>(depth) - 1.0;
  return static_cast<float>(2.0 * kFarPlane * kNearPlane / (kFarPlane + kNearPlane - clip * (kFarPlane - kNearPlane)));
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

bool isInView(const model::Camera& camera, const Vector3& centre_W, double radius) noexcept {
  return isSweepInView(camera, centre_W, centre_W, radius);
}

bool isShadowInView(const model::Camera& camera, const Vector3& centre_W, double radius) noexcept {
  const Vector3 end_W = centre_W - 2.0 * kShadowDepth * keyLight().cast<double>();
  return isSweepInView(camera, centre_W, end_W, radius + kShadowBlur);
}

bool isInShadowMap(const Eigen::Matrix4f& shadow_clip_from_world, const Vector3& centre_W, double radius) noexcept {
  const Eigen::Matrix4d clip = shadow_clip_from_world.cast<double>();
  const Vector3 p = (clip * centre_W.homogeneous()).head<3>();
  const Vector3 reach = radius * clip.topLeftCorner<3, 3>().rowwise().norm();
  return (p.cwiseAbs() - reach).maxCoeff() <= 1.0;
}

}  // namespace raven2_trainer::render
