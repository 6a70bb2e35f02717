#include "planning/arm_checks.h"

#include <algorithm>
#include <iterator>

#include "planning/planning_problem.h"

namespace raven2_trainer::planning {
namespace {

/** [-] in the cube: how far from an end that is nearer than the clearance its edges are let off it. */
constexpr double kEndReach = 0.03;

/** Steps along such an edge are so many times finer than edge_step. Half of edge_step moves no point of a tool by more
 * than
 *  2 mm, the packaged clearance. Near the edge's end there is no clearance to cover the motion between two checks. */
constexpr double kFiner = 8.0;

}  // namespace

ArmChecks::ArmChecks(const model::RavenModel& raven,
                     const SceneObstacles& scene,
                     const DistanceGrid& grid,
                     Arm arm,
                     double clearance,
                     double edge_step,
                     const Poll& poll)
    : edge_step_(edge_step),
      space_(raven.arms.geometry, 0.0),
      kept_(raven, grid, arm, clearance, poll),
      bare_(raven, grid, arm, 0.0, poll),
      judge_(raven, scene, arm, 0.0) {}

void ArmChecks::begin(const JointSpace& space, const JointArray& other) {
  space_ = space;
  kept_.placeOther(other);
  bare_.placeOther(other);
  judge_.placeOther(other);
  tight_ends_.clear();
}

bool ArmChecks::isFree(const UnitState& unit) noexcept {
  return kept_.isFree(space_.toJoints(unit));
}

bool ArmChecks::isEdgeFree(const UnitState& a, const UnitState& b) {
  std::vector<UnitState> ends;  // of this edge: both may be tight
  std::copy_if(tight_ends_.begin(), tight_ends_.end(), std::back_inserter(ends),
               [&](const UnitState& end) { return a == end || b == end; });
  if (ends.empty()) return kept_.isEdgeFree(space_.toJoints(a), space_.toJoints(b));
  return planning::isEdgeFree(a, b, edge_step_ / kFiner, [&](const UnitState& x) { return isFreeNear(ends, x); });
}

bool ArmChecks::isFreeNear(const std::vector<UnitState>& ends, const UnitState& unit) {
  const auto is_near = [&unit](const UnitState& end) { return distance(end, unit) <= kEndReach; };
  return isFree(unit) || (std::any_of(ends.begin(), ends.end(), is_near) && !touches(unit));
}

bool ArmChecks::touches(const UnitState& unit) {
  return judge_.touches(space_.toJoints(unit));
}

bool ArmChecks::allowEnd(const UnitState& end) {
  if (isFree(end)) return true;
  if (touches(end)) return false;
  tight_ends_.push_back(end);
  return true;
}

bool ArmChecks::isAllowedEnd(const UnitState& unit) const {
  return std::find(tight_ends_.begin(), tight_ends_.end(), unit) != tight_ends_.end();
}

double ArmChecks::clearance(const JointArray& q, double cap) noexcept {
  return bare_.clearance(q, cap);
}

ClearanceFunction ArmChecks::clearanceFunction() {
  return [this](const UnitState& unit, double cap) { return bare_.clearance(space_.toJoints(unit), cap); };
}

}  // namespace raven2_trainer::planning
