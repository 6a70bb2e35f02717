#include "clearance.h"

#include <algorithm>
#include <cmath>

#include "tool_hand.h"

namespace raven2_trainer::console {
namespace {

constexpr double kJawsApart = 0.0045;   ///< [m] from the middle of opened jaws to what must not touch them
constexpr double kShaftApart = 0.0055;  ///< [m] the same of a shaft of 4 mm radius
constexpr double kJawLength = 0.010;    ///< [m]
constexpr double kOffFloor = 0.0004;    ///< [m] of the jaws' tips

// A jaw is a box (raven2.urdf) with its inner face in the plane of the hinge; about as much is in three round rods.
constexpr double kJawThickness = 0.0015, kJawWidth = 0.0036;  ///< [m]

// A bar between open jaws is where they are 8.5 mm from the hinge, and has so much room on either side: aims err by
// half a millimetre, and tools are within 0.3 mm of their goals.
constexpr double kUsualReach = 0.0085, kRoomAtBar = 0.0013;  ///< [m]

double square(double x) noexcept {
  return x * x;
}

/** Place on the second line of the point nearest to the first line's `s`, and vice versa. */
double nearestShare(const Vector3& from, const Vector3& line, const Vector3& point) noexcept {
  const double length = line.squaredNorm();
  return length > 0.0 ? std::clamp((point - from).dot(line) / length, 0.0, 1.0) : 0.0;
}

/** Least distance of two line segments (Ericson, Real-Time Collision Detection, 5.1.9). */
double distanceOf(const Capsule& one, const Capsule& other) noexcept {
  const Vector3 d1 = one.b - one.a, d2 = other.b - other.a, r = one.a - other.a;
  const double a = d1.squaredNorm(), e = d2.squaredNorm(), b = d1.dot(d2), det = a * e - square(b);
  const double parallel = 1e-9 * a * e;
  double s = det > parallel ? std::clamp((b * d2.dot(r) - d1.dot(r) * e) / det, 0.0, 1.0) : 0.0;
  const double t = nearestShare(other.a, d2, one.a + s * d1);
  s = nearestShare(one.a, d1, other.a + t * d2);
  return (one.a + s * d1 - other.a - t * d2).norm();
}

/** Lowest of the jaws' tips, open and closed. */
double lowestTip(const Pose& X_WT, double opening) noexcept {
  double lowest = X_WT.p.z() + kJawLength * X_WT.R(2, 0);
  for (const double side : {-1.0, 1.0}) {
    const double angle = side * 0.5 * opening;
    lowest =
        std::min(lowest, X_WT.p.z() + kJawLength * (std::cos(angle) * X_WT.R(2, 0) + std::sin(angle) * X_WT.R(2, 1)));
  }
  return lowest;
}

/** In the tool's frame, turned by `angle` about the hinge, from the inner face towards `side`. */
Vector3 inJaw(double angle, const Vector3& p) noexcept {
  return Eigen::AngleAxisd(angle, Vector3::UnitZ()) * p;
}

double roomOfJaw(const Pose& X_WT, double side, double opening, const Surroundings& around) noexcept {
  constexpr double kRod = 0.5 * kJawThickness, kHalf = 0.5 * kJawWidth;
  const double angle = 0.5 * side * opening;
  double room = 1.0;
  for (const double z : {-kHalf, kHalf}) {
    for (const double y : {0.0, side * kJawThickness})
      room = std::min(room, (X_WT * inJaw(angle, {kJawLength, y, z})).z() - around.floor);
  }
  for (const double z : {kRod - kHalf, 0.0, kHalf - kRod}) {
    const Vector3 hinge = inJaw(angle, {kRod, side * kRod, z}), tip = inJaw(angle, {kJawLength - kRod, side * kRod, z});
    for (const Capsule& solid : around.solids)
      room = std::min(room, gapBetween({X_WT * hinge, X_WT * tip, kRod}, solid));
  }
  return room;
}

}  // namespace

double gapBetween(const Capsule& one, const Capsule& other) noexcept {
  return distanceOf(one, other) - one.radius - other.radius;
}

std::array<Capsule, 2> shapeOf(const ArmsConfig& arms, Arm arm, const Pose& X_WT) noexcept {
  const Vector3 rcm_W = toEigen(at(arms.rcm_W, arm));
  Vector3 towards_T = X_WT.inverse() * rcm_W;
  towards_T.z() = 0.0;  // the wrist turns about an axis across the jaws' hinge
  const Vector3 wrist = X_WT * Vector3(arms.geometry.lw * towards_T.normalized());
  return {Capsule{X_WT * Vector3(kJawLength, 0, 0), wrist, kJawsApart}, Capsule{wrist, rcm_W, kShaftApart}};
}

std::vector<Capsule> standingIn(const SceneRoles& roles) {
  std::vector<Capsule> solids;
  for (const ScenePeg& peg : roles.pegs) {
    const Vector3 foot = toEigen(peg.base_W);
    solids.push_back({foot, foot + Vector3(0, 0, peg.height - peg.radius), peg.radius});
  }
  for (const SceneWire& wire : roles.wires) {
    for (std::size_t i = 0; i + 1 < wire.line_W.size(); ++i)
      solids.push_back({toEigen(wire.line_W[i]), toEigen(wire.line_W[i + 1]), wire.radius});
  }
  return solids;
}

Capsule lyingAt(const SceneObject& object, const Vector3& p_W) noexcept {
  return {p_W, p_W, object.inner_radius + 2.0 * object.bar_radius};
}

double floorOf(const SceneRoles& roles) noexcept {
  double lowest = roles.pegs.empty() ? 0.0 : roles.pegs[0].base_W[2];
  for (const ScenePeg& peg : roles.pegs)
    lowest = std::min(lowest, peg.base_W[2]);
  return lowest;
}

double openFor(double bar_radius) noexcept {
  return 2.0 * std::asin(std::min(1.0, (bar_radius + kRoomAtBar) / kUsualReach));
}

bool isClear(const ArmsConfig& arms, Arm arm, const Pose& X_WT, const Surroundings& around) noexcept {
  if (lowestTip(X_WT, around.opening) < around.floor + kOffFloor) return false;
  const std::array<Capsule, 2> tool = shapeOf(arms, arm, X_WT);
  for (const Capsule& part : tool) {
    for (const Capsule& solid : around.solids) {
      if (gapBetween(part, solid) < 0.0) return false;
    }
  }
  if (!around.X_WT_other) return true;
  for (const Capsule& part : tool) {
    for (const Capsule& other : shapeOf(arms, otherArm(arm), *around.X_WT_other)) {
      if (gapBetween(part, other) < 0.0) return false;
    }
  }
  return true;
}

double roomOfJaws(const Pose& X_WT, const Surroundings& around) noexcept {
  double room = 1.0;
  for (const double share : {1.0, 0.5, 0.0}) {
    for (const double side : {-1.0, 1.0})
      room = std::min(room, roomOfJaw(X_WT, side, share * around.opening, around));
  }
  return room;
}

int blockedBetween(const ArmsConfig& arms,
                   Arm arm,
                   const Pose& from,
                   const Pose& to,
                   const Surroundings& around) noexcept {
  const PoseError way = errorOf(from, to);
  const int steps =
      std::max(1, static_cast<int>(std::ceil(std::max(way.distance / kStepLength, way.angle / kStepAngle))));
  int blocked = 0;
  for (int i = 1; i <= steps; ++i)
    blocked += isClear(arms, arm, between(from, to, static_cast<double>(i) / steps), around) ? 0 : 1;
  return blocked;
}

}  // namespace raven2_trainer::console
