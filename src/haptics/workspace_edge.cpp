#include "raven2_trainer/haptics/workspace_edge.h"

#include <algorithm>
#include <cmath>

#include "haptics/smooth_step.h"

namespace raven2_trainer::haptics {

using Eigen::Vector3d;

Vector3d workspaceEdge(const EdgeConfig& config, const Vector3d& hand_I) noexcept {
  if (!std::isfinite(hand_I.squaredNorm())) return Vector3d::Zero();
  Vector3d outside;  // of the box that is smaller by the margin
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const double inner = 0.5 * config.size_I[static_cast<std::size_t>(axis)] - config.margin;
    outside[axis] = std::copysign(std::max(0.0, std::abs(hand_I[axis]) - inner), hand_I[axis]);
  }
  const double distance = outside.norm();
  if (!(distance > 0.0)) return Vector3d::Zero();
  return outside * (-config.max_force * smoothStep(distance / config.margin) / distance);
}

}  // namespace raven2_trainer::haptics
