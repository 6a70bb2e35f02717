#include "raven2_trainer/model/camera.h"

#include <cmath>

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

}  // namespace

Camera makeCamera(const CameraConfig& config, int width, int height) noexcept {
  Camera camera;
  camera.X_WC.p = toEigen(config.eye_W);
  camera.X_WC.R = lookAlong(toEigen(config.target_W) - camera.X_WC.p, toEigen(config.up_W));
  camera.width = width;
  camera.height = height;
  camera.fy = 0.5 * height / std::tan(0.5 * config.vertical_fov);
  camera.fx = camera.fy;
  camera.cx = 0.5 * (width - 1);
  camera.cy = 0.5 * (height - 1);
  return camera;
}

bool Camera::project(const Vector3& p_W, double* u, double* v) const noexcept {
  const Vector3 p_C = X_WC.R.transpose() * (p_W - X_WC.p);
  if (!(p_C.z() > kNear)) return false;
  *u = cx + fx * p_C.x() / p_C.z();
  *v = cy + fy * p_C.y() / p_C.z();
  return true;
}

}  // namespace raven2_trainer::model
