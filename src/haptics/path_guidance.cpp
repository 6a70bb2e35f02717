#include "raven2_trainer/haptics/path_guidance.h"

#include <algorithm>
#include <cmath>

#include "haptics/smooth_step.h"
#include "raven2_trainer/core/types.h"

namespace raven2_trainer::haptics {
namespace {

using Eigen::Vector3d;

Vector3d point(const GuidePath& path, std::size_t i) noexcept {
  return Vector3d(path.points_B[i][0], path.points_B[i][1], path.points_B[i][2]);
}

/** [m] From the tip to the nearest point of the path, its ends included. */
Vector3d toPath(const GuidePath& path, const Vector3d& tip) noexcept {
  Vector3d from = point(path, 0), best = from - tip;
  double least = best.squaredNorm();
  for (std::size_t i = 0; i + 1 < path.count; ++i) {
    const Vector3d to = point(path, i + 1);
    const Vector3d along = to - from;
    const double length2 = along.squaredNorm();
    const double share = length2 > 0.0 ? std::clamp((tip - from).dot(along) / length2, 0.0, 1.0) : 0.0;
    const Vector3d offset = from + share * along - tip;
    const double distance2 = offset.squaredNorm();
    if (distance2 < least) {
      least = distance2;
      best = offset;
    }
    from = to;
  }
  return best;
}

}  // namespace

Vector3d pathGuidance(const GuidanceConfig& config, const GuidePath& path, const Vector3d& tip_B) noexcept {
  if (path.count == 0 || path.count > kMaxPathPoints || !std::isfinite(tip_B.squaredNorm())) return Vector3d::Zero();
  const Vector3d offset = toPath(path, tip_B);
  const double distance = offset.norm();
  if (!(distance > 0.0)) return Vector3d::Zero();
  // size by the distance alone, direction down its gradient: whatever the size, that has a potential
  const double spring = std::min(config.stiffness * distance, config.max_force);
  const double fading = 1.0 - smoothStep((distance - config.reach) / config.reach);
  return offset * (spring * fading / distance);
}

double nextFade(const GuidanceConfig& config, double fade, bool is_guided, double seconds) noexcept {
  if (!is_guided) return 0.0;
  const double time = seconds > 0.0 ? std::min(seconds, kTickSeconds) : 0.0;
  return std::min(1.0, fade + time / config.fade_time);
}

}  // namespace raven2_trainer::haptics
