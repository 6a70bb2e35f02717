#include "planning/motion_bound.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace raven2_trainer::planning {
namespace {

constexpr double kMostTurned = 0.5;  // [rad] beyond, S / (1 - T) says little

/** The corners of a shape in its own frame, each with the same ball. */
std::vector<Vector3> cornersOf(const model::CollisionShape& shape) {
  if (shape.kind == model::ShapeKind::kSphere) return {Vector3::Zero()};
  if (shape.kind == model::ShapeKind::kCapsule) {
    const Vector3 half(0.0, 0.0, shape.size.y() / 2);
    return {half, -half};
  }
  std::vector<Vector3> corners;
  for (int i = 0; i < 8; ++i) {
    const Vector3 sign((i & 1) != 0 ? 0.5 : -0.5, (i & 2) != 0 ? 0.5 : -0.5, (i & 4) != 0 ? 0.5 : -0.5);
    corners.push_back(shape.size.cwiseProduct(sign));
  }
  return corners;
}

}  // namespace

MotionBound::MotionBound(const model::RavenModel& raven, Arm arm)
    : raven_(raven), arm_(arm), positions_(raven.description.links.size()), poses_(raven.description.links.size()) {
  const std::vector<model::Link>& links = raven.description.links;
  const std::array<int, kJointCount>& moved = at(raven.links, arm);
  for (std::size_t j = 0; j < kJointCount; ++j) {
    slides_[j] = links[static_cast<std::size_t>(moved[j])].joint == model::JointKind::kPrismatic;
    for (int i = moved[j]; i >= 0; i = links[static_cast<std::size_t>(i)].parent) {
      const auto above = std::find(moved.begin(), moved.end(), i);
      if (above != moved.end()) carries_[static_cast<std::size_t>(above - moved.begin())][j] = true;
    }
  }
  for (std::size_t i = 0; i < links.size(); ++i) {
    int carrier = static_cast<int>(i);  // the nearest link up the chain that a joint of this arm moves
    while (carrier >= 0 && std::find(moved.begin(), moved.end(), carrier) == moved.end())
      carrier = links[static_cast<std::size_t>(carrier)].parent;
    if (carrier < 0) continue;
    const auto joint = std::find(moved.begin(), moved.end(), carrier) - moved.begin();
    addCorners(static_cast<std::size_t>(joint), static_cast<int>(i));
  }
  startFrom(raven.arms.geometry.home);
}

void MotionBound::addCorners(std::size_t joint, int link) {
  for (const model::CollisionShape& shape : raven_.description.links[static_cast<std::size_t>(link)].collisions) {
    const double radius = shape.kind == model::ShapeKind::kBox ? 0.0 : shape.size.x();
    for (const Vector3& corner : cornersOf(shape))
      corners_.push_back({joint, link, shape.X_LS * corner, radius});
  }
}

void MotionBound::startFrom(const JointArray& q) {
  from_ = q;
  raven_.linkPosesInWorld({q, q}, &positions_, &poses_);
  lever_.fill(0.0);
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const auto link = static_cast<std::size_t>(at(raven_.links, arm_)[j]);
    const Vector3 axis = poses_[link].R * raven_.description.links[link].axis.normalized();
    for (const Corner& corner : corners_) {
      if (!carries_[j][corner.joint]) continue;
      const Vector3 p = poses_[static_cast<std::size_t>(corner.link)] * corner.p_L - poses_[link].p;
      lever_[j] = std::max(lever_[j], slides_[j] ? 1.0 : p.cross(axis).norm() + corner.radius);
    }
  }
}

double MotionBound::operator()(const JointArray& q) const noexcept {
  double moved = 0.0, turned = 0.0;
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const double change = std::abs(q[j] - from_[j]);
    moved += lever_[j] * change;
    if (!slides_[j]) turned += change;
  }
  return turned < kMostTurned ? moved / (1.0 - turned) : std::numeric_limits<double>::infinity();
}

}  // namespace raven2_trainer::planning
