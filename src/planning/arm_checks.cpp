#include "planning/arm_checks.h"

#include <algorithm>

#include "planning/planning_problem.h"

namespace raven2_trainer::planning {
namespace {

/** [-] in the cube: how far from an end that is nearer than the clearance its edges are let off it. */
constexpr double kEndReach = 0.03;

/** Steps near such an end are so many times finer, for there is no clearance to cover what lies between them. */
constexpr double kFiner = 8.0;

}  // namespace

ArmChecks::ArmChecks(const model::RavenModel& raven,
                     const SceneObstacles& scene,
                     Arm arm,
                     double clearance,
                     double edge_step)
    : edge_step_(edge_step),
      space_(raven.arms.geometry, 0.0),
      near_(raven, scene, arm, clearance),
      bare_(raven, scene, arm, 0.0) {}

void ArmChecks::begin(const JointSpace& space, const JointArray& other) {
  space_ = space;
  near_.placeOther(other);
  bare_.placeOther(other);
  tight_ends_.clear();
}

bool ArmChecks::isFree(const UnitState& unit) {
  return !near_.touches(space_.toJoints(unit));
}

bool ArmChecks::isEdgeFree(const UnitState& a, const UnitState& b) {
  for (const UnitState& end : tight_ends_) {
    if (a != end && b != end) continue;
    return planning::isEdgeFree(a, b, edge_step_ / kFiner, [&](const UnitState& x) { return isFreeNear(end, x); });
  }
  return planning::isEdgeFree(a, b, edge_step_, [this](const UnitState& x) { return isFree(x); });
}

bool ArmChecks::isFreeNear(const UnitState& end, const UnitState& unit) {
  return isFree(unit) || (distance(end, unit) <= kEndReach && !touches(unit));
}

bool ArmChecks::touches(const UnitState& unit) {
  return bare_.touches(space_.toJoints(unit));
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

ClearanceFunction ArmChecks::clearanceFunction() {
  return {};
}

bool ArmChecks::isNear(const JointArray& q, const JointArray& other) {
  near_.placeOther(other);
  return near_.touches(q);
}

}  // namespace raven2_trainer::planning
