#include "raven2_trainer/control/tip_path.h"

#include "raven2_trainer/kinematics/arm_kinematics.h"

namespace raven2_trainer::control {
namespace {

JointArray between(const JointArray& a, const JointArray& b, double share) noexcept {
  JointArray q{};
  for (std::size_t j = 0; j < kJointCount; ++j)
    q[j] = a[j] + share * (b[j] - a[j]);
  return q;
}

}  // namespace

GuidePath tipPath(const ArmGeometry& geometry, const PlanResult& plan) noexcept {
  GuidePath path;
  const bool can_be_counted = plan.waypoint_count > 0 && plan.waypoint_count <= kMaxWaypoints;
  if (plan.status != PlanStatus::kSuccess || !can_be_counted) return path;
  path.plan = plan.id;
  path.arm = plan.arm;
  const auto add = [&](const JointArray& q) {
    path.points_B[path.count++] = toArray(kinematics::forward(geometry, plan.arm, q).p);
  };
  add(plan.waypoints[0]);
  const std::uint32_t edges = plan.waypoint_count - 1;
  const std::uint32_t pieces = edges > 0 ? static_cast<std::uint32_t>(kMaxPathPoints - 1) / edges : 0;
  for (std::uint32_t edge = 0; edge < edges; ++edge) {
    for (std::uint32_t piece = 1; piece <= pieces; ++piece)
      add(between(plan.waypoints[edge], plan.waypoints[edge + 1], static_cast<double>(piece) / pieces));
  }
  return path;
}

}  // namespace raven2_trainer::control
