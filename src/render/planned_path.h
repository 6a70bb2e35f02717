#pragma once

#include <cstdint>
#include <vector>

#include "raven2_trainer/kinematics/arms_config.h"
#include "raven2_trainer/model/mesh.h"
#include "raven2_trainer/render/scene.h"

namespace raven2_trainer::render {

/** The plan at hand: the one that may be executed, is executed, or whose path guides the hand. Null without a plan,
 *  if its answer is not known, or if the answer's arm or waypoints are invalid. */
const PlanResult* planAtHand(const Snapshot& snapshot) noexcept;

/** The way of a tool tip along a plan as it is drawn: a tube, and the places where the arm comes to rest. Safe for
 *  plans from damaged logs: points that are not finite are left out. */
class PlannedPath {
 public:
  PlannedPath() = default;
  /** @param[in] X_WB base of the plan's arm. Empty if the plan did not succeed, a tube without triangles if the tip
   * stays where it is. */
  PlannedPath(const ArmGeometry& geometry, const Pose& X_WB, const PlanResult& plan);

  /** In W [m]; triangles in the order of the path. */
  model::Mesh tube() const;
  /** [m] [@frame W] the tip at each waypoint, in their order. */
  const std::vector<Vector3>& stops() const noexcept { return stops_; }

  /** Where desired joints [rad; m] are on the path: 0 at its start, one more at every waypoint. For joints off the path
   * it is the nearest place. */
  double placeOf(const JointArray& q) const noexcept;
  /** Of the tube's triangles, those before a place. */
  std::uint32_t trianglesBefore(double place) const noexcept;
  /** Of the stops, those that an arm at this place has left; none at the start. */
  std::size_t stopsBefore(double place) const noexcept;

 private:
  std::vector<JointArray> waypoints_;
  std::vector<Vector3> line_, stops_;
  std::vector<double> places_;  // of the points of line_
};

}  // namespace raven2_trainer::render
