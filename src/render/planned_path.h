#pragma once

#include <cstdint>
#include <vector>

#include "raven2_trainer/core/config.h"
#include "raven2_trainer/model/mesh.h"
#include "raven2_trainer/render/scene.h"

namespace raven2_trainer::render {

/** The plan at hand: the one that may be executed, is executed, or whose path guides the hand. Null if there is none,
 *  or if its answer is not known. */
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

  /** Of the tube's triangles, those that the arm has left behind once this share of the path's time is gone.
   *  @param[in] progress [-] 0 to 1. */
  std::uint32_t trianglesBehind(double progress) const noexcept;
  /** The same of the stops. */
  std::size_t stopsBehind(double progress) const noexcept;

 private:
  double placeAt(double progress) const noexcept;

  std::vector<double> arrivals_;  // [s] at the waypoints
  std::uint32_t pieces_{0};       // of the tip's path to an edge
  std::vector<Vector3> line_, stops_;
  std::vector<double> places_;  // of each point of line_ on the tip's path [pieces]
};

}  // namespace raven2_trainer::render
