#include "raven2_trainer/control/camera_orbit.h"

#include <algorithm>
#include <cmath>

namespace raven2_trainer::control {
namespace {

// Ours. The increments are already scaled by the master's motion scale, 0.1: a hand's 100 mm swing the eye by 30 mm,
// 10 degrees at the endoscope's distance.
constexpr double kEyeByTip = 3.0;
constexpr double kNearest = 0.04, kFarthest = 0.60;  // [m] outside of the tools, inside of the dome's light
constexpr double kLowest = 5.0 * kPi / 180.0, kHighest = 85.0 * kPi / 180.0;  // [rad] above the base plate, and upright

}  // namespace

CameraOrbit::CameraOrbit(const CameraConfig& start) noexcept : target_W_(start.target_W) {
  Vec3 d{};
  for (std::size_t i = 0; i < d.size(); ++i)
    d[i] = start.eye_W[i] - start.target_W[i];
  const double flat = std::hypot(d[0], d[1]);
  distance_ = std::clamp(std::hypot(flat, d[2]), kNearest, kFarthest);
  azimuth_ = std::atan2(d[1], d[0]);
  elevation_ = std::clamp(std::atan2(d[2], flat), kLowest, kHighest);
}

void CameraOrbit::move(const Vec3& mean_I) noexcept {
  const double around = distance_ * std::cos(elevation_);  // [m] radius of the circle on which it goes sideways
  azimuth_ = std::remainder(azimuth_ + kEyeByTip * mean_I[1] / around, 2.0 * kPi);
  elevation_ = std::clamp(elevation_ - kEyeByTip * mean_I[2] / distance_, kLowest, kHighest);
  distance_ = std::clamp(distance_ - kEyeByTip * mean_I[0], kNearest, kFarthest);
}

CameraState CameraOrbit::state() const noexcept {
  CameraState camera;
  const double flat = distance_ * std::cos(elevation_);
  camera.eye_W = {target_W_[0] + flat * std::cos(azimuth_), target_W_[1] + flat * std::sin(azimuth_),
                  target_W_[2] + distance_ * std::sin(elevation_)};
  camera.target_W = target_W_;
  return camera;
}

}  // namespace raven2_trainer::control
