#pragma once

#include "planning/segment.h"
#include "raven2_trainer/model/robot_model.h"

namespace raven2_trainer::planning {

/** A placed convex collision shape. A capsule or sphere is all that lies within `radius` of `axis`; for a box those two
 *  are a capsule around it. Distances between solids are closed forms; none allocates. */
struct Solid {
  bool round{true};
  Segment axis;
  double radius{};                // [m]
  Pose X_WS;                      // boxes only
  Vector3 half{Vector3::Zero()};  // [m] half edges, boxes only
};

/**
 * @param[in] grow [m] added on every side: to the radius, or to each face of a box (its corners get a little farther).
 * @throw ModelException for a mesh: it has no clearance and no inside.
 */
Solid makeSolid(const model::Description& description,
                const model::Link& link,
                const model::CollisionShape& shape,
                const Pose& X_WL,
                double grow);

/** The same solid carried along by X. */
Solid moved(const Solid& solid, const Pose& X) noexcept;

/** Distance [m] of a point to the surface, exact; negative inside. */
double signedDistance(const Solid& solid, const Vector3& p) noexcept;

/** Distance [m] of a segment to a box, exact; 0 where it pierces it. The square is convex along the segment, and its
 *  slope is straight between the at most six places where the segment crosses the planes of the faces. */
double distanceToBox(const Segment& segment, const Pose& X_WS, const Vector3& half) noexcept;

/**
 * Lower bound [m] of the distance of two solids, positive exactly when they are apart. It is the distance where one is
 * round; for two boxes the widest gap along any of the 15 separating axes (Gottschalk et al. 1996). Not positive where
 * they overlap, without meaning then.
 */
double separation(const Solid& a, const Solid& b) noexcept;

}  // namespace raven2_trainer::planning
