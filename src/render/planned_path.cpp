#include "render/planned_path.h"

#include <algorithm>
#include <limits>

#include "raven2_trainer/control/tip_path.h"
#include "raven2_trainer/kinematics/eigen.h"
#include "render/primitives.h"

namespace raven2_trainer::render {

namespace {

constexpr float kTubeRadius = 0.0013F;  // [m] 4 pixels wide in the endoscope's live picture
constexpr int kTubeSides = 6;
constexpr double kPieceLength =
    0.004;  // [m] least of a drawn piece; an arc about the remote centre bends 0.03 mm in it

constexpr double kRounding = 1e-6;  // [edges] of a place at the very end of an edge

using Joints = Eigen::Matrix<double, kJointCount, 1>;

/** Joints such that a unit is about as far for each: the insertion moves by 0.1 m where the others turn by a radian. */
Joints scaled(const JointArray& q) noexcept {
  Joints out = Eigen::Map<const Joints>(q.data());
  out[kInsertion] *= 10.0;
  return out;
}

std::uint32_t planInForce(const ModelState& model) noexcept {
  switch (model.planning.status) {
    case PlanningStatus::kReady:
    case PlanningStatus::kArmed:
    case PlanningStatus::kExecuting:
      return model.planning.plan;
    default:
      return model.guide_plan;
  }
}

}  // namespace

const PlanResult* planAtHand(const Snapshot& snapshot) noexcept {
  const PlanResult* path = snapshot.plans.path.get();
  const std::uint32_t id = planInForce(snapshot.model);
  if (path == nullptr || id == 0 || path->id != id) return nullptr;
  const bool is_sound =
      index(path->arm) < kArmCount && path->waypoint_count > 0 && path->waypoint_count <= kMaxWaypoints;
  return is_sound ? path : nullptr;
}

PlannedPath::PlannedPath(const ArmGeometry& geometry, const Pose& X_WB, const PlanResult& plan) {
  const GuidePath tip = control::tipPath(geometry, plan);
  if (tip.count == 0) return;
  waypoints_.assign(plan.waypoints.begin(), plan.waypoints.begin() + plan.waypoint_count);
  const std::uint32_t pieces = plan.waypoint_count > 1 ? (tip.count - 1) / (plan.waypoint_count - 1) : 1;  // to an edge
  for (std::uint32_t i = 0; i < tip.count; ++i) {
    const Vector3 p_W = X_WB * toEigen(tip.points_B[i]);
    if (!p_W.allFinite()) continue;
    const bool is_stop = i % pieces == 0;
    if (is_stop) stops_.push_back(p_W);
    const double step = line_.empty() ? kPieceLength : (p_W - line_.back()).norm();
    // A stop ends its piece however short that is, or the tube would miss it; not where the tip only turns.
    if (step < kPieceLength && !(is_stop && step > 0.01 * kPieceLength)) continue;
    line_.push_back(p_W);
    places_.push_back(static_cast<double>(i) / pieces);
  }
}

model::Mesh PlannedPath::tube() const {
  return makeTube(line_, kTubeRadius, kTubeSides);
}

double PlannedPath::placeOf(const JointArray& q) const noexcept {
  double place = 0.0, least = std::numeric_limits<double>::max();
  for (std::size_t edge = 0; edge + 1 < waypoints_.size(); ++edge) {
    const Joints from = scaled(waypoints_[edge]), along = scaled(waypoints_[edge + 1]) - from;
    const double length = along.squaredNorm();
    const double share = length > 0.0 ? std::clamp(along.dot(scaled(q) - from) / length, 0.0, 1.0) : 0.0;
    const double distance = (from + share * along - scaled(q)).squaredNorm();
    if (!(distance < least)) continue;  // false for NaN
    least = distance;
    place = static_cast<double>(edge) + share;
  }
  return place;
}

std::uint32_t PlannedPath::trianglesBefore(double place) const noexcept {
  const auto passed = std::count_if(places_.begin(), places_.end(), [=](double p) { return p <= place + kRounding; });
  return 2 * kTubeSides * static_cast<std::uint32_t>(std::max<std::ptrdiff_t>(passed - 1, 0));
}

std::size_t PlannedPath::stopsBefore(double place) const noexcept {
  if (!(place > kRounding)) return 0;
  const double left = std::min(place + kRounding, static_cast<double>(kMaxWaypoints));
  return std::min(stops_.size(), static_cast<std::size_t>(left) + 1);
}

}  // namespace raven2_trainer::render
