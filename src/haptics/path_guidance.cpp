#include "raven2_trainer/haptics/path_guidance.h"

#include <algorithm>
#include <cmath>

#include "haptics/smooth_step.h"
#include "raven2_trainer/core/types.h"

namespace raven2_trainer::haptics {
namespace {

using Eigen::Vector3d;

/** Where the path is nearest. */
struct Nearest {
  Vector3d offset{Vector3d::Zero()};  ///< [m] from the tip to the path
  std::size_t segment{0};
  double share{0.0};  ///< of the segment's length, 0 to 1
};

Vector3d point(const GuidePath& path, std::size_t i) noexcept {
  return Vector3d(path.points_B[i][0], path.points_B[i][1], path.points_B[i][2]);
}

Nearest nearest(const GuidePath& path, const Vector3d& tip) noexcept {
  Nearest best;
  best.offset = point(path, 0) - tip;
  double least = best.offset.squaredNorm();
  Vector3d from = point(path, 0);
  for (std::size_t i = 0; i + 1 < path.count; ++i) {
    const Vector3d to = point(path, i + 1);
    const Vector3d along = to - from;
    const double length2 = along.squaredNorm();
    const double share = length2 > 0.0 ? std::clamp((tip - from).dot(along) / length2, 0.0, 1.0) : 0.0;
    const Vector3d offset = from + share * along - tip;
    const double distance2 = offset.squaredNorm();
    if (distance2 < least) {
      least = distance2;
      best = {offset, i, share};
    }
    from = to;
  }
  return best;
}

/** Past an end the part of the offset that runs on along the path goes: nothing holds a hand that leaves there. */
Vector3d acrossPath(const GuidePath& path, const Nearest& place) noexcept {
  if (path.count < 2) return place.offset;
  const bool at_start = place.segment == 0 && place.share <= 0.0;
  const bool at_end = place.segment + 2 == path.count && place.share >= 1.0;
  if (!at_start && !at_end) return place.offset;
  const Vector3d along = point(path, place.segment + 1) - point(path, place.segment);
  const double length2 = along.squaredNorm();
  if (length2 <= 0.0) return place.offset;
  return place.offset - along * (place.offset.dot(along) / length2);
}

}  // namespace

Vector3d pathGuidance(const GuidanceConfig& config, const GuidePath& path, const Vector3d& tip_B) noexcept {
  if (path.count == 0 || path.count > kMaxPathPoints || !std::isfinite(tip_B.squaredNorm())) return Vector3d::Zero();
  const Nearest place = nearest(path, tip_B);
  const Vector3d across = acrossPath(path, place);
  const double distance = across.norm();
  if (!(distance > 0.0)) return Vector3d::Zero();
  const double spring = std::min(config.stiffness * distance, config.max_force);
  const double fading = 1.0 - smoothStep((place.offset.norm() - config.reach) / config.reach);
  return across * (spring * fading / distance);
}

double nextFade(const GuidanceConfig& config, double fade, bool is_guided, double seconds) noexcept {
  if (!is_guided) return 0.0;
  const double time = seconds > 0.0 ? std::min(seconds, kTickSeconds) : 0.0;
  return std::min(1.0, fade + time / config.fade_time);
}

}  // namespace raven2_trainer::haptics
