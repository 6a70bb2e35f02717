#include "render/planned_path.h"

#include <algorithm>

#include "raven2_trainer/control/path_follower.h"
#include "raven2_trainer/control/tip_path.h"
#include "raven2_trainer/kinematics/eigen.h"
#include "render/primitives.h"

namespace raven2_trainer::render {

namespace {

constexpr float kTubeRadius = 0.0013F;  // [m] 4 pixels wide in the endoscope's live picture
constexpr int kTubeSides = 6;
constexpr double kPieceLength =
    0.004;  // [m] least of a drawn piece; an arc about the remote centre bends 0.03 mm in it

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
  const bool is_known = path != nullptr && id != 0 && path->id == id && index(path->arm) < kArmCount;
  return is_known ? path : nullptr;
}

PlannedPath::PlannedPath(const ArmGeometry& geometry, const Pose& X_WB, const PlanResult& plan) {
  const GuidePath tip = control::tipPath(geometry, plan);
  if (tip.count == 0) return;
  arrivals_.assign(plan.arrival.begin(), plan.arrival.begin() + plan.waypoint_count);
  pieces_ = plan.waypoint_count > 1 ? (tip.count - 1) / (plan.waypoint_count - 1) : 1;
  for (std::uint32_t i = 0; i < tip.count; ++i) {
    const Vector3 p_W = X_WB * toEigen(tip.points_B[i]);
    if (!p_W.allFinite()) continue;
    const bool is_stop = i % pieces_ == 0;
    if (is_stop) stops_.push_back(p_W);
    const double step = line_.empty() ? kPieceLength : (p_W - line_.back()).norm();
    // A stop ends its piece however short that is, or the tube would miss it; not where the tip only turns.
    if (step < kPieceLength && !(is_stop && step > 0.01 * kPieceLength)) continue;
    line_.push_back(p_W);
    places_.push_back(static_cast<double>(i));
  }
}

model::Mesh PlannedPath::tube() const {
  return makeTube(line_, kTubeRadius, kTubeSides);
}

/** Where the tip is on its path [pieces]: the time law of control::PathFollower. */
double PlannedPath::placeAt(double progress) const noexcept {
  if (arrivals_.size() < 2) return 0.0;
  const double time = std::clamp(progress, 0.0, 1.0) * arrivals_.back();
  std::size_t edge = 0;
  while (edge + 2 < arrivals_.size() && time >= arrivals_[edge + 1])
    ++edge;
  const double duration = arrivals_[edge + 1] - arrivals_[edge];
  const double blend = duration > 0.0 ? control::quinticBlend((time - arrivals_[edge]) / duration) : 1.0;
  return (static_cast<double>(edge) + blend) * pieces_;
}

std::uint32_t PlannedPath::trianglesBehind(double progress) const noexcept {
  const double place = placeAt(progress);
  const auto passed = std::count_if(places_.begin(), places_.end(), [=](double p) { return p <= place; });
  return 2 * kTubeSides * static_cast<std::uint32_t>(std::max<std::ptrdiff_t>(passed - 1, 0));
}

std::size_t PlannedPath::stopsBehind(double progress) const noexcept {
  if (stops_.empty() || !(progress > 0.0)) return 0;
  const double edges = placeAt(progress) / std::max(pieces_, 1U);
  return std::min(stops_.size(), static_cast<std::size_t>(std::max(edges, 0.0)) + 1);
}

}  // namespace raven2_trainer::render
