#include "raven2_trainer/model/camera.h"

#include <algorithm>
#include <cmath>

#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/core/nearest_name.h"

namespace raven2_trainer::model {
namespace {

constexpr double kNear = 1e-6;  // [m] points nearer than this to the camera's plane have no pixel

/** Columns right, down, forward; an `up` along the view is replaced by another axis. */
Matrix3 lookAlong(const Vector3& view, const Vector3& up) noexcept {
  const Vector3 z = view.norm() > kNear ? Vector3(view.normalized()) : Vector3(Vector3::UnitX());
  Vector3 x = z.cross(up);
  if (x.norm() < 1e-9) x = z.cross(std::abs(z.z()) < 0.9 ? Vector3(Vector3::UnitZ()) : Vector3(Vector3::UnitX()));
  x.normalize();
  Matrix3 R;
  R << x, z.cross(x), z;
  return R;
}

void lookFromClutch(const CameraState& state, CameraConfig* config) noexcept {
  const Vector3 eye = toEigen(state.eye_W), target = toEigen(state.target_W), up = toEigen(state.up_W);
  const double distance = (target - eye).norm();
  if (!(distance > kNear) || !std::isfinite(distance) || !up.allFinite()) return;
  config->eye_W = state.eye_W;
  config->target_W = state.target_W;
  config->up_W = state.up_W;
}

void lookAtTool(const ArmState& arm, const Pose& X_WB, CameraConfig* config) noexcept {
  const Vector3 tip_W = X_WB * toEigen(arm.p_BT);
  if (!tip_W.allFinite()) return;
  const Vector3 offset = toEigen(config->eye_W) - toEigen(config->target_W);
  config->target_W = toArray(tip_W);
  config->eye_W = toArray(Vector3(tip_W + offset));
}

}  // namespace

const CameraConfig* findCamera(const std::vector<CameraConfig>& cameras, const std::string& name) noexcept {
  const auto found =
      std::find_if(cameras.begin(), cameras.end(), [&name](const CameraConfig& camera) { return camera.name == name; });
  return found == cameras.end() ? nullptr : &*found;
}

const CameraConfig& requireCamera(const std::vector<CameraConfig>& cameras, const std::string& name) {
  if (const CameraConfig* camera = findCamera(cameras, name)) return *camera;
  std::vector<std::string> known;
  for (const CameraConfig& camera : cameras)
    known.push_back(camera.name);
  throw ConfigException(unknownName("camera", name, known));
}

Camera makeCamera(const CameraConfig& config, int width, int height) noexcept {
  Camera camera;
  camera.X_WC.p = toEigen(config.eye_W);
  camera.X_WC.R = lookAlong(toEigen(config.target_W) - camera.X_WC.p, toEigen(config.up_W));
  camera.X_WC.p += config.aside * camera.X_WC.R.col(0);
  camera.width = width;
  camera.height = height;
  camera.fy = 0.5 * height / std::tan(0.5 * config.vertical_fov);
  camera.fx = camera.fy;
  camera.cx = 0.5 * (width - 1);
  camera.cy = 0.5 * (height - 1);
  return camera;
}

Camera cameraAt(const CameraConfig& config,
                const ModelState& state,
                const PerArm<Pose>& X_WB,
                int width,
                int height) noexcept {
  CameraConfig moved;  // not a copy of `config`: its name is on the heap
  moved.eye_W = config.eye_W;
  moved.target_W = config.target_W;
  moved.up_W = config.up_W;
  moved.vertical_fov = config.vertical_fov;
  moved.aside = config.aside;
  switch (config.moves) {
    case CameraMoves::kNever:
      break;
    case CameraMoves::kClutch:
      lookFromClutch(state.camera, &moved);
      break;
    case CameraMoves::kGoldTool:
      lookAtTool(state.arms[0], X_WB[0], &moved);
      break;
    case CameraMoves::kGreenTool:
      lookAtTool(state.arms[1], X_WB[1], &moved);
      break;
  }
  return makeCamera(moved, width, height);
}

bool Camera::project(const Vector3& p_W, double* u, double* v) const noexcept {
  const Vector3 p_C = X_WC.R.transpose() * (p_W - X_WC.p);
  if (!(p_C.z() > kNear)) return false;
  *u = cx + fx * p_C.x() / p_C.z();
  *v = cy + fy * p_C.y() / p_C.z();
  return true;
}

}  // namespace raven2_trainer::model
